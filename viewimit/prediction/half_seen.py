"""The predicted conflict of all points of which the demonstrator shows one image at least.

Points that both cameras see can be held against each other before anything is concluded from them; the image of a point
that one camera alone sees cannot. So these are asked last.
"""

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..evaluation import conflict as evaluate
from ..geometry.affine import MIN_POINTS
from ..geometry.rectification import Rectification, level
from ..servo.observation import Conflict
from ..snapshot import Snapshot
from ..transfer.transfer import Residuals
from ..views import FourViews


class HalfSeenConflict:
    """whole: of points that both cameras see, which answers for other transfers; demo: (N, 4) px, what is asked; near:
    px², E up to which own images are near enough for their noise to be weighed."""

    def __init__(self, whole: Conflict, now: Snapshot, demo: NDArray, near: float):
        method = now.method
        assert method.half_seen is not None and method.near is not None
        self._even, self._weighed = method.half_seen, method.near
        self._whole, self._now, self._demo, self._near = whole, now, demo, near
        self._by_noise: dict[tuple[bytes, bytes, int], Residuals] = {}

    def __call__(self, own: NDArray, by: str | None = None, like: NDArray | None = None, head: int = 0) -> NDArray:
        if by is not None:
            return self._whole(own, by, like, head)
        shown = self._now.views.visible[:, :2]
        known = shown.any(1) & np.isfinite(own).all(-1).reshape(-1, len(shown)).all(0)
        if np.count_nonzero(known & shown.all(1)) < MIN_POINTS:
            return np.full((*own.shape[:-2], 1, 4), np.inf)
        views = self._views(own, known)
        residuals = self._even(views, self._heads[head]) if like is None else self._like(like, known, head)
        return residuals.residual(views)

    def with_half_seen(self) -> Conflict:
        return self

    def _like(self, like: NDArray, known: NDArray, head: int) -> Residuals:
        one = np.asarray(like, float).tobytes(), known.tobytes(), head
        if one not in self._by_noise:
            views = self._views(np.asarray(like, float), known)
            even = self._even(views, self._heads[head])
            near = float(evaluate(even.residual(views))) < self._near
            self._by_noise[one] = self._weighed(views, self._heads[head]) if near else even
        return self._by_noise[one]

    def _views(self, own: NDArray, points: NDArray) -> FourViews:
        return FourViews(self._demo, own, self._now.views.visible).select(points)

    @cached_property
    def _heads(self) -> tuple[Rectification, ...]:
        """That the head seems to have, and those that it may have instead."""
        known = self._now.rectification
        if known is None:
            matches = np.concatenate(self._now.views.matches)
            return (level(matches[:, :2], matches[:, 2:]),)
        return known, *known.others
