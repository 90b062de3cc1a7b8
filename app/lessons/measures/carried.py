"""Of a circle that a frozen geometry carries over: how far the hands are apart, and how well their images overlap.

Distances in space are the truth, which no learner knows.
"""

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from ..stage import Stage
from ..works.carried import Carried, Followed
from .measure import Measure

SAME_SHARE = 0.25  # of the circle's radius: a hand that near all the way draws it
LOOP_SHARE = 0.5  # of its length: a path as broad as that is a loop
LIKE, ELSEWHERE, OTHER = 1.0, 2.0, 3.0  # what is drawn: the circle, a loop elsewhere, something else


def carried_of(stage: Stage) -> Carried | None:
    """None while it is computed."""
    return stage.made.get("carried")


def _of(what: Callable[[Followed], float], which: str) -> Callable[[Stage], float]:
    def of(stage: Stage) -> float:
        carried = carried_of(stage)
        return np.nan if carried is None else float(what(getattr(carried, which)))

    return of


def _hand_mm(followed: Followed) -> float:
    return 1e3 * float(np.median(followed.run.hand_m))


def _frozen_off(followed: Followed) -> float:
    """Degrees from the demonstrator, when the geometry was frozen."""
    return float(np.degrees(np.abs(followed.frozen.theta - followed.frozen.theta_demo).max()))


def _radius(followed: Followed) -> float:
    """m, of the demonstrator's circle."""
    demo = followed.demo_side[:-1, -1]
    return float(np.linalg.norm(demo - demo.mean(0), axis=1).mean())


def _loop(followed: Followed) -> NDArray:
    """(2,) m: how long and how broad an ellipse with the second moments of the hand's path is."""
    hand = followed.side[:-1, -1]
    return 2 * np.linalg.svd(hand - hand.mean(0), compute_uv=False) * np.sqrt(2 / len(hand))


def _drawn(stage: Stage) -> float:
    """Which answer holds for the geometry that was frozen early; 0 while it is computed."""
    carried = carried_of(stage)
    if carried is None:
        return 0.0
    own, demo = carried.early.side[:, -1], carried.early.demo_side[:, -1]
    if float(np.linalg.norm(own - demo, axis=1).max()) < SAME_SHARE * _radius(carried.early):
        return LIKE
    long, broad = _loop(carried.early).tolist()
    away = float(np.linalg.norm(own.mean(0) - demo.mean(0)))
    return ELSEWHERE if broad > LOOP_SHARE * long and away > _radius(carried.early) else OTHER


def _mm_a_px(stage: Stage) -> float:
    carried = carried_of(stage)
    return np.nan if carried is None else carried.mm_a_px


MEASURES: Mapping[str, Measure] = {
    "what the early geometry draws": Measure(_drawn),
    "mm apart, frozen early": Measure(_of(_hand_mm, "early"), " mm", 0),
    "mm apart, frozen at agreement": Measure(_of(_hand_mm, "right"), " mm", 0),
    "px overlap, frozen early": Measure(_of(lambda followed: float(np.median(followed.overlap_px)), "early"), " px", 1),
    "px overlap, frozen at agreement": Measure(
        _of(lambda followed: float(np.median(followed.overlap_px)), "right"), " px", 1
    ),
    "px from the true path, frozen early": Measure(
        _of(lambda followed: float(np.median(followed.truth_px)), "early"), " px", 0
    ),
    "off when frozen early": Measure(_of(_frozen_off, "early"), "°", 0),
    "off when frozen at agreement": Measure(_of(_frozen_off, "right"), "°", 1),
    "E when frozen early": Measure(_of(lambda followed: followed.frozen.E, "early"), " px²"),
    "E when frozen at agreement": Measure(_of(lambda followed: followed.frozen.E, "right"), " px²"),
    "circle's width": Measure(_of(lambda followed: 2e3 * _radius(followed), "right"), " mm", 0),
    "length of the early loop": Measure(_of(lambda followed: 1e3 * float(_loop(followed)[0]), "early"), " mm", 0),
    "breadth of the early loop": Measure(_of(lambda followed: 1e3 * float(_loop(followed)[1]), "early"), " mm", 0),
    "mm a pixel": Measure(_mm_a_px, " mm", 0),
}
