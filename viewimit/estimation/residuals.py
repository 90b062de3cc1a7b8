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

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..geometry.affine import MIN_POINTS
from ..geometry.handedness import Handedness, principal_axes
from ..geometry.rectification import Rectification
from .rectification import fit_transfer
from .transfers.transfer import FittedTransfer, TransferMethod
from .views import FourViews

VELOCITY_LOOKS = 3  # two displacements
AT_REST = np.zeros(())


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


def target_velocity(looks: Sequence[FourViews]) -> NDArray[np.float64]:
    """Predict how far the demonstrator's points move in the next motion. looks: the last VELOCITY_LOOKS, the present
    one last. Returns (N, 4), last displacement [px] if the one before points the same way; one jump is no velocity. 0
    for points that were not visible in all looks, and () for a demonstrator at rest."""
    demo = [views.demo for views in looks]
    if len(demo) < VELOCITY_LOOKS or demo[1] is demo[2]:  # the same array: it was not even looked at again
        return AT_REST
    visible = np.all([views.visible[:, :2].all(-1) for views in looks], axis=0)
    before, last = np.where(visible[:, None], np.diff(demo, axis=0), 0.0)
    return last if np.vdot(before, last) > 0 else AT_REST


class PredictedResiduals:
    """A `ResidualFunction`: residuals of own images against the demonstrator of one look.

    E of the own images as seen is `Observation.E`. Behind a demonstrator that moves and is seen with noise, the
    transfer of the last convergence is used (Section 5.4 of the paper). A transfer that was fitted again at each
    distant posture would add its own noise.

    Parameters
    ----------
    views : FourViews
        The look, N points.
    method : TransferMethod
        The chosen transfer.
    rectification : Rectification, optional
        Of all images; None for images as they are.
    noise_px : float
        Standard deviation of an image coordinate [px].
    velocity : (N, 4) array or ()
        Displacement of the demonstrator's points until the next look [px], `target_velocity`.
    converged : FittedTransfer, optional
        The transfer at the last convergence.
    mirror_columns : bool
        Whether own images that fit only a mirror image of the demonstrator have three further columns, as
        `ServoMethod.mirror_columns` says. They hold the additional residuals of the best fit that does not reflect.
    """

    def __init__(
        self,
        views: FourViews,
        method: TransferMethod,
        rectification: Rectification | None = None,
        *,
        noise_px: float = 0.0,
        velocity: NDArray[np.float64] = AT_REST,
        converged: FittedTransfer | None = None,
        mirror_columns: bool = True,
    ):
        self.views: FourViews = views
        self.method: TransferMethod = method
        self.rectification: Rectification | None = rectification
        self.noise_px: float = noise_px
        self.demo: NDArray[np.float64] = views.demo + velocity
        self._in_both = np.asarray(views.visible[:, :2].all(-1))
        self._mirror_columns = mirror_columns
        self._converged = converged if noise_px > 0 and velocity.any() else None
        self._handedness: dict[bytes, Handedness | None] = {}

    def __call__(self, own: NDArray[np.float64]) -> NDArray[np.float64]:
        """Compute the residuals, see `ResidualFunction`."""
        finite, in_both = np.isfinite(own), self._in_both
        known = in_both if finite.all() else in_both & finite.all(-1).reshape(-1, len(in_both)).all(0)
        count = np.count_nonzero(known)
        if count < MIN_POINTS:  # nothing can be predicted for such images: they are to be avoided
            return np.full((*own.shape[:-2], 1, 4), np.inf)
        views = FourViews(self.demo, own, self.views.visible)
        views = views if count == len(known) else views.select(known)
        fitted = fit_transfer(self.method, views, self.rectification) if self._converged is None else self._converged
        e, mirrored = fitted.residual(views), self.mirror_residual(views.own, known)
        return e if mirrored is None else np.concatenate([e, mirrored], -1)

    def mirror_residual(self, own: NDArray[np.float64], points: NDArray[np.bool_]) -> NDArray[np.float64] | None:
        """Compute `Handedness.mirror_residual` of own images (..., n, 4) px; None without such columns.

        points: (N,) bool, the n points; both cameras see them.
        """
        if not self._mirror_columns:
            return None
        key = points.tobytes()
        if key not in self._handedness:
            axes = principal_axes(self._rectified(np.concatenate(self.views.matches)))
            self._handedness[key] = Handedness.from_images(self._rectified(self.demo[points]), axes, self.noise_px)
        handedness = self._handedness[key]
        return None if handedness is None else handedness.mirror_residual(self._rectified(own))

    def _rectified(self, images: NDArray[np.float64]) -> NDArray[np.float64]:
        return images if self.rectification is None else self.rectification.apply(images)
