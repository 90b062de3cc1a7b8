"""Residuals e of the own image points, and their conflict E (Eq. (6) and Section 3 of the paper).

N points of the body are matched by index. Residuals are of the n points that all images concerned show. Each has C
coordinates: 4 for the own images [L, R], or 8 for a transfer that fits the demonstrator's images as well.

Which residuals are used where
------------------------------
- `FittedTransfer.residual`: own minus recovered points. Its squares make `Snapshot.E`, `Observation.E`, landscapes and
  the paper's figures.
- `ResidualFunction` without a reference: the same for own images that a servo predicts. At the images as seen,
  `conflict(residuals(observation.own))` is `Observation.E`.
- `ResidualFunction` with a `NoiseReference`: for the final approach and the certificate of the trust region. A transfer
  that is a homography of space then has its residuals in the demonstrator's images (`HomographyResiduals`); that of
  any other is unchanged. With images in the reference, both are whitened. E of these differs from `Observation.E`.
- `Handedness.mirror_residual`: three more columns, in which own images that only a mirror image fits are not 0. Only
  servos with `ServoMethod.mirror_columns` get them.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray


def conflict(e: NDArray[np.float64]) -> NDArray[np.float64]:
    """Compute E = 1/(2N) Σ (|e_L|² + |e_R|²), Eq. (6).

    Parameters
    ----------
    e : (..., N, C) array
        Residuals of N points with C coordinates each [px].

    Returns
    -------
    (...) array
        E [px²].
    """
    return np.einsum("...ij,...ij->...", e, e) / (2 * e.shape[-2])


@dataclass(frozen=True)
class NoiseReference:
    """Asks for residuals whose noise is known, and says about which own images it is propagated.

    Whitened residuals at the true posture have the variance of the noise, in every scene. Even `NoiseReference()`,
    without images, changes the residuals: those of a homography of space are then in the demonstrator's images.
    """

    own: NDArray[np.float64] | None = None  # (N, 4) px; None: there are none yet, so that all points have equal weights
    own_variance_ratio: float = 0.0  # κ: variance of the compared own images over that of the demonstrator's


class ResidualFunction(Protocol):
    """Residuals of own images that a servo predicts, against the demonstrator as now seen. It moves nothing."""

    def __call__(
        self,
        own: NDArray[np.float64],
        transfer: str | None = None,
        noise_reference: NoiseReference | None = None,
        rig: int = 0,
    ) -> NDArray[np.float64]:
        """Compute the residuals of own images.

        Parameters
        ----------
        own : (..., N, 4) array
            Predicted points in [L, R] [px]; NaN for points that the servo cannot predict. A point that is NaN in one
            of a batch of images is left out of all of them.
        transfer : str, optional
            Name of a transfer to use instead of the chosen one.
        noise_reference : NoiseReference, optional
            Compute residuals with known noise instead, see `NoiseReference`. By default the transfer's own.
        rig : int, optional
            Hypothesis about the stereo head: 0 for its estimate, 1 to `Observation.n_rig_hypotheses` for the others.

        Returns
        -------
        (..., n, C) array
            Residuals [px] of the n points that both cameras see of the demonstrator and that are not NaN in `own`, in
            their order. C is 4, and 8 for the transfer "rank3" without a reference. With fewer than 5 points, one
            infinite row of 4: (..., 1, 4). For a servo with `ServoMethod.mirror_columns`, a batch in which some image
            fits only a mirror image has 3 more columns.
        """
        ...

    def with_partially_visible(self) -> "ResidualFunction":
        """Include the demonstrator's points that only one camera sees, after all others."""
        ...
