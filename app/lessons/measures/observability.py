"""What a pixel of noise costs at each joint, and which joint no point tells: the truth, of undisturbed images."""

from collections.abc import Callable, Mapping
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from viewimit.analysis.observability import joint_uncertainty, untold_joints
from viewimit.snapshot import Snapshot

from ..stage import Stage
from .measure import Measure

_KNOWN: WeakKeyDictionary[Snapshot, NDArray] = WeakKeyDictionary()  # by a step's first moment: it is drawn many times


def costs(stage: Stage) -> NDArray:
    """(m,) rad/px at the demonstrator's posture; inf of what cannot be told, or with too few points."""
    first, world = stage.moments[0], stage.session.world
    if first not in _KNOWN:
        demo, visible = world.demo_images(first.theta_demo)
        found = joint_uncertainty(world, first.fit, demo, visible, first.theta_demo)
        _KNOWN[first] = np.full(len(first.theta), np.inf) if found is None else found
    return _KNOWN[first]


def _untold(stage: Stage) -> float:
    """Of the answers: each joint in turn, all of them, none."""
    spread = costs(stage)
    found = untold_joints(spread)
    return float(found[0] + 1 if len(found) == 1 else len(spread) + (1 if found else 2))


def _cost(joint: int) -> Callable[[Stage], float]:
    return lambda stage: float(np.degrees(costs(stage)[joint]))


MEASURES: Mapping[str, Measure] = {
    "joint that can be anything": Measure(_untold),
    "joint that costs most": Measure(lambda stage: float(np.argmax(costs(stage)) + 1)),
    "cost at the first joint": Measure(_cost(0), "°", 1, "any angle"),
    "cost at the second joint": Measure(_cost(1), "°", 1, "any angle"),
}
