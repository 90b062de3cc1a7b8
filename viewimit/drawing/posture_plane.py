"""The plane of two joints' angles as a plot: the second joint to the right, the first upwards, one scale."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..simulation.scene import Scene
from . import svg
from .axes import Axes, angle_ticks
from .labels import CHARACTER, Labels

WIDTH = 424
LEFT, RIGHT, TOP, BOTTOM = MARGINS = 36, 8, 7, 34  # px around the plot
MOST_HIGH = 212  # px of the plot
ASKED = 18  # px behind the note, for a "?"
TICK = 38, 26  # px that the numbers at an axis are apart at least, side by side and above each other
GAP = 8  # px between words in a line
PAPER_RANGE_DEG = ((0.0, 90.0), (-180.0, 0.0))  # shown empty for a scene without two moving joints


class PosturePlane:
    """scale: px a degree. box: (x, y, w, h) px of the plot. labels: what is taken of it. width: px, with its axes;
    range_deg: of the two joints, in place of the scene's."""

    def __init__(
        self,
        scene: Scene,
        width: float = WIDTH,
        most_high: float = MOST_HIGH,
        margins: tuple[float, float, float, float] = MARGINS,
        range_deg: Sequence[tuple[float, float]] | None = None,
    ):
        self._width, self._right = width, width - margins[1]
        left, right, self._top, self._bottom = margins
        self.has_plane = len(scene.moving_joints) == 2
        ranges = (range_deg or scene.range_deg) if self.has_plane else PAPER_RANGE_DEG
        self._joints = [svg.joint_symbol(joint) for joint in scene.moving_joints] if self.has_plane else ["", ""]
        self._low, self._high = np.array(ranges, float).T
        span = self._high - self._low
        self.scale = float(min((width - left - right) / span[1], most_high / span[0]))
        w, h = span[1] * self.scale, span[0] * self.scale
        self.box = float(left + (width - left - right - w) / 2), self._top, float(w), float(h)
        edges = self.box[0], self._top, self.box[0] + self.box[2], self._top + self.box[3]
        up, across = zip(self._low.tolist(), self._high.tolist())
        self._axes = Axes(edges, across, up)
        self._slope = (
            np.array([edges[2] - edges[0], edges[1] - edges[3]]) / span[::-1]
        )  # px a degree, to the right, down
        self._origin = np.array([edges[0], edges[3]]) - self._slope * self._low[::-1]
        self.labels = Labels(*edges)

    @property
    def height(self) -> float:
        """px, with its axes"""
        return self._top + self.box[3] + self._bottom

    def place(self, degrees: NDArray) -> NDArray:
        """(..., 2) degrees → px, in one step: it is asked for several times a motion"""
        return degrees[..., ::-1] * self._slope + self._origin

    def grid(self, axes: tuple[NDArray, NDArray]) -> tuple[NDArray, NDArray]:
        """px of the columns and of the rows of a grid over axes, rad"""
        first, second = (np.degrees(axis) for axis in axes)
        return self._axes.x_px(second), self._axes.y_px(first)

    def wrap(self, inside: str, over: str = "") -> str:
        """A drawing of the plane's size. over: class of an element that lies over another."""
        drawing = (
            f'<div class="vi-panel"><svg class="vi" viewBox="0 0 {self._width} {self.height:.1f}">{inside}</svg></div>'
        )
        return f'<div class="{over}">{drawing}</div>' if over else drawing

    def frame(self, classes: str) -> str:
        x, y, w, h = self.box
        return f'<rect class="{classes}" x="{x:.1f}" y="{y:.1f}" width="{w:.1f}" height="{h:.1f}"/>'

    def message(self, words: str) -> str:
        """A sentence in the middle of an empty plot."""
        x, y, w, h = self.box
        return svg.text(x + w / 2, y + h / 2, words, "vi-2nd vi-mid")

    def ends(self) -> str:
        """The frame with the ends of its sides and their names: axes for a small plot."""
        left, top, w, h = self.box
        bottom, low, high = top + h, self._low.tolist(), self._high.tolist()
        degrees = lambda angle: svg.number(angle, 0) + "°"
        return "".join(
            [
                self.frame("vi-axis"),
                svg.text(left, bottom + 12, degrees(low[1]), "vi-2nd"),
                svg.text(left + w, bottom + 12, degrees(high[1]), "vi-2nd vi-end"),
                svg.text(left + w / 2, bottom + 12, self._joints[1], "vi-mid"),
                svg.text(left - 4, top + 9, degrees(high[0]), "vi-2nd vi-end"),
                svg.text(left - 4, bottom, degrees(low[0]), "vi-2nd vi-end"),
                svg.text(left - 4, top + h / 2 + 4, self._joints[0], "vi-end"),
            ]
        )

    def axes(self, note: str = "", contours: str = "E in px²", named: bool = True) -> str:
        """The frame with ticks and names. note: below, at the right; contours: what they are of; named: as contours."""
        left, top, w, h = self.box
        bottom = top + h
        parts, ticks = [self.frame("vi-axis")], []
        across, up = [], [top, bottom]  # px of the numbers
        for angle, words in angle_ticks(self._low[1], self._high[1], TICK[0] / self.scale):
            x = float(self._axes.x_px(angle))
            ticks.append(f"M{x:.1f} {bottom:.1f}v4")
            across.append(x)
            anchor = "vi-2nd vi-end" if x > self._width - 16 else "vi-2nd vi-mid"
            parts.append(svg.text(min(x, self._width - 2), bottom + 15, words, anchor))
        for angle, words in angle_ticks(self._low[0], self._high[0], TICK[1] / self.scale):
            y = float(self._axes.y_px(angle))
            ticks.append(f"M{left:.1f} {y:.1f}h-4")
            up.append(y)
            parts.append(svg.text(left - 7, np.clip(y + 4, 10, bottom), words, "vi-2nd vi-end"))
        parts.append(svg.text(left - 8, _widest_gap(up) + 4, self._joints[0], "vi-end"))
        parts += self._below(bottom, f"{'contours: ' if named else ''}{contours}", note, across)
        return f'<path class="vi-axis" d="{"".join(ticks)}"/>' + "".join(parts)

    def _below(self, bottom: float, contours: str, note: str, numbers: list[float]) -> list[str]:
        """The line under the numbers: contours at the left, the note at the right, and in the middle the axis' name,
        which goes aside or up between the numbers where they meet. numbers: px."""
        left, _, w, _ = self.box
        end = self._right - ASKED if note else self._right
        begin = min(left, max(0.0, end - _length(note) - GAP - _length(contours)))
        free = begin + _length(contours) + GAP, end - _length(note) - GAP
        half, x, y = _length(self._joints[1]) / 2, left + w / 2, bottom + 29
        if free[1] - free[0] >= 2 * half:
            x = float(np.clip(x, free[0] + half, free[1] - half))
        else:
            x, y = _widest_gap([left, left + w, *numbers]), bottom + 15
        words = [svg.text(begin, y_line := bottom + 29, contours, "vi-2nd"), svg.text(x, y, self._joints[1], "vi-mid")]
        return [*words, svg.text(end, y_line, note, "vi-2nd vi-end")] if note else words


def _length(words: str) -> float:
    """px at most"""
    return CHARACTER * len(words)


def _widest_gap(places: list[float]) -> float:
    """The middle of the first of the widest between neighbours."""
    places = sorted(places)
    k = int(np.argmax(np.diff(places).round(3)))
    return (places[k] + places[k + 1]) / 2
