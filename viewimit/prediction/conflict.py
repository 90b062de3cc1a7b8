"""The conflict of points that both cameras see of the demonstrator, and how these drift."""

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..geometry.affine import MIN_POINTS
from ..servo.observation import Conflict
from ..snapshot import Snapshot
from ..transfer.noise import noise_weight
from ..transfer.transfer import Residuals
from ..views import FourViews
from .half_seen import HalfSeenConflict

DRIFT_MOMENTS = 3  # two displacements
NO_DRIFT = np.zeros(())
NEAR, NEAR_NOISE = 4.0, 1600.0  # px²; times the noise's square: E up to which own images are near the demonstrator's
Likeness = tuple[bytes, bytes]  # own images, and which of their points are known
NEAR_POINTS = 8  # a homography of space is told by five; it takes more to tell their noise


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


def _near(now: Snapshot, views: FourViews, noise_px: float) -> Residuals | None:
    """What weighs noise best near own images of one posture, if the transfer has such and they are near enough."""
    near = now.method.near
    if near is None or now.rectification is None or len(views.own) < NEAR_POINTS:
        return None
    E = float(now.fit(views).conflict(views))
    return near(views, now.rectification) if E < _nearest(noise_px) else None


def _nearest(noise_px: float) -> float:
    """px², E up to which own images are near the demonstrator's."""
    return max(NEAR, NEAR_NOISE * noise_px**2)


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
            if moment.views.demo is now.views.demo
            and moment.views.visible is now.views.visible
            and moment.rectification is now.rectification
            and moment.settings.transfer == now.settings.transfer
        )
        return {moment.views.own.tobytes(): moment.residual for moment in alike}

    def to(self, own: NDArray) -> NDArray | None:
        """Residuals (n, N, 4) px of own images (n, N, 4) px; None if one of them was seen at none of the moments."""
        found: list[NDArray] = []
        for image in own:
            e = self._known.get(image.tobytes())
            if e is None:
                return None
            found.append(e)
        return np.array(found) if found else None


class PredictedConflict:
    """What a servo may ask: residuals (..., n, C) px that own images (..., N, 4) px would have against the
    demonstrator as now seen, and displaced by `drift`, (N, 4) px; both rectified as now, if at all.

    Of the n points that are known in all of them; by the transfer chosen or by another one's name; weighed, if own
    images (N, 4) px are given as `like`, as the noise of the demonstrator's would spread over those, or that of all
    images if these are rectified and `like` is near; rectified as for another `head`, if one is named. With fewer
    points than a transfer needs they are infinite. Behind a moving demonstrator seen with noise, noise_px > 0, the
    transfer of the last convergence serves (Section 5.4): fitted anew at postures apart it would add its own noise to
    theirs. moments: of the history, whose own images may be asked about again.
    """

    def __init__(
        self, now: Snapshot, drift: NDArray = NO_DRIFT, noise_px: float = 0.0, moments: Sequence[Snapshot] = ()
    ):
        self._now, self._drift, self._noise_px = now, drift, noise_px
        self._demo = now.views.demo + drift
        self._demo_seen = np.asarray(now.views.visible[:, :2].all(-1))
        self._frozen = now.frozen if noise_px > 0 and drift.any() else None
        self._answers = _Answers(now, () if drift.any() else moments)
        self._near: dict[Likeness, Residuals | None] = {}
        self._weights: dict[Likeness, NDArray] = {}
        self._heads: dict[int, Conflict] = {}

    def __call__(self, own: NDArray, by: str | None = None, like: NDArray | None = None, head: int = 0) -> NDArray:
        if head:
            return self._of_head(head)(own, by, like)
        answered = self._answers.to(own) if own.ndim == 3 and by is None and like is None else None
        if answered is not None:
            return answered
        told = np.isfinite(own)
        seen = self._demo_seen
        known = seen if told.all() else seen & told.all(-1).reshape(-1, len(seen)).all(0)
        count = np.count_nonzero(known)
        if count < MIN_POINTS:  # nothing can be told of such images: they are to be avoided
            return np.full((*own.shape[:-2], 1, 4), np.inf)
        imagined = FourViews(self._demo, own, self._now.views.visible)
        imagined = imagined if count == len(known) else imagined.select(known)
        one = None if like is None else (np.asarray(like, float).tobytes(), known.tobytes())
        if one and not by and self._frozen is None:
            weighed = self._weighed_near(one)
            if weighed is not None:
                return weighed.residual(imagined)
        transfer = self._now.fit(imagined, by) if by or self._frozen is None else self._frozen
        e = transfer.residual(imagined)
        return e if one is None or transfer.weighs_noise else e @ self._weight(one)

    def with_half_seen(self) -> Conflict:
        return HalfSeenConflict(self, self._now, self._demo, _nearest(self._noise_px))

    def _weighed_near(self, one: Likeness) -> Residuals | None:
        if one not in self._near:  # a servo asks about many images that are like the same one
            self._near[one] = _near(self._now, self._alike(one), self._noise_px)
        return self._near[one]

    def _weight(self, one: Likeness) -> NDArray:
        if one not in self._weights:
            self._weights[one] = noise_weight(self._alike(one))
        return self._weights[one]

    def _alike(self, one: Likeness) -> FourViews:
        like, known = one
        points = np.frombuffer(known, bool)
        own = np.frombuffer(like).reshape(-1, 4)[points]
        return FourViews(self._demo[points], own, self._now.views.visible[points])

    def _of_head(self, head: int) -> Conflict:
        if head not in self._heads:
            assert self._now.rectification is not None
            other = self._now.with_fields(rectification=self._now.rectification.others[head - 1])
            self._heads[head] = PredictedConflict(other, self._drift, self._noise_px)
        return self._heads[head]
