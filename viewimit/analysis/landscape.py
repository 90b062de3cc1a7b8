"""E over a grid of the learner's postures: what Figs. 7 and 8 of the paper show. `landscape(session)` is one call.

It asks for the learner's images at every posture, of the simulated world or of a session's eyes, so it is for people,
not for a servo.
"""

import reprlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..estimation.transfers import TRANSFERS
from ..estimation.views import FourViews
from ..geometry.affine import MIN_POINTS
from ..geometry.small_matrices import keep_freed_memory
from ..loop.session import Session
from ..simulation.robot import Angles
from ..simulation.world import World

BLOCK = 55_000  # points of postures evaluated together: their arrays stay in the processor's cache
STEP_DEG = {"points": 1.0, "rendered": 10.0}  # of the grid, by camera; two pictures take a tenth of a second
SEEN = 10 * BLOCK  # points of postures seen together: their images stay below `KEPT_BYTES`


@dataclass(frozen=True)
class Landscape:
    """axes: two arrays of angles, rad; E: (len(axes[0]), len(axes[1])) px², NaN where too few points are seen.

    condition: the transfer's, as E; None unless it was asked for.
    """

    axes: tuple[NDArray, NDArray]
    E: NDArray
    condition: NDArray | None = None

    @property
    def minimum(self) -> NDArray:
        """(2,) rad, the grid's posture with the smallest E; NaN if there is none."""
        if np.isnan(self.E).all():
            return np.full(2, np.nan)
        i, j = np.unravel_index(np.nanargmin(self.E), self.E.shape)
        return np.array([self.axes[0][i], self.axes[1][j]])

    @property
    def _walled(self) -> NDArray:
        """(len(axes[0]) + 2, len(axes[1]) + 2) px²: inf all around, and where there is none."""
        E = np.full((self.E.shape[0] + 2, self.E.shape[1] + 2), np.inf)
        np.copyto(E[1:-1, 1:-1], self.E, where=~np.isnan(self.E))
        return E

    def local_minima(self) -> NDArray:
        """(k, 2) rad: grid points below their up to eight neighbours, lowest first."""
        E = self._walled
        inner = E[1:-1, 1:-1]
        below = np.isfinite(inner)
        for di, dj in _NEIGHBOURS:
            below &= inner < E[1 + di : E.shape[0] - 1 + di, 1 + dj : E.shape[1] - 1 + dj]
        i, j = np.nonzero(below)
        order = np.argsort(self.E[i, j])
        return np.stack([self.axes[0][i[order]], self.axes[1][j[order]]], -1)

    def basin_fraction(self) -> float:
        """Share of the postures that have an E from which descent over the eight neighbours ends at the minimum."""
        has_E = np.isfinite(self.E).ravel()
        if not has_E.any():
            return 0.0
        return float(np.mean(self._descend()[has_E] == np.nanargmin(self.E)))

    def _descend(self) -> NDArray:
        """Flat index of where steepest descent from each grid point ends."""
        rows, columns = self.E.shape
        E = self._walled
        best, target = E[1:-1, 1:-1].copy(), np.arange(self.E.size).reshape(rows, columns)
        for di, dj in _NEIGHBOURS:
            shifted = E[1 + di : rows + 1 + di, 1 + dj : columns + 1 + dj]
            lower = shifted < best
            best[lower] = shifted[lower]
            target[lower] = (np.arange(self.E.size).reshape(rows, columns) + di * columns + dj)[lower]
        ends = target.ravel()
        while not np.array_equal(ends, ends[ends]):  # pointer jumping: twice as far each time
            ends = ends[ends]
        return ends


_NEIGHBOURS = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if (i, j) != (0, 0)]


def grid_axes(world: World, step_deg: float = 1.0) -> tuple[NDArray, NDArray]:
    """The scene's range of its two moving joints in steps, rad. Raises ValueError for other counts of joints."""
    scene = world.scene
    if len(scene.moving_joints) != 2:
        raise ValueError(f"a landscape needs two moving joints, this scene has {len(scene.moving_joints)}")
    if not 0 < step_deg <= 45:
        raise ValueError(f"step must be between 0° and 45°, got {step_deg:g}°")
    first, second = (
        np.radians(np.linspace(low, high, round((high - low) / step_deg) + 1)) for low, high in scene.range_deg
    )
    return first, second


class Looks(Protocol):
    """What sees the learner: a world, or the eyes of a session."""

    def own_images(self, theta: Angles) -> tuple[NDArray, NDArray]: ...


def landscape(
    session: Session, step_deg: float | None = None, by: str | None = None, with_condition: bool = False
) -> Landscape:
    """E over the scene's range of its two moving joints, with the demonstrator as the session now sees it.

    step_deg: of the grid, by default 1°, with rendered pictures 10°. by: the name of another transfer than the
    session's. with_condition: whether the transfer's condition is found as well. What spoils images spoils the
    demonstrator's alone. Raises ValueError for another number of joints, a step or a transfer that is none, and without
    a scene; TypeError for what is no session, such as a world (`landscape_over`).
    """
    if not isinstance(session, Session):
        raise TypeError(f"a landscape is of a Session, got {reprlib.repr(session)}; landscape_over takes a world")
    if by is not None and by not in TRANSFERS:
        raise ValueError(f"no transfer {by!r}; there are {', '.join(TRANSFERS)}")
    now, step = session.snapshot, STEP_DEG[session.settings.camera] if step_deg is None else step_deg
    fit = partial(now.fit, by=by)
    demo, seen = now.views.demo, now.views.visible[:, :2]
    return landscape_over(session.eyes, fit, demo, seen, grid_axes(session.world, step), with_condition)


def landscape_over(
    world: World | Looks,
    fit: Callable,
    demo: NDArray,
    demo_visible: NDArray,
    axes: tuple[NDArray, NDArray] | None = None,
    with_condition: bool = False,
) -> Landscape:
    """E of a transfer over the learner's postures. axes: two arrays of rad; None takes the range of a world's scene.

    Raises ValueError without axes for what has no scene.
    """
    if axes is None:
        if not isinstance(world, World):
            raise ValueError("eyes have no range of their own: axes are needed")
        axes = grid_axes(world)
    rows = max(SEEN // (len(demo) * len(axes[1])), 1)
    found = [
        conflict_at(world, fit, demo, demo_visible, (axes[0][k : k + rows, None], axes[1]), with_condition)
        for k in range(0, len(axes[0]), rows)
    ]
    return Landscape(axes, *np.concatenate(found, 1))


def conflict_at(
    world: World | Looks, fit: Callable, demo: NDArray, demo_visible: NDArray, theta, with_condition: bool = False
) -> NDArray:
    """E and, if asked, the condition at any postures, the learner's images undisturbed: (1 or 2, ...).

    demo: (N, 4) px, demo_visible: (N, 2): the demonstrator's images as the learner has them; theta: m arrays, rad,
    broadcast against each other. Postures are taken together by which points are seen there.
    """
    keep_freed_memory()
    return conflict_of_images(fit, demo, demo_visible, *world.own_images(theta), with_condition)


def conflict_of_images(
    fit: Callable,
    demo: NDArray,
    demo_visible: NDArray,
    own: NDArray,
    own_visible: NDArray,
    with_condition: bool = False,
) -> NDArray:
    """As `conflict_at`, of own images (..., N, 4) px, own_visible (..., N, 2)."""
    shape = own.shape[:-2]
    own = own.reshape((-1,) + own.shape[-2:])
    usable = (own_visible.all(-1) & demo_visible.all(-1)).reshape(own.shape[:2])
    if usable.all():
        found = _evaluate(fit, demo, own, with_condition)
    else:
        found = np.full((1 + with_condition, len(own)), np.nan)
        patterns, which = np.unique(usable, axis=0, return_inverse=True)
        for k, pattern in enumerate(patterns):
            if pattern.sum() >= MIN_POINTS:
                here = which.ravel() == k
                found[:, here] = _evaluate(fit, demo[pattern], own[here][:, pattern], with_condition)
    return found.reshape((-1,) + shape)


def _evaluate(fit: Callable, demo: NDArray, own: NDArray, with_condition: bool) -> NDArray:
    """E and, if asked, the condition of G postures: (1 or 2, G). own: (G, N, 4) px."""
    found = np.empty((1 + with_condition, len(own)))
    postures = max(BLOCK // len(demo), 1)
    for start in range(0, len(own), postures):
        block = slice(start, start + postures)
        views = FourViews(demo, own[block], np.ones(1, bool))
        transfer = fit(views)
        found[0, block] = transfer.conflict(views)
        if with_condition:
            found[1, block] = transfer.condition
    return found
