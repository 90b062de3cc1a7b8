"""The plane of two joints' angles as a plot, and the labels of a path that grows in it.

The second joint's angle points to the right, the first's upwards, with one scale.
"""

from collections.abc import Sequence

import numpy as np

from ..geometry.arrays import Floats
from ..loop.snapshot import Snapshot
from ..simulation.scene import Scene
from . import svg
from .labels import CHARACTER, Label, Labels, PlacedLabel, Rectangle, beside, line_rectangles, places_beside, text_at
from .plots import Axes, angle_ticks

WIDTH = 424
LEFT, RIGHT, TOP, BOTTOM = MARGINS = 36, 8, 7, 34  # px around the plot
MAX_HEIGHT = 190  # px of the plot: that of 180° by 90° in this width
NOTE_MARGIN = 18  # px behind the note, for a "?"
TICK_SPACING = 38, 26  # px between numbers at least, horizontally and vertically
GAP = 8  # px between words in a line
PAPER_RANGE_DEG = ((0.0, 90.0), (-180.0, 0.0))  # shown empty for a scene without two moving joints
NOW = 5.8  # px, radius of the dot at the path's end
CLEARANCE = 3.0  # px that labels leave free on both sides of the path
MIN_DISTANCE = 20.0  # px between start and learner for each to have a label
AHEAD = 4.0  # px around the dot that newly placed labels leave free for the next motions


class PosturePlane:
    """A plot over the angles of a scene's two moving joints; with another number of them it stays empty.

    width: of the drawing with its axes, px; max_height: of the plot; margins: left, right, top and bottom of it;
    range_deg: of the joints, instead of the scene's.
    """

    def __init__(
        self,
        scene: Scene,
        width: float = WIDTH,
        max_height: float = MAX_HEIGHT,
        margins: tuple[float, float, float, float] = MARGINS,
        range_deg: Sequence[tuple[float, float]] | None = None,
    ):
        self._width, self._right = width, width - margins[1]
        left, right, self._top, self._bottom = margins
        self.has_plane = len(scene.moving_joints) == 2  # whether two joints move
        ranges = (range_deg or scene.range_deg) if self.has_plane else PAPER_RANGE_DEG
        self._joints = [svg.joint_symbol(joint) for joint in scene.moving_joints] if self.has_plane else ["", ""]
        self._low, self._high = np.array(ranges, float).T
        span = self._high - self._low
        self.scale = float(min((width - left - right) / span[1], max_height / span[0]))  # px per degree
        w, h = span[1] * self.scale, span[0] * self.scale
        # x, y, width and height of the plot, px
        self.box = float(left + (width - left - right - w) / 2), self._top, float(w), float(h)
        edges = self.box[0], self._top, self.box[0] + self.box[2], self._top + self.box[3]
        up, across = zip(self._low.tolist(), self._high.tolist())
        self._axes = Axes(*edges, across, up)
        self._slope = np.array([edges[2] - edges[0], edges[1] - edges[3]]) / span[::-1]  # px per degree
        self._origin = np.array([edges[0], edges[3]]) - self._slope * self._low[::-1]
        self.labels = Labels(*edges)

    @property
    def height(self) -> float:
        """Height with the axes, px."""
        return self._top + self.box[3] + self._bottom

    def place(self, degrees: Floats) -> Floats:
        """Convert postures, (..., 2) degrees, to px. Called several times per motion, hence in one step."""
        return degrees[..., ::-1] * self._slope + self._origin

    def grid(self, axes: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
        """Return the px of a grid's columns and rows. axes: of both joints, rad."""
        first, second = (np.degrees(axis) for axis in axes)
        return self._axes.x_px(second), self._axes.y_px(first)

    def wrap(self, inside: str, over: str = "") -> str:
        """Wrap a drawing of the plane's size in HTML. over: class of an element that lies over another."""
        drawing = (
            f'<div class="vi-panel"><svg class="vi" viewBox="0 0 {self._width} {self.height:.1f}">{inside}</svg></div>'
        )
        return f'<div class="{over}">{drawing}</div>' if over else drawing

    def frame(self, classes: str) -> str:
        """Draw the edges of the plot."""
        x, y, w, h = self.box
        return f'<rect class="{classes}" x="{x:.1f}" y="{y:.1f}" width="{w:.1f}" height="{h:.1f}"/>'

    def message(self, words: str) -> str:
        """Draw a sentence in the middle of an empty plot."""
        x, y, w, h = self.box
        return svg.text(x + w / 2, y + h / 2, words, "vi-2nd vi-mid")

    def ends(self) -> str:
        """Draw the axes of a small plot: the frame, names, and only the ends of the ranges."""
        left, top, w, h = self.box
        bottom, low, high = top + h, self._low.tolist(), self._high.tolist()
        degrees = lambda angle: svg.number(angle, 0) + "°"
        words = (
            (left, bottom + 12, degrees(low[1]), "vi-2nd"),
            (left + w, bottom + 12, degrees(high[1]), "vi-2nd vi-end"),
            (left + w / 2, bottom + 12, self._joints[1], "vi-mid"),
            (left - 4, top + 9, degrees(high[0]), "vi-2nd vi-end"),
            (left - 4, bottom, degrees(low[0]), "vi-2nd vi-end"),
            (left - 4, top + h / 2 + 4, self._joints[0], "vi-end"),
        )
        return self.frame("vi-axis") + "".join(svg.text(*each) for each in words)

    def axes(self, note: str = "", contours: str = "E in px²", warns: bool = True) -> str:
        """Draw the axes: frame, ticks and names.

        note: words below, at the right; contours: the quantity; warns: whether the note is more than a detail.
        """
        left, top, w, h = self.box
        bottom = top + h
        parts, ticks = [self.frame("vi-axis")], []
        across, up = [], [top, bottom]  # px of the numbers
        for angle, words in angle_ticks(self._low[1], self._high[1], TICK_SPACING[0] / self.scale):
            x = float(self._axes.x_px(angle))
            ticks.append(f"M{x:.1f} {bottom:.1f}v4")
            across.append(x)
            anchor = "vi-2nd vi-end" if x > self._width - 16 else "vi-2nd vi-mid"
            parts.append(svg.text(min(x, self._width - 2), bottom + 15, words, anchor))
        for angle, words in angle_ticks(self._low[0], self._high[0], TICK_SPACING[1] / self.scale):
            y = float(self._axes.y_px(angle))
            ticks.append(f"M{left:.1f} {y:.1f}h-4")
            up.append(y)
            parts.append(svg.text(left - 7, np.clip(y + 4, 10, bottom), words, "vi-2nd vi-end"))
        parts.append(svg.text(left - 8, _widest_gap(up) + 4, self._joints[0], "vi-end"))
        parts += self._below(bottom, f"contours: {contours}", note, across, "" if warns else " vi-detail")
        return f'<path class="vi-axis" d="{"".join(ticks)}"/>' + "".join(parts)

    def _below(self, bottom: float, contours: str, note: str, numbers: list[float], kind: str) -> list[str]:
        """Draw the line under the numbers: contours, name of the axis, note. numbers: their px; kind: of the note.

        The name moves sideways, or up between the numbers, if the line has no room in the middle.
        """
        left, __, w, __ = self.box
        end = self._right - NOTE_MARGIN if note else self._right
        begin = min(left, max(0.0, end - _length(note) - GAP - _length(contours)))
        free = begin + _length(contours) + GAP, end - _length(note) - GAP
        half, x, y = _length(self._joints[1]) / 2, left + w / 2, bottom + 29
        if free[1] - free[0] >= 2 * half:
            x = float(np.clip(x, free[0] + half, free[1] - half))
        else:
            x, y = _widest_gap([left, left + w, *numbers]), bottom + 15
        words = [svg.text(begin, y_line := bottom + 29, contours, "vi-2nd"), svg.text(x, y, self._joints[1], "vi-mid")]
        return [*words, svg.text(end, y_line, note, f"vi-2nd vi-end{kind}")] if note else words


def _length(words: str) -> float:
    """Return the width of words at most, px."""
    return CHARACTER * len(words)


def _widest_gap(places: list[float]) -> float:
    """Return the middle of the first of the widest gaps between neighbours."""
    places = sorted(places)
    k = int(np.argmax(np.diff(places).round(3)))
    return (places[k] + places[k + 1]) / 2


# Labels of a path


class PathLabels:
    """Labels beside a path that grows. They stay in place as long as the path does not cover them.

    plane: the plot, with its occupied rectangles; labels: of marks and contours, those that find no free place are
    left out.
    """

    def __init__(self, plane: PosturePlane, labels: Sequence[Label]):
        self._plane, self._labels = plane, labels
        self._placed: dict[int, PlacedLabel] = {}  # by their number, the start's 0
        self._free: Labels | None = None  # occupied by the path and the labels
        self._line: Labels | None = None  # occupied by the path
        self._path: tuple = ()  # for which they were placed: its length, cursor, and both ends

    def draw(self, history: Sequence[Snapshot], cursor: int, theta: Floats | None, points: Floats) -> str:
        """Draw all labels.

        history, cursor: snapshots, and the index of the shown one; theta: where the arm is shown while it moves, (m,)
        rad; only the learner's label follows it. None at rest; points: the path as it is drawn, (k, 2) px.
        """
        start, here = history[0].theta, history[cursor].theta
        path = len(history), cursor, start.tobytes(), here.tobytes()
        if self._free is None or self._path != path:
            if self._path[2:3] != path[2:3]:
                self._placed = {}
            before = history[cursor - 1].theta
            if self._line is not None and self._path == (cursor, cursor - 1, start.tobytes(), before.tobytes()):
                points = self._plane.place(np.degrees([before, here]))  # it has grown by one motion
            else:
                self._line = self._plane.labels.copy()
            self._line.take(*line_rectangles(points, CLEARANCE))
            self._free, self._path = self._place(self._line.copy(), start, here, cursor), path
        own, _ = self._own(self._free, here if theta is None else theta, cursor)
        return "".join([label.drawn for label in self._placed.values()]) + own

    def _place(self, line: Labels, start: Floats, here: Floats, cursor: int) -> Labels:
        """Place the learner's label and those that are covered; all of them if it has no room beside the others.

        line: occupied by the path. Returns what is occupied without the learner's label, which follows the arm.
        """
        begun, now = self._plane.place(np.degrees([start, here]))
        line.take_points(now, NOW)
        labels = dict(enumerate(self._labels, 1))
        if cursor > 0 and np.abs(now - begun).max() > MIN_DISTANCE:
            x, y = begun.tolist()
            labels = {0: beside(x, y, "start", "vi-2nd vi-halo", 8)} | labels
        kept_places = {k: one for k, one in self._placed.items() if k in labels and one.place}
        uncovered = {k: one for k, one in kept_places.items() if not any(map(line.covers, one.occupies))}
        for kept in (uncovered, {}):
            free = line.copy()
            free.take_points(now, NOW + AHEAD)
            for one in kept.values():
                free.take(*one.occupies)
            _, own = self._own(free, here, cursor)
            if own is not None:
                break
        taken = free.copy()
        taken.take(*([] if own is None else [own]))
        self._placed = {k: kept.get(k) or taken.put(label) for k, label in labels.items()}
        for one in self._placed.values():
            free.take(*one.occupies)
        return free

    def _own(self, labels: Labels, theta: Floats, cursor: int) -> tuple[str, Rectangle | None]:
        """Draw the learner's label at theta, (m,) rad, and return its place, which it does not occupy."""
        x, y = self._plane.place(np.degrees(theta)).tolist()
        where = f"({svg.degrees(theta[0])}, {svg.degrees(theta[1])})"
        words = ("now {pose}" if cursor else "start {pose}").format(pose=where)
        place = labels.first_free(places_beside(x, y, _length(words), 11))
        return ("" if place is None else text_at(place, words, "vi-of-own vi-halo")), place
