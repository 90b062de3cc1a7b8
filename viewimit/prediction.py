"""The conflict that images would have which a servo predicts: no motion is made for it, and no posture is known."""

from collections.abc import Callable, Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

from .geometry.affine import MIN_POINTS
from .servo.observation import Conflict
from .snapshot import Snapshot
from .transfer import TRANSFERS
from .transfer.noise import noise_weight
from .transfer.transfer import Residuals
from .views import FourViews

DRIFT_MOMENTS = 3  # two displacements
NO_DRIFT = np.zeros(())
NEAR, NEAR_NOISE = 4.0, 1600.0  # px²; times the noise's square: E up to which own images are near the demonstrator's
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
    near = TRANSFERS[now.settings.transfer].near
    if near is None or now.rectification is None or len(views.own) < NEAR_POINTS:
        return None
    E = float(now.fit(views).conflict(views))
    return near(views, now.rectification) if E < max(NEAR, NEAR_NOISE * noise_px**2) else None


def _answers(now: Snapshot, moments: Sequence[Snapshot]) -> Callable[[NDArray], NDArray | None]:
    """What was found already: residuals (n, N, 4) px of own images (n, N, 4) px if each was seen at one of the moments,
    all else being as it is now; else None. A servo asks about all its visits at every motion."""

    @cache
    def known() -> dict[bytes, NDArray]:
        if now.transfer is None or not now.views.visible.all():
            return {}
        alike = (
            moment
            for moment in moments
            if moment.views.demo is now.views.demo
            and moment.views.visible is now.views.visible
            and moment.rectification is now.rectification
            and moment.settings.transfer == now.settings.transfer
        )
        return {moment.views.own.tobytes(): moment.residual for moment in alike}

    def answer(own: NDArray) -> NDArray | None:
        found: list[NDArray] = []
        for image in own:
            e = known().get(image.tobytes())
            if e is None:
                return None
            found.append(e)
        return np.array(found) if found else None

    return answer


def predicted_conflict(
    now: Snapshot, drift: NDArray = NO_DRIFT, noise_px: float = 0.0, moments: Sequence[Snapshot] = ()
) -> Conflict:
    """What a servo may ask: residuals (..., n, C) px that own images (..., N, 4) px would have against the
    demonstrator as now seen, and displaced by `drift`, (N, 4) px; both rectified as now, if at all.

    Of the n points that are known in all of them; by the transfer chosen or by another one's name; weighed, if own
    images (N, 4) px are given as `like`, as the noise of the demonstrator's would spread over those, or that of all
    images if these are rectified and `like` is near; rectified as for another `head`, if one is named. With fewer
    points than a transfer needs they are infinite. Behind a moving demonstrator seen with noise, noise_px > 0, the
    transfer of the last convergence serves (Section 5.4): fitted anew at postures apart it would add its own noise to
    theirs. moments: of the history, whose own images may be asked about again.
    """
    demo, demo_seen = now.views.demo + drift, np.asarray(now.views.visible[:, :2].all(-1))
    frozen = now.frozen if drift.any() and noise_px > 0 else None

    def alike(like: bytes, known: bytes) -> FourViews:
        points = np.frombuffer(known, bool)
        return FourViews(demo[points], np.frombuffer(like).reshape(-1, 4)[points], now.views.visible[points])

    @cache  # a servo asks about many images that are like the same one
    def near(like: bytes, known: bytes) -> Residuals | None:
        return _near(now, alike(like, known), noise_px)

    @cache
    def weight(like: bytes, known: bytes) -> NDArray:
        return noise_weight(alike(like, known))

    @cache
    def of_head(head: int) -> Conflict:
        assert now.rectification is not None
        other = now.with_fields(rectification=now.rectification.others[head - 1])
        return predicted_conflict(other, drift, noise_px)

    answer = _answers(now, () if drift.any() else moments)

    def conflict(own: NDArray, by: str | None = None, like: NDArray | None = None, head: int = 0) -> NDArray:
        if head:
            return of_head(head)(own, by, like)
        answered = answer(own) if own.ndim == 3 and by is None and like is None else None
        if answered is not None:
            return answered
        told = np.isfinite(own)
        known = demo_seen if told.all() else demo_seen & told.all(-1).reshape(-1, len(demo_seen)).all(0)
        if np.count_nonzero(known) < MIN_POINTS:  # nothing can be told of such images: they are to be avoided
            return np.full((*own.shape[:-2], 1, 4), np.inf)
        imagined = FourViews(demo, own, now.views.visible)
        imagined = imagined if np.count_nonzero(known) == len(known) else imagined.select(known)
        one = None if like is None else (np.asarray(like, float).tobytes(), known.tobytes())
        if one and not by and frozen is None:
            weighed = near(*one)
            if weighed is not None:
                return weighed.residual(imagined)
        transfer = now.fit(imagined, by) if by or frozen is None else frozen
        e = transfer.residual(imagined)
        return e if one is None or transfer.weighs_noise else e @ weight(*one)

    return conflict
