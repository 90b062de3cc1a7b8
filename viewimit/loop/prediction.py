"""The conflict that own images would have which a servo predicts, and how the demonstrator drifts meanwhile."""

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..estimation.residuals import NoiseReference, ResidualFunction, conflict
from ..estimation.transfers.noise import noise_weight
from ..estimation.transfers.transfer import Residuals, TransferMethod
from ..estimation.views import FourViews
from ..geometry.affine import MIN_POINTS, image_unit
from ..geometry.handedness import Handedness, principal_axes
from ..geometry.rectification import AFFINE_FREEDOM, Rectification, affine_squares, level
from .rectifying import pooled
from .snapshot import Snapshot

DRIFT_MOMENTS = 3  # two displacements
NO_DRIFT = np.zeros(())
NEAR_SHARE = 1e-3  # of the demonstrator's mean square
NEAR_NOISE = 400.0  # times the noise's square: weighted E up to which own images are near enough for exact weights
NEAR_POINTS = 8  # five determine a homography of space; their noise shows in more
AFFINE = 1.5  # times the noise: rms distance from an affine geometry that matches have which fit one
LEAST_NOISE_PX = 1e-3  # of typical images, in place of a smaller noise
Weights = tuple[bytes, float, bytes]  # own images and their share of noise, and which of their points are known


def demo_drift(moments: Sequence[Snapshot]) -> NDArray:
    """(N, 4) px, or () for 0: how far the demonstrator's points go in the next motion, if they have gone on during the
    last two; 0 of points that were not seen at all of these. moments: the last DRIFT_MOMENTS, the present one last.

    One jump is no drift: both displacements must point the same way.
    """
    recent = [moment.views.demo for moment in moments]
    if len(recent) < DRIFT_MOMENTS or recent[1] is recent[2]:  # it was not even looked at again
        return NO_DRIFT
    seen = np.all([moment.views.visible[:, :2].all(-1) for moment in moments], axis=0)
    before, last = np.where(seen[:, None], np.diff(recent, axis=0), 0.0)
    return last if np.vdot(before, last) > 0 else NO_DRIFT


class DemoResiduals:
    """Residuals of the demonstrator's images by one geometry of the head, for any noise reference.

    About own images that are near enough to the demonstrator's they are weighted exactly; elsewhere, and where no own
    images are given, all points alike.
    """

    def __init__(self, method: TransferMethod, head: Rectification, noise_px: float):
        assert method.near is not None and method.half_seen is not None
        self._exactly, self._alike = method.near, method.half_seen
        self._head, self._noise_px = head, noise_px
        self._weighted: dict[Weights, Residuals] = {}

    def of(self, views: FourViews, points: NDArray, noise_reference: NoiseReference | None) -> Residuals:
        """What gives the residuals of views of some points, (N,) bool."""
        if noise_reference is None or noise_reference.own is None:
            return self._alike(views, self._head)
        about = noise_reference.own.tobytes(), noise_reference.own_variance_ratio, points.tobytes()
        if about not in self._weighted:  # a servo asks about many images with the same weights
            self._weighted[about] = self._about(
                views.with_own(noise_reference.own[points]), noise_reference.own_variance_ratio
            )
        return self._weighted[about]

    def _about(self, views: FourViews, own_variance_ratio: float) -> Residuals:
        alike = self._alike(views, self._head)
        E, demo = float(conflict(alike.residual(views))), views.demo[views.visible[:, :2].all(1)]
        near = max(NEAR_SHARE * float(demo.var(0).sum()), NEAR_NOISE * self._noise_px**2)
        return self._exactly(views, self._head, own_variance_ratio) if E < near else alike


class _Answers:
    """What was found already, at moments at which all was as it is now but the own images: a servo asks about all its
    visits at every motion."""

    def __init__(self, now: Snapshot, moments: Sequence[Snapshot]):
        self._now, self._moments = now, moments

    @cached_property
    def _known(self) -> dict[bytes, NDArray]:
        """Residuals (N, 4) px by the own images of a moment."""
        now = self._now
        if now.transfer is None or not now.views.complete:
            return {}
        alike = (
            moment
            for moment in self._moments
            if _equal(moment.views.demo, now.views.demo)
            and _equal(moment.views.visible, now.views.visible)
            and moment.rectification is now.rectification
            and moment.settings.transfer == now.settings.transfer
        )
        return {_image_key(moment.views.own): moment.residual for moment in alike}

    def to(self, own: NDArray) -> NDArray | None:
        """Residuals (n, N, 4) px of own images (n, N, 4) px; None if one of them was seen at none of the moments."""
        found: list[NDArray] = []
        for image in own:
            e = self._known.get(_image_key(image))
            if e is None:
                return None
            found.append(e)
        return np.array(found) if found else None


def _equal(one: NDArray, other: NDArray) -> bool:
    """Mostly the same array; not where a session was resumed."""
    return one is other or np.array_equal(one, other)


def _image_key(own: NDArray) -> bytes:
    """Equal for images that differ by no more than rounding, as those that a servo keeps in units of its own."""
    return own.astype(np.float32).tobytes()


class PredictedResiduals:
    """What a servo may ask: residuals (..., n, C) px that own images (..., N, 4) px would have against the
    demonstrator as now seen, and displaced by `drift`, (N, 4) px; both rectified as now, if at all.

    Of the n points that are known in all of them; by the transfer chosen or by another one's name; weighted by noise,
    as `DemoResiduals` where the head's geometry is known, else as affine cameras spread it; rectified as for another
    `rig`, if one is named. With fewer points than a transfer needs they are infinite. Own images that only a mirror
    image of the demonstrator fits have further columns: what a fit that may not reflect leaves. Behind a moving
    demonstrator seen with noise, noise_px > 0, the transfer of the last convergence serves (Section 5.4): fitted anew
    at postures apart it would add its own noise to theirs. moments: of the history, whose own images may be asked about
    again.
    """

    def __init__(
        self, now: Snapshot, drift: NDArray = NO_DRIFT, noise_px: float = 0.0, moments: Sequence[Snapshot] = ()
    ):
        self._now, self._drift, self._noise_px = now, drift, noise_px
        self._demo = now.views.demo + drift
        self._demo_seen = np.asarray(now.views.visible[:, :2].all(-1))
        self._frozen = now.converged_transfer if noise_px > 0 and drift.any() else None
        self._moments = moments
        self._answers = _Answers(now, () if drift.any() else moments)
        self._affine_weights: dict[Weights, NDArray] = {}
        self._rigs: dict[int, ResidualFunction] = {}
        self._handedness: dict[bytes, Handedness | None] = {}

    def __call__(
        self, own: NDArray, transfer: str | None = None, noise_reference: NoiseReference | None = None, rig: int = 0
    ) -> NDArray:
        if rig:
            return self._of_rig(rig)(own, transfer, noise_reference)
        told = np.isfinite(own)
        seen = self._demo_seen
        known = seen if told.all() else seen & told.all(-1).reshape(-1, len(seen)).all(0)
        count = np.count_nonzero(known)
        if count < MIN_POINTS:  # nothing can be told of such images: they are to be avoided
            return np.full((*own.shape[:-2], 1, 4), np.inf)
        imagined = FourViews(self._demo, own, self._now.views.visible)
        imagined = imagined if count == len(known) else imagined.select(known)
        e, mirrored = (
            self._residual(imagined, known, transfer, noise_reference),
            self.mirror_residual(imagined.own, known),
        )
        return e if mirrored is None else np.concatenate([e, mirrored], -1)

    def with_partially_visible(self) -> ResidualFunction:
        return PartialPointResiduals(self, self._now, self._demo, self._noise_px)

    def mirror_residual(self, own: NDArray, points: NDArray) -> NDArray | None:
        """As `Handedness.mirror_residual`, of own images (..., n, 4) px of the points (N,) bool, which both cameras
        see."""
        key = points.tobytes()
        if key not in self._handedness:
            self._handedness[key] = self._handedness_of(points)
        handedness = self._handedness[key]
        return None if handedness is None else handedness.mirror_residual(self._rectified(own))

    @cached_property
    def head(self) -> Rectification | None:
        """The stereo head's geometry: rectification, if images ask for it, or else that of the affine geometry that all
        matches fit; None if they fit none."""
        now = self._now
        if now.rectification is not None:
            return now.rectification
        matches = pooled([*(moment.views for moment in self._moments), now.views])
        left, right = matches[:, :2], matches[:, 2:]
        most = AFFINE * max(self._noise_px, LEAST_NOISE_PX * image_unit(matches))
        fits = affine_squares(left, right) < (len(left) - AFFINE_FREEDOM) * most**2
        return level(left, right) if fits else None

    def _residual(
        self, views: FourViews, known: NDArray, transfer: str | None, noise_reference: NoiseReference | None
    ) -> NDArray:
        """(..., n, C) px of views of the known points, (N,) bool."""
        if transfer is None and noise_reference is None:
            answered = self._answers.to(views.own) if views.own.ndim == 3 else None
            if answered is not None:
                return answered
        if noise_reference is not None and transfer is None and self._frozen is None and self._of_demo is not None:
            if len(views.demo) >= NEAR_POINTS:
                return self._of_demo.of(views, known, noise_reference).residual(views)
        fitted = self._now.fit(views, transfer) if transfer or self._frozen is None else self._frozen
        e = fitted.residual(views)
        if noise_reference is None or noise_reference.own is None or fitted.weighs_noise:
            return e
        return e @ self._affine_weight(views.with_own(noise_reference.own[known]), noise_reference.own_variance_ratio)

    @cached_property
    def _of_demo(self) -> DemoResiduals | None:
        """None if the transfer has no such residuals, or the head's geometry is unknown."""
        method = self._now.method
        if method.near is None or self.head is None:
            return None
        return DemoResiduals(method, self.head, self._noise_px)

    def _affine_weight(self, views: FourViews, own_variance_ratio: float) -> NDArray:
        about = views.own.tobytes(), own_variance_ratio, views.demo.tobytes()
        if about not in self._affine_weights:
            self._affine_weights[about] = noise_weight(views, own_variance_ratio)
        return self._affine_weights[about]

    def _handedness_of(self, points: NDArray) -> Handedness | None:
        """Of the demonstrator's points, (N,) bool, that both cameras see."""
        views = self._now.views
        axes = principal_axes(self._rectified(np.concatenate(views.matches)))
        return Handedness.of(self._rectified(self._demo[points]), axes, self._noise_px)

    def _rectified(self, images: NDArray) -> NDArray:
        by = self._now.rectification
        return images if by is None else by.apply(images)

    def _of_rig(self, rig: int) -> ResidualFunction:
        if rig not in self._rigs:
            assert self._now.rectification is not None
            other = self._now.with_fields(rectification=self._now.rectification.others[rig - 1])
            self._rigs[rig] = PredictedResiduals(other, self._drift, self._noise_px)
        return self._rigs[rig]


class PartialPointResiduals:
    """The predicted conflict of all points of which the demonstrator shows one image at least.

    Points that both cameras see can be held against each other before anything is concluded from them; the image of a
    point that one camera alone sees cannot. So these are asked last. whole: of points that both cameras see, which
    answers for other transfers; demo: (N, 4) px, what is asked; noise_px: of an image coordinate, standard deviation.
    """

    def __init__(self, whole: PredictedResiduals, now: Snapshot, demo: NDArray, noise_px: float):
        self._whole, self._demo, self._visible = whole, demo, now.views.visible
        head = now.rectification or level(*np.split(np.concatenate(now.views.matches), 2, axis=1))
        method = now.method
        self._by_rig = [DemoResiduals(method, one, noise_px) for one in (head, *head.others)]

    def __call__(
        self, own: NDArray, transfer: str | None = None, noise_reference: NoiseReference | None = None, rig: int = 0
    ) -> NDArray:
        if transfer is not None:
            return self._whole(own, transfer, noise_reference, rig)
        shown = self._visible[:, :2]
        known = shown.any(1) & np.isfinite(own).all(-1).reshape(-1, len(shown)).all(0)
        in_both = known & shown.all(1)
        if np.count_nonzero(in_both) < MIN_POINTS:
            return np.full((*own.shape[:-2], 1, 4), np.inf)
        views = FourViews(self._demo, own, self._visible).select(known)
        e = self._by_rig[rig].of(views, known, noise_reference).residual(views)
        mirrored = self._whole.mirror_residual(own[..., in_both, :], in_both)
        if mirrored is None:
            return e
        columns = np.zeros((*e.shape[:-1], mirrored.shape[-1]))
        columns[..., in_both[known], :] = mirrored
        return np.concatenate([e, columns], -1)

    def with_partially_visible(self) -> ResidualFunction:
        return self
