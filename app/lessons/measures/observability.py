"""What a pixel of noise costs at each joint, how much of what a joint does arrows show, and which joint no point tells:
the truth, of undisturbed images."""

from collections.abc import Callable, Mapping
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from viewimit.analysis.observability import joint_uncertainty, residual_jacobian, unobservable_joints
from viewimit.estimation.views import FourViews
from viewimit.loop.snapshot import Snapshot

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


def _shown(stage: Stage, joint: int, by_arrows: bool) -> float:
    """px, rms over points and images: what a degree of a joint adds to arrows, or else moves the own images by."""
    first, world = stage.moments[0], stage.session.world
    demo, _ = world.demo_images(first.theta_demo)

    def at(postures: NDArray) -> NDArray:
        own, _ = world.own_images(postures.T)
        views = FourViews(demo, own, np.ones(1, bool))
        return first.fit(views).residual(views) if by_arrows else own

    J = np.radians(1) * residual_jacobian(at, first.theta_demo)[:, joint]
    return float(np.sqrt(2 * np.mean(J**2)))


def _of_joint(joint: int, by_arrows: bool) -> Callable[[Stage], float]:
    return lambda stage: _shown(stage, joint, by_arrows)


def _untold(stage: Stage) -> float:
    """Of the answers: each joint in turn, all of them, none."""
    spread = costs(stage)
    found = unobservable_joints(spread)
    return float(found[0] + 1 if len(found) == 1 else len(spread) + (1 if found else 2))


def _cost(joint: int) -> Callable[[Stage], float]:
    return lambda stage: float(np.degrees(costs(stage)[joint]))


MEASURES: Mapping[str, Measure] = {
    "joint that can be anything": Measure(_untold),
    "joint that costs most": Measure(lambda stage: float(np.argmax(costs(stage)) + 1)),
    "first joint moves": Measure(_of_joint(0, False), " px"),
    "first joint shows": Measure(_of_joint(0, True), " px"),
    "second joint moves": Measure(_of_joint(1, False), " px"),
    "second joint shows": Measure(_of_joint(1, True), " px"),
    "cost at the first joint": Measure(_cost(0), "°", 1, "any angle"),
    "cost at the second joint": Measure(_cost(1), "°", 1, "any angle"),
}
