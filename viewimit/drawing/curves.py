"""E and the joint angles over the motions, with direct labels instead of legends."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..analysis.joint_errors import RECENT
from ..snapshot import Snapshot
from . import svg

SIDE_BY_SIDE = 600  # px of width from which the plots stand beside each other
CARD_HEIGHT, TAB_HEIGHT = 132, 140  # px of one plot
LEFT, RIGHT, TOP, BOTTOM = 40, 104, 24, 20
LIMIT, DOT_LIMIT = 90, 48  # vertices of a curve; motions up to which each has a dot
STEPS = (1, 2, 4, 5, 10)  # x 10^k: the x axis ends at four of them
APART = 13  # px between labels
FLOOR_E = 1e-3  # px² below which E is drawn as this: nobody could see that conflict


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
    beside = width >= SIDE_BY_SIDE
    height = CARD_HEIGHT if beside else TAB_HEIGHT
    w = (width - 28) / 2 if beside else width
    kept = svg.thinned(len(history), LIMIT, cursor)
    snapshots = [history[k] for k in kept]
    motions = np.array(kept, float)
    axis = _Axis(w, height, len(history) - 1, cursor)
    first = _draw_E(axis, snapshots, motions, cursor, E_true)
    second = _draw_angles(axis, snapshots, motions, cursor, joints)
    second += svg.text(w, 12, following(errors_deg), "vi-end")
    shift = f"{w + 28:.1f} 0" if beside else f"0 {height + 6}"
    total = height if beside else 2 * height + 6
    return (
        f'<div class="vi-panel"><svg class="vi" viewBox="0 0 {width} {total}">{first}'
        f'<g transform="translate({shift})">{second}</g></svg></div>'
    )


class _Axis:
    """Motions to the right. right: px where the plot ends and the labels begin."""

    def __init__(self, width: float, height: float, last: int, cursor: int):
        self.right, self.bottom = width - RIGHT, height - BOTTOM
        self.step = _x_step(last)
        self._k = (self.right - LEFT) / (4 * self.step)
        self.cursor = self.x(cursor)

    def x(self, motions):
        return LEFT + self._k * motions

    def frame(self, title: str, note: str, ticks: Sequence[tuple[float, str]]) -> str:
        """Title, rules with their labels at (y px, text), motions below, the cursor."""
        rules = "".join([f"M{LEFT} {y:.1f}H{self.right:.1f}" for y, _ in ticks])
        parts = [
            f'<text y="12"><tspan class="vi-b">{title}</tspan><tspan class="vi-2nd" dx="5">{note}</tspan></text>'
            f'<path class="vi-rule" d="{rules}"/>'
            f'<path class="vi-cursor" d="M{self.cursor:.1f} {TOP}V{self.bottom}"/>'
        ]
        parts += [f'<text class="vi-2nd vi-end" x="{LEFT - 6}" y="{y + 4:.1f}">{label}</text>' for y, label in ticks]
        y = self.bottom + 15
        for motions in range(0, 4 * self.step + 1, self.step):
            parts.append(f'<text class="vi-2nd vi-mid" x="{self.x(motions):.1f}" y="{y}">{motions}</text>')
        parts.append(f'<text class="vi-2nd" x="{self.right + 24:.1f}" y="{y}">motions</text>')
        return "".join(parts)


def _draw_E(axis: _Axis, snapshots: list[Snapshot], motions: NDArray, cursor: int, E_true: float | None) -> str:
    E = np.maximum([snapshot.E for snapshot in snapshots], FLOOR_E)
    known = E[E > 0]
    if E_true is not None:
        E_true = max(E_true, FLOOR_E) if np.isfinite(E_true) else None
    everything = known if E_true is None else np.append(known, E_true)
    low, high = (0, 3) if len(everything) == 0 else _decades(everything.min(), everything.max())
    y_of = lambda value: axis.bottom - (axis.bottom - TOP) * (np.log10(np.maximum(value, 1e-30)) - low) / (high - low)
    every = max(1, -(-(high - low) // 4))
    ticks = [(float(y_of(10.0**k)), f"{10.0**k:g}") for k in range(low, high + 1, every)]
    parts = [axis.frame("Conflict E", "px², log; hollow = probe", ticks)]
    labels = []
    if E_true is not None:
        y = float(y_of(E_true))
        parts.append(f'<path class="vi-line-demo" d="M{LEFT} {y:.1f}H{axis.right:.1f}"/>')
        labels.append((y, f"true posture {_short(E_true)}", "vi-of-demo"))
    points = np.stack([axis.x(motions), np.where(E > 0, y_of(np.where(E > 0, E, 1.0)), np.nan)], -1)
    done = int(np.searchsorted(motions, cursor, side="right"))
    probes = np.array([snapshot.probe for snapshot in snapshots])
    parts.append(_curve(points, done, probes, "E"))
    if done and np.isfinite(points[done - 1, 1]):
        value = E[done - 1]
        labels.append((float(points[done - 1, 1]), f"E {_short(value)}", "vi-of-E"))
    return "".join(parts) + _labels(axis, labels)


def _short(E: float) -> str:
    return "< 0.01" if E < 0.01 else svg.number(E, 2 if E < 10 else 1)


def _draw_angles(axis: _Axis, snapshots: list[Snapshot], motions: NDArray, cursor: int, joints: Sequence[int]) -> str:
    own, demo = np.degrees(
        [[snapshot.theta for snapshot in snapshots], [snapshot.theta_demo for snapshot in snapshots]]
    )
    low, high = min(own.min(), demo.min()), max(own.max(), demo.max())
    step = 30 if high - low <= 110 else 60
    low, high = step * np.floor((low - 4) / step), step * np.ceil((high + 4) / step)
    y_of = lambda angle: axis.bottom - (axis.bottom - TOP) * (angle - low) / (high - low)
    ticks = [(float(y_of(angle)), svg.number(angle, 0) + "°") for angle in np.arange(low, high + 1, step)]
    parts = [axis.frame("Joint angles", "dashed = demonstrator", ticks)]
    done = int(np.searchsorted(motions, cursor, side="right"))
    probes = np.array([snapshot.probe for snapshot in snapshots])
    x, labels = axis.x(motions), []
    for k, joint in enumerate(joints):
        name = svg.joint_symbol(joint)
        aim = y_of(demo[:done, k])
        if (aim == aim[0]).all():
            line = np.array([[LEFT, aim[0]], [axis.right, aim[0]]])
        else:
            line = np.array([[*x[:done], axis.right], [*aim, aim[-1]]]).T
        parts.append(f'<path class="vi-line-demo" d="{svg.path(line)}"/>')
        points = np.array([x, y_of(own[:, k])]).T
        parts.append(_curve(points, done, probes, "own"))
        angle = own[done - 1, k]
        labels.append((float(points[done - 1, 1]), f"{name} {svg.number(angle)}°", "vi-of-own"))
        if len(joints) <= 3:
            labels.append((float(line[-1, 1]), f"{name} = {svg.number(demo[done - 1, k], 0)}°", "vi-of-demo"))
    return "".join(parts) + _labels(axis, labels)


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


def _labels(axis: _Axis, labels: list[tuple[float, str, str]]) -> str:
    """Right of the plot, at the height of what they name, moved apart where they would meet."""
    labels = sorted(labels)
    y = [min(max(label[0], TOP + 2), axis.bottom - 1) for label in labels]
    for _ in range(3):
        for i in range(1, len(y)):
            y[i] = max(y[i], y[i - 1] + APART)
        over = y[-1] - axis.bottom + 1 if y else 0
        if over <= 0:
            break
        y[-1] -= over
        for i in range(len(y) - 1, 0, -1):
            y[i - 1] = min(y[i - 1], y[i] - APART)
    x = axis.right + 7
    return "".join(svg.text(x, place + 4, words, role) for place, (_, words, role) in zip(y, labels))


def _x_step(last: int) -> int:
    """A quarter of the x axis: the smallest nice step with room for the last motion."""
    scale = 1
    while True:
        for step in STEPS[1:]:
            if 4 * step * scale >= last:
                return step * scale
        scale *= 10


def _decades(low: float, high: float) -> tuple[int, int]:
    first, last = int(np.floor(np.log10(low))), int(np.ceil(np.log10(high)))
    return max(first, last - 12), max(last, first + 1)


def following(errors_deg: Sequence[float]) -> str:
    """How far off a learner is, and was in the last RECENT motions; nothing before the first motion."""
    recent = np.array(errors_deg[1:][-RECENT:])
    if len(recent) == 0:
        return ""
    count = "1 motion" if len(recent) == 1 else f"{len(recent)} motions"
    return f"{svg.number(recent[-1])}° off, rms {svg.number(np.sqrt(np.mean(recent**2)))}° over {count}"
