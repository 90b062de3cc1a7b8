"""Bars of joints beside the sliders: the learner's posture, and what body points tell about each joint."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from viewimit.analysis.observability import PointInformation, Proposal, unobservable_joints
from viewimit.analysis.self_assessment import Assessment
from viewimit.drawing import svg
from viewimit.drawing.landscape import describe_costs, draw_bars
from viewimit.estimation.transfers.transfer import FLATNESS
from viewimit.geometry.affine import MIN_POINTS
from viewimit.servo.certificate import MAX_STD_PER_PX
from viewimit.simulation.scene import Scene
from viewimit.wording import sentences

from ..lab.engine_scene import joint_name

WIDTH, NARROW, HEIGHT, INSET = 150, 74, 22, 8  # px of a posture bar, in one column and in two
MIN_IN_COLUMNS = 4  # joints that stand in two columns, so that they fit beside the demonstrator's sliders
POINTS_WIDTH, ROW = 250, 19  # px of the drawing of body points, and per joint
MAX_NAMED = 3  # joints of which a sentence names all


def draw_learner(
    scene: Scene, theta: NDArray[np.float64], theta_demo: NDArray[np.float64], assessment: Assessment | None = None
) -> str:
    """Draw a bar per joint with the learner's angle, the demonstrator's mark and the gap.

    theta, theta_demo: postures of both arms, (m,) rad; the learner does not know theta_demo; assessment: what the
    learner knows of its joints: an unobservable one has a hatched band.
    """
    rows, columns = [], len(theta) >= MIN_IN_COLUMNS
    band = np.zeros(len(theta))
    if assessment is not None:
        band[assessment.unobservable] = np.maximum(assessment.std_per_px[assessment.unobservable], MAX_STD_PER_PX)
    width = NARROW if columns else WIDTH
    limits = zip(scene.lower.tolist(), scene.upper.tolist())
    for k, (joint, own, demo, (low, high)) in enumerate(
        zip(scene.moving_joints, theta.tolist(), theta_demo.tolist(), limits)
    ):
        place = lambda angle, low=low, high=high: INSET + (width - 2 * INSET) * (angle - low) / (high - low)
        x, mark, y = place(own), place(demo), HEIGHT / 2
        name = svg.joint_symbol(joint) if columns else joint_name(scene, joint)
        rows.append(
            f'<div class="vi-bar"><span>{name}</span><svg viewBox="0 0 {width} {HEIGHT}">'
            f'<line x1="{INSET}" x2="{width - INSET}" y1="{y}" y2="{y}" class="vi-bar-rail"/>'
            f"{_band(place(max(own - band[k], low)), place(min(own + band[k], high))) if band[k] else ''}"
            f'<line x1="{x:.1f}" x2="{mark:.1f}" y1="{y}" y2="{y}" class="vi-bar-gap"/>'
            f'<path d="M{mark:.1f} {y - 5.5}l5.5 5.5l-5.5 5.5l-5.5 -5.5z" class="vi-bar-demonstrator"/>'
            f'<circle cx="{x:.1f}" cy="{y}" r="5" class="vi-bar-learner"/></svg><b>{svg.degrees(own)}</b></div>'
        )
    return f'<div class="vi-bars{" vi-many" if columns else ""}">{"".join(rows)}</div>'


def _band(left: float, right: float) -> str:
    """Draw a hatched band between two px, by strokes, because a pattern would need an id of its own on the page."""
    strokes = "".join(f"M{x:.1f} {HEIGHT - 4}l4-14" for x in np.arange(left, right - 4, 5))
    edge = f'<rect x="{left:.1f}" y="3.5" width="{right - left:.1f}" height="{HEIGHT - 7}" rx="3"/>'
    return f'<g class="vi-bar-unobservable">{edge}<path d="{strokes}"/></g>'


def draw_body_points(
    joints: Sequence[int], information: PointInformation, proposal: Proposal | None, searching: bool
) -> str:
    """Draw what the body points tell, while they are edited: their number, flatness, and a bar per joint.

    joints: numbers of the moving ones, from 1; information: what the present points tell; proposal: the best further
    point, if it is known; searching: whether it is being computed.
    """
    lines = [f"<b>{_count(information)}</b>{_flatness(information)}"]
    spread = information.std_per_px
    if spread is not None:
        height = ROW * len(joints)
        bars = draw_bars(joints, spread, POINTS_WIDTH, ROW)
        lines.append(
            f'Joint error per pixel of noise<svg class="vi" viewBox="0 0 {POINTS_WIDTH} {height}">{bars}</svg>'
        )
    words = _next_point(joints, proposal, searching)
    return "".join(f"<div>{line}</div>" for line in (*lines, svg.escape(words)) if line)


def describe_body_points(
    joints: Sequence[int], information: PointInformation, proposal: Proposal | None, searching: bool
) -> str:
    """Say the same in a sentence or two; parameters as for `draw_body_points`."""
    if information.std_per_px is None:
        costs = f"a transfer needs {MIN_POINTS}"
    else:
        costs = _worst_costs(joints, information.std_per_px)
    words = "; ".join(filter(None, (_count(information), costs, _flatness(information))))
    return sentences(words, _next_point(joints, proposal, searching) or "Click an arm to place one.")


def _count(information: PointInformation) -> str:
    count, seen = information.count, information.visible
    return svg.count_points(count) + ("" if seen == count else f", {seen} in all pictures")


def _flatness(information: PointInformation) -> str:
    if information.std_per_px is None or not np.isfinite(information.flatness):
        return ""
    return f"{FLATNESS} {svg.number(information.flatness, 0)}"


def _next_point(joints: Sequence[int], proposal: Proposal | None, searching: bool) -> str:
    if searching:
        return "Looking for the best next point …"
    if proposal is None:
        return ""
    after = proposal.after.std_per_px
    if after is None:
        return "The hollow point would help most."
    return f"The hollow point would help most: {_worst_costs(joints, after)}."


def _worst_costs(joints: Sequence[int], spread: NDArray[np.float64]) -> str:
    """Describe all of few joints; of many, the costliest and the unobservable ones. spread: (m,) rad/px."""
    if len(joints) <= MAX_NAMED:
        return describe_costs(joints, spread)
    unobservable = unobservable_joints(spread)
    worst = [k for k in np.argsort(-spread) if k not in unobservable][:1]
    chosen = [*worst, *sorted(unobservable)]
    return describe_costs([joints[k] for k in chosen], spread[chosen], are_worst=True)
