"""E and the joint angles over the motions, with direct labels instead of legends."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..analysis.convergence import RECENT
from ..loop.snapshot import Snapshot
from . import svg
from .axes import Axes, Tick, decade_ticks, decades, log10
from .over.links import link

SIDE_BY_SIDE = 600  # px of width from which the plots stand beside each other
CARD_HEIGHT, TAB_HEIGHT = 132, 140  # px of one plot
PAIRED_WIDTH = 424  # px of each plot of a pair
LEFT, RIGHT, TOP, BOTTOM = 40, 112, 24, 20
LIMIT, DOT_LIMIT = 90, 48  # vertices of a curve; motions up to which each has a dot
STEPS = (1, 2, 4, 5, 10)  # x 10^k: the x axis ends at four of them
FLOOR_E = 1e-3  # px² below which E is drawn as this: nobody could see that conflict

Box = tuple[float, float, float, float]  # left, top, right, bottom px of a plot


def draw_curves(
    history: Sequence[Snapshot],
    cursor: int,
    E_true: float | None,
    joints: Sequence[int],
    width: int = 424,
    errors_deg: Sequence[float] = (),
) -> str:
    """HTML of both plots. E_true: E with the learner in the demonstrator's posture, truth for the viewer;
    joints: numbers of the moving joints, from 1; width: px, of the drawing's units; errors_deg: the largest joint
    error of each moment up to the cursor."""
    kept = svg.thinned(len(history), LIMIT, cursor)
    snapshots = [history[k] for k in kept]
    motions = np.array(kept, float)
    box, step = _box(width), _x_step(len(history) - 1)
    first = _draw_E(box, step, snapshots, motions, cursor, E_true)
    second = _draw_angles(box, step, snapshots, motions, cursor, joints)
    second += svg.text(box[2] + RIGHT, 12, following(errors_deg), "vi-end")
    return f'<div class="vi-panel">{_plots(width, first, second)}</div>'


def draw_curve_pair(
    history: Sequence[Snapshot], cursor: int, E_true: float | None, joints: Sequence[int]
) -> tuple[str, str]:
    """HTML of each plot by itself, of E and of the joint angles, to stand beside or under each other: `draw_curves`."""
    kept = svg.thinned(len(history), LIMIT, cursor)
    snapshots, motions = [history[k] for k in kept], np.array(kept, float)
    box, step = _box(PAIRED_WIDTH), _x_step(len(history) - 1)
    first = _draw_E(box, step, snapshots, motions, cursor, E_true)
    return _alone(first), _alone(_draw_angles(box, step, snapshots, motions, cursor, joints))


def paired_axis(last: int) -> tuple[float, float, int]:
    """The x axis of each of a pair: shares of the drawing's width at which it begins and ends, and the motions at its
    end. last: motion."""
    left, _, right, _ = _box(PAIRED_WIDTH)
    return left / PAIRED_WIDTH, right / PAIRED_WIDTH, 4 * _x_step(last)


def moment_links(address: str, last: int, width: int = 424) -> str:
    """HTML that lies over both plots: a cell around each moment that their axis has room for, of which Tab stops at
    those with a number below. It stays the same until the axis changes, so that a click survives a motion."""
    left, top, right, bottom = box = _box(width)
    step, every = _x_step(last), _between_links(last)
    axes, motions = Axes(box, (0.0, 4.0 * step), (0.0, 1.0)), np.arange(0, 4 * step + 1, every)
    edges = axes.x_px(np.append(motions - every / 2, motions[-1] + every / 2))
    edges[0], edges[-1] = left - 4, right + 4
    cells = "".join(
        link(
            address,
            f"moment/{motion}",
            f"after {motion} motions",
            f'<path d="M{edges[k]:.1f} {top}H{edges[k + 1]:.1f}V{bottom}H{edges[k]:.1f}z"/>',
            stop=motion % step == 0,
        )
        for k, motion in enumerate(motions.tolist())
    )
    group = f'<g class="vi-moments">{cells}</g>'
    return f'<div class="vi-panel vi-links">{_plots(width, group, group)}</div>'


def axis_end(last: int) -> int:
    """Motions at the end of the x axis, for which `moment_links` are the same as for the last one made."""
    return 4 * _x_step(last)


def moments_made(last: int) -> str:
    """A style that hides the links to moments after the last."""
    return f"<style>.vi-moments a:nth-child(n+{last // _between_links(last) + 2}){{display:none}}</style>"


def _between_links(last: int) -> int:
    """Motions from one link to the next: there are LIMIT at most, and one."""
    return -(-4 * _x_step(last) // LIMIT)


def _box(width: int) -> Box:
    """Of each plot."""
    beside = width >= SIDE_BY_SIDE
    return LEFT, TOP, ((width - 28) / 2 if beside else width) - RIGHT, (CARD_HEIGHT if beside else TAB_HEIGHT) - BOTTOM


def _alone(inside: str) -> str:
    return f'<div class="vi-panel"><svg class="vi" viewBox="0 0 {PAIRED_WIDTH} {TAB_HEIGHT}">{inside}</svg></div>'


def _plots(width: int, first: str, second: str) -> str:
    """A drawing of two plots, beside or under each other."""
    beside, (_, _, right, bottom) = width >= SIDE_BY_SIDE, _box(width)
    height = bottom + BOTTOM
    shift = f"{right + RIGHT + 28:.1f} 0" if beside else f"0 {height + 6}"
    total = height if beside else 2 * height + 6
    return f'<svg class="vi" viewBox="0 0 {width} {total}">{first}<g transform="translate({shift})">{second}</g></svg>'


def _frame(axes: Axes, step: int, cursor: int, title: str, note: str, ticks: Sequence[Tick]) -> str:
    """Title, rules with their labels, motions below, the cursor. step: motions, a quarter of the axis."""
    x = axes.x_px(cursor)
    parts = [
        axes.title(title, note, 0, 12) + axes.rules(ticks),
        f'<path class="vi-cursor" d="M{x:.1f} {axes.top}V{axes.bottom}"/>',
        axes.beside(ticks, 6),
        axes.below([(motions, str(motions)) for motions in range(0, 4 * step + 1, step)], 15),
        svg.text(axes.right + 24, axes.bottom + 15, "motions", "vi-2nd"),
    ]
    return "".join(parts)


def _draw_E(box: Box, step: int, snapshots: list[Snapshot], motions: NDArray, cursor: int, E_true: float | None) -> str:
    E = np.maximum([snapshot.E for snapshot in snapshots], FLOOR_E)
    E_true = max(E_true, FLOOR_E) if E_true is not None and np.isfinite(E_true) else None
    y = decades(E if E_true is None else np.append(E, E_true))
    axes = Axes(box, (0.0, 4.0 * step), y, up=log10)
    parts = [_frame(axes, step, cursor, "Conflict E", "px², log; hollow = probe", decade_ticks(*y))]
    labels = []
    if E_true is not None:
        parts.append(axes.level(E_true, "vi-line-demo"))
        labels.append((float(axes.y_px(E_true)), f"true posture {svg.short_E(E_true)}", "vi-of-demo"))
    points = np.stack([axes.x_px(motions), axes.y_px(E)], -1)
    done = int(np.searchsorted(motions, cursor, side="right"))
    probes = np.array([snapshot.probe for snapshot in snapshots])
    parts.append(_curve(points, done, probes, "E"))
    if done and np.isfinite(points[done - 1, 1]):
        labels.append((float(points[done - 1, 1]), f"E {svg.short_E(E[done - 1])}", "vi-of-E"))
    return "".join(parts) + axes.labels(labels)


def _draw_angles(
    box: Box, step: int, snapshots: list[Snapshot], motions: NDArray, cursor: int, joints: Sequence[int]
) -> str:
    own = np.degrees(np.array([snapshot.theta for snapshot in snapshots]))
    demo = np.degrees(np.array([snapshot.theta_demo for snapshot in snapshots]))
    low, high = min(own.min(), demo.min()), max(own.max(), demo.max())
    every = 30 if high - low <= 110 else 60
    low, high = every * np.floor((low - 4) / every), every * np.ceil((high + 4) / every)
    axes = Axes(box, (0.0, 4.0 * step), (low, high))
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


def _curve(points: NDArray, done: int, probes: NDArray, role: str) -> str:
    """A line with a dot a motion, hollow for probes; what comes after the cursor is faint."""
    parts = []
    if done < len(points):
        parts.append(f'<path class="vi-line-{role} vi-later" d="{svg.path(points[max(done - 1, 0) :])}"/>')
    points, probes = points[:done], probes[:done]
    parts.append(f'<path class="vi-line-{role}" d="{svg.path(points)}"/>')
    seen = np.isfinite(points[:, 1])
    if done <= DOT_LIMIT:
        parts.append(f'<path class="vi-dot-{role}" d="{svg.dots(points[seen & ~probes])}"/>')
        if probes.any():
            parts.append(f'<path class="vi-probe-{role}" d="{svg.circles(points[seen & probes], 2.6)}"/>')
    if done and seen[-1]:
        parts.append(f'<path class="vi-last vi-dot-{role}" d="{svg.dots(points[-1:])}"/>')
    return "".join(parts)


def _x_step(last: int) -> int:
    """A quarter of the x axis: the smallest nice step with room for the last motion."""
    scale = 1
    while True:
        for step in STEPS[1:]:
            if 4 * step * scale >= last:
                return step * scale
        scale *= 10


def following(errors_deg: Sequence[float]) -> str:
    """How far off a learner is, and was in the last RECENT motions; nothing before the first motion."""
    recent = np.array(errors_deg[1:][-RECENT:])
    if len(recent) == 0:
        return ""
    count = "1 motion" if len(recent) == 1 else f"{len(recent)} motions"
    return f"{svg.number(recent[-1])}° off, rms {svg.number(np.sqrt(np.mean(recent**2)))}° over {count}"
