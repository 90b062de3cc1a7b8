"""Residuals e of the own image points, and their conflict E (Eq. (6) and Section 3 of the paper).

N points of the body are matched by index. Residuals are of the n points that all images concerned show. Each has C
coordinates: 4 for the own images [L, R], or 8 for a transfer that fits the demonstrator's images as well.

Which residuals are used where
------------------------------
- `FittedTransfer.residual`: own minus recovered points. Its squares make `Snapshot.E`, `Observation.E`, landscapes and
  the paper's figures.
- `ResidualFunction`: the same for own images that a servo predicts. At the images as seen,
  `conflict(residuals(observation.own))` is `Observation.E`.
- `Handedness.mirror_residual`: three more columns, in which own images that only a mirror image fits are not 0. Only
  servos with `ServoMethod.mirror_columns` get them.
"""

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


class ResidualFunction(Protocol):
    """Residuals of own images that a servo predicts, against the demonstrator as now seen. It moves nothing."""

    def __call__(self, own: NDArray[np.float64]) -> NDArray[np.float64]:
        """Compute the residuals of own images.

        Parameters
        ----------
        own : (..., N, 4) array
            Predicted points in [L, R] [px]; NaN for points that the servo cannot predict. A point that is NaN in one
            of a batch of images is left out of all of them.

        Returns
        -------
        (..., n, C) array
            Residuals [px] of the n points that both cameras see of the demonstrator and that are not NaN in `own`, in
            their order. C is 4, and 8 for the transfer "rank3". With fewer than 5 points, one
            infinite row of 4: (..., 1, 4). For a servo with `ServoMethod.mirror_columns`, a batch in which some image
            fits only a mirror image has 3 more columns.
        """
        ...
