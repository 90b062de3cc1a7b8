"""Of the step in which the eyes move back: where E is smallest here, and how far that is from the demonstrator at every
distance, by every transfer."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from viewimit.analysis.landscape import grid_axes, landscape_over
from viewimit.estimation.transfers import TRANSFERS
from viewimit.loop.session import Session
from viewimit.loop.snapshot import Snapshot
from viewimit.simulation.world import World

from ..scenes import SLIDERS, Staging
from .work import Task, Work

TIMES = np.array([1.0, 1.5, 2.0, 3.0, 5.0, 10.0, 17.0, 30.0])  # the distance
COARSE_DEG = 6.0
AROUND, FINER, ROUNDS = 1.5, 9, 8  # steps of a grid to both sides of its lowest posture, postures a joint, and again


@dataclass(frozen=True)
class Biases:
    """times: (K,) of the distance; degrees: by transfer, (K,) how far the smallest E is from the demonstrator, the
    joint that is farthest."""

    times: NDArray
    degrees: Mapping[str, NDArray]


def _minimum(task: Task) -> NDArray | None:
    """(2,) rad, of the step's own transfer; None unless two joints move."""
    if len(task.world.scene.moving_joints) != 2:
        return None
    return smallest(task.world, task.snapshot, task.snapshot.fit)


def _biases(task: Task) -> Biases | None:
    """None unless two joints move."""
    if len(task.world.scene.moving_joints) != 2:
        return None
    degrees: dict[str, list[float]] = {name: [] for name in TRANSFERS}
    moved = {name: value for name, value in task.sliders.items() if name in SLIDERS}
    for times in TIMES.tolist():
        session = Session(
            task.settings, open_eyes=Staging(task.step.scene, sliders={**moved, "distance": times}).open_eyes
        )
        moment = session.snapshot
        for name, found in degrees.items():
            at = smallest(session.world, moment, partial(moment.fit, by=name))
            found.append(float(np.degrees(np.abs(at - moment.theta_demo).max())))
    return Biases(TIMES, {name: np.array(found) for name, found in degrees.items()})


def smallest(world: World, moment: Snapshot, fit: Callable) -> NDArray:
    """(2,) rad: the posture with the smallest E, on a coarse grid, then on ever finer ones about the lowest; NaN where
    too few points are seen."""
    views = moment.views
    seen = fit, views.demo, views.visible[:, :2]
    axes, step = grid_axes(world, COARSE_DEG), np.radians(COARSE_DEG)
    lower, upper = world.scene.lower, world.scene.upper
    lowest = landscape_over(world, *seen, axes).minimum
    for _ in range(ROUNDS):
        if np.isnan(lowest).any():
            break
        near = np.clip(lowest[:, None] + AROUND * step * np.linspace(-1, 1, FINER), lower[:, None], upper[:, None])
        lowest = landscape_over(world, *seen, (near[0], near[1])).minimum
        step *= 2 * AROUND / (FINER - 1)
    return lowest


WORKS: Mapping[str, Work] = {
    "minimum": Work(_minimum, "turned"),
    "biases": Work(_biases),
}
