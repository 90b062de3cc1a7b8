"""Curves of E and of the joint angles over the motions, with labels at the curves instead of legends."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..analysis.convergence import RECENT
from ..geometry.arrays import Floats
from ..loop.snapshot import Snapshot
from . import svg
from .plots import Axes, Tick, decade_ticks, decades, log10

HEIGHT = 116  # px of one plot
LEFT, RIGHT, TOP, BOTTOM = 40, 112, 24, 20  # px around a plot
GAP = 6  # px between the plots
MAX_VERTICES, MAX_DOTS = 90, 48  # of a curve; longer curves have no dots
STEPS = (2, 4, 5, 10)  # times a power of ten: the x axis ends at four of them
MIN_E = 1e-3  # px²: a smaller E is drawn as this, because nobody could see that conflict

Box = tuple[float, float, float, float]  # left, top, right, bottom of a plot, px


def draw_curves(
    history: Sequence[Snapshot],
    cursor: int,
    E_true: float | None,
    joints: Sequence[int],
    width: int = 424,
    errors_deg: Sequence[float] = (),
) -> str:
    """Draw both plots as the panel's HTML.

    history, cursor: all snapshots, and the index of the shown one, after which they are faint; E_true: with the learner
    in the demonstrator's posture, px², which it does not know; joints: numbers of the moving ones, from 1; width: of
    the drawing in its own px; errors_deg: largest joint error of each snapshot up to the cursor.
    """
    box, step = plot_box(width), axis_end(len(history) - 1) // 4
    kept = svg.thinned(len(history), MAX_VERTICES, cursor)
    snapshots, motions = [history[k] for k in kept], np.array(kept, float)
    first = _draw_E(box, step, snapshots, motions, cursor, E_true)
    second = _draw_angles(box, step, snapshots, motions, cursor, joints)
    second += svg.text(box[2] + RIGHT, 12, describe_errors(errors_deg), "vi-end")
    return f'<div class="vi-panel">{arrange_plots(width, first, second)}</div>'


def axis_end(last: int) -> int:
    """Return the motions at the end of the x axis: four of the smallest nice steps that hold the last motion."""
    scale = 1
    while True:
        for step in STEPS:
            if 4 * step * scale >= last:
                return 4 * step * scale
        scale *= 10


def plot_box(width: int) -> Box:
    """Return the box of each plot in a drawing of this width, px."""
    return LEFT, TOP, width - RIGHT, HEIGHT - BOTTOM


def arrange_plots(width: int, first: str, second: str) -> str:
    """Place two plots below each other in an `<svg>`."""
    return (
        f'<svg class="vi" viewBox="0 0 {width} {2 * HEIGHT + GAP}">{first}'
        f'<g transform="translate(0 {HEIGHT + GAP})">{second}</g></svg>'
    )


def _frame(axes: Axes, step: int, cursor: int, title: str, note: str, ticks: Sequence[Tick]) -> str:
    """Draw title, rules, numbers and the cursor. step: motions, a quarter of the axis."""
    x = axes.x_px(cursor)
    parts = [
        axes.title(title, note, 0, 12) + axes.rules(ticks),
        f'<path class="vi-cursor" d="M{x:.1f} {axes.top}V{axes.bottom}"/>',
        axes.beside(ticks, 6),
        axes.below([(motions, str(motions)) for motions in range(0, 4 * step + 1, step)], 15),
        svg.text(axes.right + 24, axes.bottom + 15, "steps", "vi-2nd"),
    ]
    return "".join(parts)


def _draw_E(box: Box, step: int, snapshots: list[Snapshot], motions: Floats, cursor: int, E_true: float | None) -> str:
    E = np.maximum([snapshot.E for snapshot in snapshots], MIN_E)
    E_true = max(E_true, MIN_E) if E_true is not None and np.isfinite(E_true) else None
    y = decades(E if E_true is None else np.append(E, E_true))
    axes = Axes(*box, (0.0, 4.0 * step), y, up=log10)
    parts = [_frame(axes, step, cursor, "Conflict E", "px², log; hollow = test move", decade_ticks(*y))]
    labels = []
    if E_true is not None:
        parts.append(axes.level(E_true, "vi-line-demo"))
        labels.append((float(axes.y_px(E_true)), f"true pose {svg.short_E(E_true)}", "vi-of-demo"))
    points = np.stack([axes.x_px(motions), axes.y_px(E)], -1)
    done = int(np.searchsorted(motions, cursor, side="right"))
    probes = np.array([snapshot.probe for snapshot in snapshots])
    parts.append(_curve(points, done, probes, "E"))
    if done and np.isfinite(points[done - 1, 1]):
        labels.append((float(points[done - 1, 1]), f"E {svg.short_E(E[done - 1])}", "vi-of-E"))
    return "".join(parts) + axes.labels(labels)


def _draw_angles(
    box: Box, step: int, snapshots: list[Snapshot], motions: Floats, cursor: int, joints: Sequence[int]
) -> str:
    own = np.degrees(np.array([snapshot.theta for snapshot in snapshots]))
    demo = np.degrees(np.array([snapshot.theta_demo for snapshot in snapshots]))
    low, high = min(own.min(), demo.min()), max(own.max(), demo.max())
    every = 30 if high - low <= 110 else 60
    low, high = every * np.floor((low - 4) / every), every * np.ceil((high + 4) / every)
    axes = Axes(*box, (0.0, 4.0 * step), (low, high))
    ticks = [(float(angle), svg.number(angle, 0) + "°") for angle in np.arange(low, high + 1, every)]
    parts = [_frame(axes, step, cursor, "Joint angles", "dashed = demonstrator", ticks)]
    done = int(np.searchsorted(motions, cursor, side="right"))
    probes = np.array([snapshot.probe for snapshot in snapshots])
    x, labels = axes.x_px(motions), []
    for k, joint in enumerate(joints):
        name = svg.joint_symbol(joint)
        aim = axes.y_px(demo[:done, k])
        if (aim == aim[0]).all():
            line = np.array([[LEFT, aim[0]], [axes.right, aim[0]]])
        else:
            line = np.array([[*x[:done], axes.right], [*aim, aim[-1]]]).T
        parts.append(f'<path class="vi-line-demo" d="{svg.path(line)}"/>')
        points = np.array([x, axes.y_px(own[:, k])]).T
        parts.append(_curve(points, done, probes, "own"))
        angle = own[done - 1, k]
        labels.append((float(points[done - 1, 1]), f"{name} {svg.number(angle)}°", "vi-of-own"))
        if len(joints) <= 3:
            labels.append((float(line[-1, 1]), f"{name} = {svg.number(demo[done - 1, k])}°", "vi-of-demo"))
    return "".join(parts) + axes.labels(labels)


def _curve(points: Floats, done: int, probes: NDArray[np.bool_], role: str) -> str:
    """Draw a line with a dot per motion, hollow for probes; the part after the cursor is faint.

    points: (k, 2) px; done: number of points up to the cursor; probes: (k,) bool.
    """
    parts = []
    if done < len(points):
        parts.append(f'<path class="vi-line-{role} vi-later" d="{svg.path(points[max(done - 1, 0) :])}"/>')
    points, probes = points[:done], probes[:done]
    parts.append(f'<path class="vi-line-{role}" d="{svg.path(points)}"/>')
    seen = np.isfinite(points[:, 1])
    if done <= MAX_DOTS:
        parts.append(f'<path class="vi-dot-{role}" d="{svg.dots(points[seen & ~probes])}"/>')
        if probes.any():
            parts.append(f'<path class="vi-probe-{role}" d="{svg.circles(points[seen & probes], 2.6)}"/>')
    if done and seen[-1]:
        parts.append(f'<path class="vi-last vi-dot-{role}" d="{svg.dots(points[-1:])}"/>')
    return "".join(parts)


def describe_errors(errors_deg: Sequence[float]) -> str:
    """Say how far off the learner is now and was in the last RECENT motions; "" before the first motion."""
    recent = np.array(errors_deg[1:][-RECENT:])
    if len(recent) == 0:
        return ""
    rms = svg.number(np.sqrt(np.mean(recent**2)))
    return f"{svg.number(recent[-1])}° off, rms {rms}° over {svg.count_motions(len(recent))}"
