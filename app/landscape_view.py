"""The landscape of E over two joints, and the path of the learner on it.

The picture with shading and contours is made once a landscape; the path is an element of its own that lies
over it, so that a motion resends only that.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from viewimit.landscape import Landscape
from viewimit.scene import Scene
from viewimit.session import Snapshot

from . import relief, svg
from .labels import Labels
from .theme import OBSERVED

WIDTH = 424
LEFT, RIGHT, TOP, BOTTOM = 36, 8, 7, 34  # px around the plot
MOST_HIGH = 212  # px of the plot
CLOSE_DEG, INSET = 6.0, 74  # when demonstrator and smallest E are nearer than that: an inset of ±CLOSE_DEG, px wide
PATH_LIMIT, DOT_LIMIT = 300, 60  # vertices of the path; motions up to which each has a dot
INSET_MOTIONS = 30  # that the inset shows


class LandscapePicture:
    """html: the picture; draw_path: what lies over it. The second joint runs to the right, the first upwards.

    The demonstrator's mark is the truth, for the viewer.
    """

    def __init__(self, landscape: Landscape | None, scene: Scene, snapshot: Snapshot, message: str = "computing …"):
        self._joints = scene.moving_joints
        self._flat = len(scene.moving_joints) == 2
        low, high = (scene.lower, scene.upper) if self._flat else (np.radians([0, -180]), np.radians([90, 0]))
        self._low, self._high = np.degrees(low), np.degrees(high)
        span = self._high - self._low
        self._scale = min((WIDTH - LEFT - RIGHT) / span[1], MOST_HIGH / span[0])  # px a degree
        self._w, self._h = span[1] * self._scale, span[0] * self._scale
        self._left = LEFT + (WIDTH - LEFT - RIGHT - self._w) / 2
        self._labels = Labels(self._left, TOP, self._left + self._w, TOP + self._h)
        if not self._flat:
            message = f"a landscape needs two moving joints; this scene has {len(scene.moving_joints)}"
        self._above = ""  # marks and their labels: over the path
        self._zoom: tuple[NDArray, NDArray] | None = None  # centre of the inset, px and degrees
        if landscape is None or np.isnan(landscape.E).all():
            if landscape is not None:
                message = "nowhere are five points seen in all four images"
            inside = svg.text(self._left + self._w / 2, TOP + self._h / 2, message, "vi-2nd vi-mid")
        else:
            inside = self._draw(landscape, snapshot)
        self.html = self._wrap(self._background() + inside + self._axes())

    def draw_path(self, history: Sequence[Snapshot], cursor: int, theta: NDArray | None = None) -> str:
        """The motions up to the cursor, later ones faint. theta: (m,) rad, where the arm is seen while it moves."""
        if not self._flat or len(history[0].theta) != 2:
            return self._wrap("", "vi-over")
        kept = svg.thinned(len(history), PATH_LIMIT)
        points = self._place(np.degrees([history[k].theta for k in kept]))
        done = int(np.searchsorted(kept, cursor, side="right"))
        now = points[done - 1] if theta is None else self._place(np.degrees(theta))
        parts = []
        if done < len(points):
            parts.append(f'<path class="vi-line-own vi-later" d="{svg.path(points[done - 1 :])}"/>')
        line = points[:done] if theta is None else np.concatenate([points[: max(done - 1, 1)], now[None]])
        parts.append(f'<path class="vi-line-own" d="{svg.path(line)}"/>')
        if len(history) <= DOT_LIMIT:
            probe = np.array([snapshot.probe for snapshot in history[:done]])
            parts.append(f'<path class="vi-dot-own" d="{svg.dots(points[:done][~probe])}"/>')
            if probe.any():
                parts.append(f'<path class="vi-probe-own" d="{svg.circles(points[:done][probe], 2.6)}"/>')
        shown = history[cursor].theta if theta is None else theta
        dot, label = self._now(points[0], now, shown, cursor)
        parts += [dot, self._in_inset(line), self._above, label]
        return self._wrap("".join(parts), "vi-over")

    def _now(self, start: NDArray, now: NDArray, theta: NDArray, cursor: int) -> tuple[str, str]:
        """The big dot, and the labels of it and of the start."""
        labels = self._labels.copy()
        labels.take_point(*now, 7)
        name = "now" if cursor else "start"
        words = f"{name} ({svg.degrees(theta[0])}, {svg.degrees(theta[1])})"
        label = labels.beside(*now, words, "vi-of-own vi-halo", 11)
        if cursor and np.hypot(*(start - now)) > 14:
            labels.take_point(*start, 4)
            label += labels.beside(*start, "start", "vi-2nd vi-halo", 8)
        return f'<circle class="vi-now" cx="{now[0]:.1f}" cy="{now[1]:.1f}" r="5.8"/>', label

    def _place(self, degrees: NDArray) -> NDArray:
        """(..., 2) degrees → px"""
        x = self._left + (degrees[..., 1] - self._low[1]) * self._scale
        return np.stack([x, TOP + (self._high[0] - degrees[..., 0]) * self._scale], -1)

    def _wrap(self, inside: str, over: str = "") -> str:
        height = TOP + self._h + BOTTOM
        drawing = f'<div class="vi-panel"><svg class="vi" viewBox="0 0 {WIDTH} {height:.1f}">{inside}</svg></div>'
        return f'<div class="{over}">{drawing}</div>' if over else drawing

    def _background(self) -> str:
        return f'<rect class="vi-plane" x="{self._left:.1f}" y="{TOP}" width="{self._w:.1f}" height="{self._h:.1f}"/>'

    def _draw(self, landscape: Landscape, snapshot: Snapshot) -> str:
        grid = self._grid(landscape.axes)
        demo, lowest = np.degrees(snapshot.theta_demo), np.degrees(landscape.minimum)
        marks = self._place(np.stack([demo, lowest]))
        start = self._place(np.array(snapshot.settings.start_deg))
        labels = self._labels
        for mark in marks:
            labels.take_point(*mark, 8)
        for share in np.linspace(0, 0.9, 12):  # where the path will probably run
            labels.take_point(*(start + share * (marks[1] - start)), 7)
        inset = ""
        if np.max(np.abs(demo - lowest)) < CLOSE_DEG:
            inset = self._inset(landscape, demo, lowest, start)
        leaders = self._leaders(marks, demo, lowest)
        shading = relief.shading(grid, landscape.E, (self._left, TOP, self._w, self._h))
        contours = relief.contours(grid, landscape.E, labels, marks[1])
        self._above = _marks(marks) + leaders + self._above
        return shading + contours + inset

    def _grid(self, axes: tuple[NDArray, NDArray]) -> tuple[NDArray, NDArray]:
        """px of the grid's columns and rows"""
        x = self._place(np.stack([np.full(len(axes[1]), self._low[0]), np.degrees(axes[1])], -1))[:, 0]
        y = self._place(np.stack([np.degrees(axes[0]), np.full(len(axes[0]), self._low[1])], -1))[:, 1]
        return x, y

    def _leaders(self, marks: NDArray, demo: NDArray, lowest: NDArray) -> str:
        """Labels of the two marks, led to from where there is room."""
        parts = []
        left_first = marks[0, 0] <= marks[1, 0] + 1
        for k, (name, posture, kind) in enumerate(
            (("demonstrator", demo, "vi-lead-demo"), ("smallest E", lowest, "vi-lead"))
        ):
            words = f"{name} ({svg.number(posture[0], 0)}°, {svg.number(posture[1], 0)}°)"
            parts.append(self._labels.led(*marks[k], words, kind, to_left=(k == 0) == left_first))
        return "".join(parts)

    def _inset(self, landscape: Landscape, demo: NDArray, lowest: NDArray, start: NDArray) -> str:
        """Both marks and what lies around them, enlarged, in the corner farthest from marks and start."""
        centre = (demo + lowest) / 2
        busy = [*self._place(np.stack([demo, lowest, (centre + self._inverse(start)) / 2])), start]
        side = INSET / 2
        corners = [
            np.array([x, y])
            for x in (self._left + side + 4, self._left + self._w - side - 4)
            for y in (TOP + side + 4, TOP + self._h - side - 4)
        ]
        middle = max(corners, key=lambda corner: min(np.hypot(*(corner - point)) for point in busy))
        self._labels.take(*(middle - side - 3), *(middle + side + 3))
        k = INSET / (2 * CLOSE_DEG)
        place = lambda posture: middle + (posture - centre)[..., ::-1] * (k, -k)
        rows, columns = (
            np.flatnonzero(np.abs(np.degrees(axis) - c) < CLOSE_DEG + 1.5) for axis, c in zip(landscape.axes, centre)
        )
        x = place(np.stack([np.full(len(columns), centre[0]), np.degrees(landscape.axes[1][columns])], -1))[:, 0]
        y = place(np.stack([np.degrees(landscape.axes[0][rows]), np.full(len(rows), centre[1])], -1))[:, 1]
        near = relief.fine_contours((x, y), landscape.E[np.ix_(rows, columns)])
        left, top = middle - side
        self._zoom = middle, centre
        self._above = _marks(place(np.stack([demo, lowest])))
        return (
            f'<svg x="{left:.1f}" y="{top:.1f}" width="{INSET}" height="{INSET}" viewBox="{left:.1f} {top:.1f} {INSET}'
            f' {INSET}"><rect class="vi-inset" x="{left + 0.5:.1f}" y="{top + 0.5:.1f}" width="{INSET - 1}"'
            f' height="{INSET - 1}" rx="3"/>{near}'
            + svg.text(left + 5, top + INSET - 5, f"±{CLOSE_DEG:g}°", "vi-2nd vi-halo")
            + "</svg>"
        )

    def _in_inset(self, line: NDArray) -> str:
        """The last motions where the inset shows them. line: (k, 2) px of the plot."""
        if self._zoom is None:
            return ""
        middle, centre = self._zoom
        near = middle + (line[-INSET_MOTIONS:] - self._place(centre)) * (INSET / (2 * CLOSE_DEG * self._scale))
        if np.abs(near[-1] - middle).max() > INSET / 2 - 3:
            return ""
        left, top = middle - INSET / 2
        return (
            f'<svg x="{left:.1f}" y="{top:.1f}" width="{INSET}" height="{INSET}" viewBox="{left:.1f} {top:.1f} {INSET}'
            f' {INSET}"><path class="vi-line-own" d="{svg.path(near)}"/>'
            f'<circle class="vi-now" cx="{near[-1, 0]:.1f}" cy="{near[-1, 1]:.1f}" r="5.8"/></svg>'
        )

    def _inverse(self, point: NDArray) -> NDArray:
        """px → degrees"""
        return np.array(
            [self._high[0] - (point[1] - TOP) / self._scale, self._low[1] + (point[0] - self._left) / self._scale]
        )

    def _axes(self) -> str:
        right, bottom = self._left + self._w, TOP + self._h
        parts = [
            f'<rect class="vi-axis" x="{self._left:.1f}" y="{TOP}" width="{self._w:.1f}" height="{self._h:.1f}"/>'
            f'<text class="vi-2nd" x="{self._left:.1f}" y="{bottom + 29:.1f}">contours: E in px²</text>'
        ]
        if self._flat:
            first, second = map(svg.joint_symbol, self._joints)
            parts.append(svg.text((self._left + right) / 2, bottom + 29, second, "vi-mid"))
            parts.append(svg.text(self._left - 8, TOP + self._h * 0.25 + 4, first, "vi-end"))
        ticks = []
        for angle in _ticks(self._low[1], self._high[1]):
            x = self._place(np.array([self._low[0], angle]))[0]
            ticks.append(f"M{x:.1f} {bottom:.1f}v4")
            anchor = "vi-2nd vi-end" if x > WIDTH - 16 else "vi-2nd vi-mid"
            parts.append(svg.text(min(x, WIDTH - 2), bottom + 15, svg.number(angle, 0) + "°", anchor))
        for angle in _ticks(self._low[0], self._high[0]):
            y = self._place(np.array([angle, self._low[1]]))[1]
            ticks.append(f"M{self._left:.1f} {y:.1f}h-4")
            parts.append(svg.text(self._left - 7, np.clip(y + 4, 10, bottom), svg.number(angle, 0) + "°", "vi-2nd vi-end"))
        return f'<path class="vi-axis" d="{"".join(ticks)}"/>' + "".join(parts)


def _marks(points: NDArray) -> str:
    """The demonstrator's diamond and the cross of the smallest E, larger so that neither hides the other."""
    x, y = points[1]
    return (
        f'<path class="vi-seen" d="{svg.diamonds(points[:1], OBSERVED + 1)}"/>'
        f'<path class="vi-cross" d="M{x - 6:.1f} {y:.1f}h12M{x:.1f} {y - 6:.1f}v12"/>'
    )


def _ticks(low: float, high: float) -> NDArray:
    step = 45 if high - low > 130 or high - low == 90 else 30
    return np.arange(np.ceil(low / step) * step, high + 1e-9, step)
