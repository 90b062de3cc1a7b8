"""How eyes of one's own are used: so many pictures at each posture, and a demonstrator that may move by itself."""

from numbers import Real
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ...estimation.noise import rounding_std
from ...estimation.views import FourViews, dimensions
from ...geometry.affine import MIN_POINTS, image_unit
from ...sensing import frames
from ...sensing.latency import MOST_LAG, lag_of
from ...sensing.lost import astray, lost
from ..settings import Settings
from ..snapshot import Snapshot
from .interface import Eyes

REST_LOOKS = 8  # pictures of the own body at rest, from which the learner knows their noise
LEAST_PX, SURELY = 0.01, 5.0  # a coordinate of typical images; standard deviations: a demonstrator has moved by more
WRONG = 0.1  # of the points: those that have moved the most may be found at wrong places
KINDS = {"demo": "iuf", "own": "iuf", "visible": "b"}  # of NumPy's; a share is no bool, and would be taken for seen

Images = tuple[NDArray, NDArray]  # of one body in a pair of views: points (N, 4) px, visible (N, 2) bool


class OwnLooks:
    """See `protocol.Looks`. The demonstrator's images stay the same ones until it moves, or more of it is seen."""

    anywhere: ClassVar[bool] = False

    def __init__(self, eyes: Eyes, points: int):
        self._eyes, self._points = eyes, points
        self._demo: Images | None = None
        self._noise: tuple[float, float] | None = None  # see _noises

    def four_views(self, settings: Settings, theta: NDArray, theta_demo: NDArray, look: int) -> FourViews:
        """Whatever is to be seen now."""
        merged, visible = frames.merge(*self._pictures(settings.frames))
        demo, demo_visible = self._demonstrator((merged[:, :4], visible[:, :2]), self.noise_at_rest(settings))
        return FourViews(demo, merged[:, 4:], np.concatenate([demo_visible, visible[:, 2:]], -1))

    def noise_at_rest(self, settings: Settings) -> float:
        single, rounded = self._noises()
        return float(np.hypot(single / np.sqrt(settings.frames), rounded))

    def wait(self, now: Snapshot, theta: NDArray) -> tuple[int, int | None]:
        """Looks are pictures here."""
        if now.lag is not None:
            for _ in range(now.lag):
                self._eyes.look()
            return now.lag, now.lag
        lag = lag_of((now.views.own, now.views.visible[:, 2:]), lambda k: self._own(), self._noises()[0])
        return MOST_LAG if lag is None else lag, lag

    def _demonstrator(self, now: Images, noise_px: float) -> Images:
        before = self._demo
        if before is None or _seen(now) > _seen(before) or _elsewhere(before, now, noise_px):
            self._demo = before = now
        return before

    def _own(self) -> Images:
        views = look_with(self._eyes, self._points)
        return views.own, views.visible[:, 2:]

    def _pictures(self, count: int) -> Images:
        """(count, N, 8) px and (count, N, 4) bool, in l, r, L, R."""
        seen = [look_with(self._eyes, self._points) for _ in range(count)]
        points = np.array([np.concatenate([views.demo, views.own], -1) for views in seen])
        return points, np.array([views.visible for views in seen])

    def _noises(self) -> tuple[float, float]:
        """Of a single picture, px, and what rounding adds however many are averaged: none if noise mixes the steps."""
        if self._noise is None:
            points, visible = self._pictures(REST_LOOKS)
            measured, rounded = frames.noise(points[..., 4:], visible[..., 2:]), rounding_std(points, visible)
            single = float(np.hypot(measured, _unmeasured(self._eyes)))
            self._noise = single, 0.0 if measured > rounded else rounded
        return self._noise


def look_with(eyes: Eyes, points: int | None = None) -> FourViews:
    """One look. Raises ValueError if it is no look, or not at so many points."""
    views = eyes.look()
    _require_images(views)
    if points is not None and len(views.demo) != points:
        raise ValueError(
            f"look() gave {len(views.demo)} points, at first {points}: they are matched by index, so give "
            "all of them always, NaN where one is not seen"
        )
    shown = np.concatenate([views.demo, views.own], -1)[np.repeat(views.visible, 2, -1)]
    if not np.isfinite(shown).all():
        raise ValueError("look() gave a point as visible whose coordinates are not finite")
    return _without_lost(views)


def _unmeasured(eyes: Eyes) -> float:
    """Noise that their pictures do not show, px. Raises ValueError for what is no amount."""
    amount = eyes.noise_px
    if not isinstance(amount, Real) or not 0 <= amount < np.inf:
        raise ValueError(f"noise_px must be a finite number of pixels from 0, got {amount!r}")
    return float(amount)


def _require_images(views: FourViews) -> None:
    """Raises ValueError for what is no FourViews, or holds arrays of another shape or kind than it should."""
    wanted = "look() must return FourViews of N points, such as FourViews.from_images makes of (N, 2) each"
    if not isinstance(views, FourViews):
        raise ValueError(wanted)
    for name, kinds in KINDS.items():
        array = getattr(views, name)
        if not isinstance(array, np.ndarray):
            raise ValueError(f"{wanted}: its {name} is a {type(array).__name__}")
        if array.shape != (*views.demo.shape[:1], 4) or array.dtype.kind not in kinds:
            raise ValueError(f"{wanted}: its {name} is of shape {array.shape}, {array.dtype}")


def _without_lost(views: FourViews) -> FourViews:
    """Without what a tracker has lost and says so, as with zeros, and without a body all of whose points are in one
    place or on one line. E of such points is nearly 0 wherever the arm is."""
    both, visible = np.concatenate([views.demo, views.own], -1).reshape(-1, 4, 2), views.visible
    visible = visible & ~lost(both)
    for image, seen in zip(both.swapaxes(0, 1), visible.T):
        if seen.any():
            seen[seen] = ~astray(image[seen])
    for k, images in ((slice(0, 2), views.demo), (slice(2, 4), views.own)):
        seen = images[visible[:, k].all(-1)]
        if len(seen) >= MIN_POINTS and dimensions(seen) < 2:
            visible[:, k] = False
    return FourViews(views.demo, views.own, visible)


def _elsewhere(before: Images, after: Images, noise_px: float) -> bool:
    """Whether the points seen in both have moved by more than noise moves them, as a whole (χ² test)."""
    both = (before[1] & after[1]).all(-1)
    square = np.sort(((after[0] - before[0])[both] ** 2).sum(-1))[: int((1 - WRONG) * both.sum())]
    coordinates = 4 * len(square)
    variance = max((LEAST_PX * image_unit(after[0][both])) ** 2, 2 * noise_px**2)
    return bool(square.sum() > variance * (coordinates + SURELY * np.sqrt(2 * coordinates)))


def _seen(images: Images) -> int:
    return int(images[1].all(-1).sum())
