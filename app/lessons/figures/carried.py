"""A circle of the hand that a frozen geometry carries over: in L, and from the side, where only a viewer can stand."""

from collections.abc import Collection, Mapping

import numpy as np
from numpy.typing import NDArray

from viewimit.drawing.lessons.hands import Curve, Hand, Picture, draw_hands

from ..measures.carried import carried_of
from ..stage import Stage
from ..works.carried import Carried, Followed
from .figure_kind import FigureKind

RUNS = (("right", "learner", "frozen at agreement"), ("early", "opponent", "frozen early"))
IN_IMAGE = ("still right", "still early", "right", "early", "targets", "truth")
FROM_SIDE = ("circle", "right", "early", "px", "mm")
MM, PX = (1.0, 1000.0), (0.1, 10.0)  # that the curves show in any case


def _in_image(stage: Stage, layers: Collection[str], small: bool) -> str:
    carried = carried_of(stage)
    if carried is None:
        return '<p class="vi-waits">the circle is being drawn …</p>'
    hands: list[Hand] = []
    if "truth" in layers:
        hands.append(Hand("the demonstrator's true path", "demonstrator", carried.right.truth[:, 0]))
    for which, role, name in RUNS:
        followed: Followed = getattr(carried, which)
        arms = followed.arms[:, 0]
        if which in layers:
            if "targets" in layers:
                hands.append(Hand("where the lines say it should be", "recovered", followed.target[:, 0]))
            hands.append(Hand("its own hand" if "targets" in layers else name, role, arms[:, -1], arms))
        elif f"still {which}" in layers:
            then = _arm_then(stage, followed)
            hands.append(Hand(name, role, then[:, -1], then, still=True))
    picture = Picture("L", "own left eye", _room_in_image(carried), False, "px", 1.0)
    return draw_hands(picture, hands, (), stage.played if stage.revealed else None)


def _arm_then(stage: Stage, followed: Followed) -> NDArray:
    """(1, k, 2) px: the learner's skeleton in L when the geometry was frozen."""
    world = stage.session.world
    origins = world.link_frames(followed.frozen.theta, world.T_world_own)[:, :3, 3]
    return world.own_pair.images(origins)[0][:1]


def _room_in_image(carried: Carried) -> NDArray:
    """(k, 2) px, all that may be drawn in L."""
    parts = [carried.right.truth[:, 0]]
    for followed in (carried.right, carried.early):
        parts += [followed.target[:, 0], followed.arms[:, 0].reshape(-1, 2)]
    return np.concatenate(parts)


def _from_side(stage: Stage, layers: Collection[str], small: bool) -> str:
    carried = carried_of(stage)
    if carried is None:
        return '<p class="vi-waits">…</p>'
    hands: list[Hand] = []
    if "circle" in layers:
        side = carried.right.demo_side
        hands.append(Hand("the demonstrator", "demonstrator", side[:, -1], side))
    for which, role, name in RUNS:
        if which in layers:
            side = getattr(carried, which).side
            hands.append(Hand(name, role, side[:, -1], side))
    curves = []
    shown = [(which, role, name) for which, role, name in RUNS if which in layers] or [RUNS[1]]
    if "px" in layers:
        values = [("", role, getattr(carried, which).overlap_px) for which, role, _ in shown]
        curves.append(Curve("Apart in its image", "px, from where it should be", values, PX))
    if "mm" in layers:
        values = [("", role, 1e3 * getattr(carried, which).run.hand_m) for which, role, _ in shown]
        curves.append(Curve("Hands apart in space", "mm, which it cannot know", values, MM))
    sides = [carried.right.demo_side, carried.right.side, carried.early.side]
    room = np.concatenate([side.reshape(-1, 2) for side in sides])
    picture = Picture("From the side", "both arms laid over each other", room, True, "mm", 1e3, 0.2)
    return draw_hands(picture, hands, curves, stage.played if stage.revealed else None)


FIGURES: Mapping[str, FigureKind] = {
    "carried in L": FigureKind(_in_image, IN_IMAGE, works=("carried",)),
    "carried from the side": FigureKind(_from_side, FROM_SIDE, works=("carried",)),
}
