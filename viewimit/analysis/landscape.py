"""E over a grid of the learner's postures, as in Figs. 7 and 8 of the paper: `landscape(session)`.

It needs the learner's images at every posture, which only people have: from a simulated world or a session's cameras.
"""

import reprlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..estimation.transfers import TRANSFERS
from ..estimation.views import FourViews
from ..geometry.affine import MIN_POINTS
from ..geometry.arrays import Floats
from ..geometry.small_matrices import keep_freed_memory
from ..loop.session import Session
from ..loop.snapshot import Snapshot
from ..simulation.eyes import SimulatedEyes
from ..simulation.robot import Angles
from ..simulation.world import World

OwnImages = World | SimulatedEyes  # gives the learner's images at any posture
EVALUATED_POINTS = 55_000  # evaluated together, over all postures: their arrays stay in the processor's cache
STEP_DEG = {"projected": 1.0, "rendered": 10.0}  # of the grid, by sensor; two pictures take a tenth of a second
PROJECTED_POINTS = 10 * EVALUATED_POINTS  # projected together: their images stay below `KEPT_BYTES`


@dataclass(frozen=True)
class Landscape:
    """E on a grid of two joints."""

    axes: tuple[Floats, Floats]  # angles of the two joints, rad
    E: Floats  # (len(axes[0]), len(axes[1])) px², NaN where too few points are visible
    condition: Floats | None = None  # of the transfer, shaped as E; None unless computed

    @property
    def minimum(self) -> Floats:
        """(2,) rad, the grid posture with the smallest E; NaN if E is NaN everywhere."""
        if np.isnan(self.E).all():
            return np.full(2, np.nan)
        i, j = np.unravel_index(np.nanargmin(self.E), self.E.shape)
        return np.array([self.axes[0][i], self.axes[1][j]])

    @property
    def _padded(self) -> NDArray:
        """E with a border of inf, and with NaN replaced by inf: (len(axes[0]) + 2, len(axes[1]) + 2) px²."""
        E = np.full((self.E.shape[0] + 2, self.E.shape[1] + 2), np.inf)
        np.copyto(E[1:-1, 1:-1], self.E, where=~np.isnan(self.E))
        return E

    def local_minima(self) -> Floats:
        """Find the grid points that are lower than all of their neighbours, up to eight.

        Returns
        -------
        (k, 2) array
            Postures [rad], lowest E first.
        """
        E = self._padded
        inner = E[1:-1, 1:-1]
        below = np.isfinite(inner)
        for di, dj in _NEIGHBOURS:
            below &= inner < E[1 + di : E.shape[0] - 1 + di, 1 + dj : E.shape[1] - 1 + dj]
        i, j = np.nonzero(below)
        order = np.argsort(self.E[i, j])
        return np.stack([self.axes[0][i[order]], self.axes[1][j[order]]], -1)

    def basin_fraction(self) -> float:
        """Compute the share of postures from which steepest descent ends at the minimum.

        Returns
        -------
        float
            Share of the grid postures that have an E; descent goes over the eight neighbours.
        """
        has_E = np.isfinite(self.E).ravel()
        if not has_E.any():
            return 0.0
        return float(np.mean(self._descend()[has_E] == np.nanargmin(self.E)))

    def _descend(self) -> NDArray:
        """Flat index of the grid point where steepest descent ends, for each start."""
        rows, columns = self.E.shape
        E = self._padded
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


def grid_axes(world: World, step_deg: float = 1.0) -> tuple[Floats, Floats]:
    """Divide the scene's ranges of its two moving joints into steps; angles in rad.

    Raises ValueError unless two joints move, and for a step outside 0° to 45°.
    """
    scene = world.scene
    if len(scene.moving_joints) != 2:
        raise ValueError(f"a landscape needs two moving joints, this scene has {len(scene.moving_joints)}")
    if not 0 < step_deg <= 45:
        raise ValueError(f"step must be between 0° and 45°, got {step_deg:g}°")
    first, second = (
        np.radians(np.linspace(low, high, round((high - low) / step_deg) + 1)) for low, high in scene.range_deg
    )
    return first, second


def landscape(
    session: Session, step_deg: float | None = None, by: str | None = None, with_condition: bool = False
) -> Landscape:
    """Compute E over the ranges of the two moving joints, for the demonstrator as the session now sees it.

    Disturbances act on the demonstrator's images only.

    Parameters
    ----------
    session : Session
        Two of its joints must move.
    step_deg : float, optional
        Step of the grid, by default 1°, with rendered pictures 10°.
    by : str, optional
        Name of a transfer other than the session's.
    with_condition : bool
        Whether to compute the transfer's condition number as well.

    Returns
    -------
    Landscape
        E on the grid [px²].

    Raises
    ------
    ValueError
        For another number of joints, a bad step, an unknown transfer, no scene, or points without names.
    TypeError
        If `session` is no session. `viewimit.analysis.landscape.landscape_over` is of a world.
    """
    if not isinstance(session, Session):
        instead = "landscape_over takes a world (in viewimit.analysis.landscape)"
        raise TypeError(f"a landscape is of a Session, got {reprlib.repr(session)}; {instead}")
    if by is not None and by not in TRANSFERS:
        raise ValueError(f"no transfer {by!r}; there are {', '.join(TRANSFERS)}")
    if not session.snapshot.views.matched:
        raise ValueError("the demonstrator's points have no names yet, so there is no E: make the probes first")
    step = STEP_DEG[session.settings.sensor] if step_deg is None else step_deg
    seen = seen_from(session.eyes, session.snapshot, by)
    return landscape_over(*seen, grid_axes(session.world, step), with_condition)


class SeenDemonstrator(NamedTuple):
    """The demonstrator as a learner has it, and how that sees itself: the first arguments of `conflict_at`."""

    world: OwnImages
    fit: Callable  # fits a transfer to `FourViews`
    demo: Floats  # (N, 4) px, in [l] and [r]
    demo_visible: NDArray[np.bool_]  # (N, 2)


def seen_from(world: OwnImages, now: Snapshot, by: str | None = None) -> SeenDemonstrator:
    """Return the demonstrator as the learner now has it. by: the transfer."""
    return SeenDemonstrator(world, partial(now.fit, by=by), now.views.demo, now.views.visible[:, :2])


def landscape_over(
    world: OwnImages,
    fit: Callable,
    demo: Floats,
    demo_visible: NDArray[np.bool_],
    axes: tuple[Floats, Floats],
    with_condition: bool = False,
) -> Landscape:
    """Compute E over a grid of the learner's postures. axes: rad; the other arguments are those of `conflict_at`."""
    rows = max(PROJECTED_POINTS // (len(demo) * len(axes[1])), 1)
    found = [
        conflict_at(world, fit, demo, demo_visible, (axes[0][k : k + rows, None], axes[1]), with_condition)
        for k in range(0, len(axes[0]), rows)
    ]
    return Landscape(axes, *np.concatenate(found, 1))


def conflict_at(
    world: OwnImages,
    fit: Callable,
    demo: Floats,
    demo_visible: NDArray[np.bool_],
    theta: Angles,
    with_condition: bool = False,
) -> Floats:
    """Compute E at any postures, with the learner's images undisturbed.

    world: gives the learner's images; fit: fits a transfer to `FourViews`; demo, demo_visible: (N, 4) px and (N, 2),
    the demonstrator's images as the learner has them; theta: m arrays of rad, broadcast against each other. Returns
    (1 or 2, ...): E [px²] and, with_condition, the transfer's condition number.
    """
    keep_freed_memory()
    own, own_visible = world.own_images(theta)
    return conflict_of_images(fit, demo, demo_visible, own, own_visible, with_condition)


def conflict_of_images(
    fit: Callable,
    demo: Floats,
    demo_visible: NDArray[np.bool_],
    own: Floats,
    own_visible: NDArray[np.bool_],
    with_condition: bool = False,
) -> NDArray:
    """Compute as `conflict_at`, from given own images (..., N, 4) px with visibility (..., N, 2).

    Postures with the same visible points are evaluated together.
    """
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
    """E and the condition of G postures, whose points are all visible: (1 or 2, G). own: (G, N, 4) px."""
    found = np.empty((1 + with_condition, len(own)))
    postures = max(EVALUATED_POINTS // len(demo), 1)
    for start in range(0, len(own), postures):
        block = slice(start, start + postures)
        views = FourViews(demo, own[block], np.ones(1, bool))
        transfer = fit(views)
        found[0, block] = transfer.conflict(views)
        if with_condition:
            found[1, block] = transfer.condition
    return found
