"""Residuals of own images that a servo predicts, and the velocity of the demonstrator's images meanwhile."""

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..geometry.affine import MIN_POINTS, image_unit
from ..geometry.handedness import Handedness, principal_axes
from ..geometry.rectification import AFFINE_DEGREES_OF_FREEDOM, Rectification, affine_squared_error, rectify_affine
from .noise import HomographyWeighting, affine_whitening
from .rectification import fit_transfer
from .residuals import NoiseReference, ResidualFunction
from .transfers.registry import TRANSFERS, TransferMethod
from .transfers.transfer import FittedTransfer, is_whitened
from .views import FourViews, unique_matches

VELOCITY_LOOKS = 3  # two displacements
AT_REST = np.zeros(())
HOMOGRAPHY_MIN_POINTS = 8  # five determine a homography of space; more are needed to show their noise
AFFINE_RMS = 1.5  # rms distance from an affine geometry, over the noise, of matches that fit one
MIN_NOISE = 1e-3  # image units: a smaller noise counts as this


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

    Without a reference they are those of the transfer, and E of the own images as seen is `Observation.E`. With one,
    `HomographyWeighting` whitens them if the geometry of the stereo head is known and the transfer is a homography of
    space. Otherwise they are whitened as affine cameras propagate noise.

    Behind a demonstrator that moves and is seen with noise, the transfer of the last convergence is used (Section 5.4
    of the paper). A transfer that was fitted again at each distant posture would add its own noise.

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
    past : sequence of FourViews
        Looks whose matches determine the head's geometry, besides this one.
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
        past: Sequence[FourViews] = (),
        mirror_columns: bool = True,
    ):
        self.views: FourViews = views
        self.method: TransferMethod = method
        self.rectification: Rectification | None = rectification
        self.noise_px: float = noise_px
        self.demo: NDArray[np.float64] = views.demo + velocity
        self._in_both = np.asarray(views.visible[:, :2].all(-1))
        self._velocity, self._past, self._mirror_columns = velocity, past, mirror_columns
        self._converged = converged if noise_px > 0 and velocity.any() else None
        self._affine_weights: dict[tuple[bytes, float, bytes], NDArray[np.float64]] = {}
        self._rigs: dict[int, ResidualFunction] = {}
        self._handedness: dict[bytes, Handedness | None] = {}

    def __call__(
        self,
        own: NDArray[np.float64],
        transfer: str | None = None,
        noise_reference: NoiseReference | None = None,
        rig: int = 0,
    ) -> NDArray[np.float64]:
        """Compute the residuals, see `ResidualFunction`."""
        if rig:
            return self._of_rig(rig)(own, transfer, noise_reference)
        finite, in_both = np.isfinite(own), self._in_both
        known = in_both if finite.all() else in_both & finite.all(-1).reshape(-1, len(in_both)).all(0)
        count = np.count_nonzero(known)
        if count < MIN_POINTS:  # nothing can be predicted for such images: they are to be avoided
            return np.full((*own.shape[:-2], 1, 4), np.inf)
        views = FourViews(self.demo, own, self.views.visible)
        views = views if count == len(known) else views.select(known)
        e, mirrored = self._residual(views, known, transfer, noise_reference), self.mirror_residual(views.own, known)
        return e if mirrored is None else np.concatenate([e, mirrored], -1)

    def with_partially_visible(self) -> ResidualFunction:
        return PartialPointResiduals(self)

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

    @cached_property
    def head_rectification(self) -> Rectification | None:
        """The rectification in use, else that of the affine geometry of all matches; None if they have none."""
        if self.rectification is not None:
            return self.rectification
        matches = unique_matches([*self._past, self.views])
        left, right = matches[:, :2], matches[:, 2:]
        max_rms = AFFINE_RMS * max(self.noise_px, MIN_NOISE * image_unit(matches))
        fits = affine_squared_error(left, right) < (len(left) - AFFINE_DEGREES_OF_FREEDOM) * max_rms**2
        return rectify_affine(left, right) if fits else None

    def _residual(
        self,
        views: FourViews,
        known: NDArray[np.bool_],
        transfer: str | None,
        reference: NoiseReference | None,
    ) -> NDArray[np.float64]:
        """(..., n, C) px of views of the known points, (N,) bool."""
        if reference is not None and transfer is None and self._converged is None and self._by_homography is not None:
            if len(views.demo) >= HOMOGRAPHY_MIN_POINTS:
                return self._by_homography.of(views, known, reference).residual(views)
        if transfer or self._converged is None:
            fitted = fit_transfer(TRANSFERS[transfer] if transfer else self.method, views, self.rectification)
        else:
            fitted = self._converged
        e = fitted.residual(views)
        if reference is None or reference.own is None or is_whitened(fitted):
            return e
        return e @ self._affine_weight(views.with_own(reference.own[known]), reference.own_variance_ratio)

    @cached_property
    def _by_homography(self) -> HomographyWeighting | None:
        """None if the transfer is no homography of space, or the geometry of the stereo head is unknown."""
        if not self.method.homography_of_space or self.head_rectification is None:
            return None
        return HomographyWeighting(self.head_rectification, self.noise_px)

    def _affine_weight(self, views: FourViews, own_variance_ratio: float) -> NDArray[np.float64]:
        key = views.own.tobytes(), own_variance_ratio, views.demo.tobytes()
        if key not in self._affine_weights:
            self._affine_weights[key] = affine_whitening(views, own_variance_ratio)
        return self._affine_weights[key]

    def _rectified(self, images: NDArray[np.float64]) -> NDArray[np.float64]:
        return images if self.rectification is None else self.rectification.apply(images)

    def _of_rig(self, rig: int) -> ResidualFunction:
        if rig not in self._rigs:
            assert self.rectification is not None
            self._rigs[rig] = PredictedResiduals(
                self.views,
                self.method,
                self.rectification.perturbed[rig - 1],
                noise_px=self.noise_px,
                velocity=self._velocity,
                converged=self._converged,
                mirror_columns=self._mirror_columns,
            )
        return self._rigs[rig]


class PartialPointResiduals:
    """Residuals of all points of which at least one camera sees the demonstrator.

    Matches of points that both cameras see can be tested for outliers; the image of a point that one camera alone sees
    cannot. So these points are used last. Other transfers than the chosen one use the points that both cameras see.
    """

    def __init__(self, complete: PredictedResiduals):
        self._complete, self._visible = complete, complete.views.visible
        head = complete.rectification or rectify_affine(*np.split(np.concatenate(complete.views.matches), 2, axis=1))
        self._by_rig = [HomographyWeighting(one, complete.noise_px) for one in (head, *head.perturbed)]

    def __call__(
        self,
        own: NDArray[np.float64],
        transfer: str | None = None,
        noise_reference: NoiseReference | None = None,
        rig: int = 0,
    ) -> NDArray[np.float64]:
        """Compute the residuals, see `ResidualFunction`."""
        if transfer is not None:
            return self._complete(own, transfer, noise_reference, rig)
        visible = self._visible[:, :2]
        known = np.asarray(visible.any(1) & np.isfinite(own).all(-1).reshape(-1, len(visible)).all(0))
        in_both = known & visible.all(1)
        if np.count_nonzero(in_both) < MIN_POINTS:
            return np.full((*own.shape[:-2], 1, 4), np.inf)
        views = FourViews(self._complete.demo, own, self._visible).select(known)
        e = self._by_rig[rig].of(views, known, noise_reference).residual(views)
        mirrored = self._complete.mirror_residual(own[..., in_both, :], in_both)
        if mirrored is None:
            return e
        columns = np.zeros((*e.shape[:-1], mirrored.shape[-1]))
        columns[..., in_both[known], :] = mirrored
        return np.concatenate([e, columns], -1)

    def with_partially_visible(self) -> ResidualFunction:
        return self
