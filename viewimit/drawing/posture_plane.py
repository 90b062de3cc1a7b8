"""The plane of two joints' angles as a plot: the second joint to the right, the first upwards, one scale."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..loop.snapshot import Snapshot
from ..simulation.scene import Scene
from . import svg
from .labels import CHARACTER, Label, Labels, Put, Rectangle, beside, line_taken, meet, places_beside, text_at
from .plots import Axes, angle_ticks

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


# Labels over a path that grows: they keep off it, and stay where they are as long as it keeps off them.

NOW = 5.8  # px, radius of the big dot
STAYS = 100  # motions for which labels that nothing covers stay; what a path takes of the plot grows with each
CLEAR = 3.0  # px on both sides of the path that labels leave free
APART = 20.0  # px from the start to the learner, from which on each has a label
AHEAD = 4.0  # px around the big dot that labels leave free for the next motions when they are placed


class End(NamedTuple):
    """Of a path: how many moments there are, the one that is shown, and the learner's posture there, (m,) rad."""

    moments: int
    cursor: int
    theta: NDArray

    def same(self, other: "End") -> bool:
        return self[:2] == other[:2] and self.theta is other.theta


@dataclass
class Placed:
    """since: the motion for which all were placed; end: of the path; line: what the path, the marks and the big dot,
    wherever it has been since, take; labels: all but the learner's own, the start's first; own: that one as it is
    drawn; away: whether the learner is where both have room."""

    since: int
    end: End
    line: Labels
    labels: list[Put]
    own: str
    away: bool

    @cached_property
    def free(self) -> Labels:
        """With the line and the labels taken. Mostly the next motion covers one before it is asked for."""
        free = self.line.copy()
        for label in self.labels:
            free.take(*label.takes)
        return free

    @cached_property
    def places(self) -> Labels:
        """Where the labels stand, without what leads to them."""
        places = Labels(*self.line.bounds)
        places.take(*[label.place for label in self.labels if label.place is not None])
        return places

    @cached_property
    def words(self) -> str:
        """The drawings of these labels."""
        return "".join([label.drawn for label in self.labels])

    def take(self, rectangles: Sequence[Rectangle]) -> None:
        """By the line."""
        self.line.take(*rectangles)
        if "free" in vars(self):
            self.free.take(*rectangles)


class PathLabels:
    """In a plane. labels: of marks and contours, where there is room."""

    def __init__(self, plane: PosturePlane, labels: Sequence[Label]):
        self._plane, self._labels = plane, labels
        self._placed: Placed | None = None

    def words(self, history: Sequence[Snapshot], cursor: int, theta: NDArray | None, points: NDArray) -> str:
        """All labels; those but the learner's own stay while the arm is on its way. theta: (m,) rad, where it is seen
        then; points: (k, 2) px of the path as it is drawn."""
        placed = self._placed
        if placed is None or not placed.end.same(_end(history, cursor)):
            placed = self._placed = self._follow(history, cursor, points)
        return placed.words + (placed.own if theta is None else self._own(placed.free, theta, cursor)[0])

    def _follow(self, history: Sequence[Snapshot], cursor: int, points: NDArray) -> Placed:
        """Go on with more motions, or with another path."""
        placed, new = self._placed, self._since(history, cursor)
        if placed is None or new is None or cursor - placed.since > STAYS:
            return self._place(history, cursor, points)
        return self._gone_on(placed, history, cursor, new)

    def _since(self, history: Sequence[Snapshot], cursor: int) -> list[Rectangle] | None:
        """What the motions since labels were drawn last take; None if the path is another one."""
        if self._placed is None:
            return None
        count, before, theta = self._placed.end
        if not len(history) - 1 == cursor > before == count - 1 or history[before].theta is not theta:
            return None
        since = history[before : cursor + 1]
        return line_taken(self._plane.place(np.degrees([moment.theta for moment in since])), CLEAR)

    def _place(self, history: Sequence[Snapshot], cursor: int, points: NDArray) -> Placed:
        """All labels, off the path. points: (k, 2) px of it as it is drawn."""
        line, (x, y) = self._plane.labels.copy(), points[0].tolist()
        line.take_line(points, CLEAR)
        line.take_points(self._plane.place(np.degrees(history[cursor].theta)), NOW + AHEAD)
        labels = beside(x, y, "start", "vi-2nd vi-halo", 8), *self._labels
        return self._put([Put(label) for label in labels], line, history, cursor, cursor)

    def _put(self, labels: Sequence[Put], line: Labels, history: Sequence[Snapshot], cursor: int, since: int) -> Placed:
        """The learner's own label, and those that stand nowhere; that of the start only while the learner is away."""
        theta, away, free = history[cursor].theta, self._away(history, cursor), line.copy()
        for label in labels:
            free.take(*label.takes)
        own, place = self._own(free, theta, cursor)
        if place is not None:
            free.take(place)
        put = [
            free.put(label.label) if label.place is None and (k or away) else label for k, label in enumerate(labels)
        ]
        return Placed(since, _end(history, cursor), line, put, own, away)

    def _away(self, history: Sequence[Snapshot], cursor: int) -> bool:
        """Whether the learner's own label is not the start's."""
        start, now = self._plane.place(np.degrees([history[0].theta, history[cursor].theta]))
        return cursor > 0 and bool(np.abs(now - start).max() > APART)

    def _gone_on(self, placed: Placed, history: Sequence[Snapshot], cursor: int, new: list[Rectangle]) -> Placed:
        """While more motions keep off the labels, these stay: they do not jump, and need not be placed; only those that
        are met make room. new: what these motions take."""
        theta, away = history[cursor].theta, self._away(history, cursor)
        x, y = self._plane.place(np.degrees(theta)).tolist()
        new = [*new, (x - NOW, y - NOW, x + NOW, y + NOW)]
        placed.take(new)
        met = [one for one in new if placed.places.covers(one)]
        placed.own = "" if met else self._own(placed.free, theta, cursor)[0]
        if met:
            gone = [_meet(label.takes[:1], met) for label in placed.labels]
        elif not placed.own:  # where it has room once others make some
            place = self._own(placed.line, theta, cursor)[1]
            gone = [place is not None and _meet(label.takes, [place]) for label in placed.labels]
        else:
            gone = [False] * len(placed.labels)
        if any(gone) or away != placed.away:
            gone[0] |= not away
            labels = [Put(label.label) if goes else label for label, goes in zip(placed.labels, gone)]
            return self._put(labels, placed.line, history, cursor, placed.since)
        placed.end = _end(history, cursor)
        return placed

    def _own(self, labels: Labels, theta: NDArray, cursor: int) -> tuple[str, Rectangle | None]:
        """The learner's own label at theta, (m,) rad, and its place, which is not taken."""
        x, y = self._plane.place(np.degrees(theta)).tolist()
        words = f"{'now' if cursor else 'start'} ({svg.degrees(theta[0])}, {svg.degrees(theta[1])})"
        place = labels.first_free(places_beside(x, y, labels.letter * len(words), 11))
        return ("" if place is None else text_at(place, words, "vi-of-own vi-halo")), place


def _end(history: Sequence[Snapshot], cursor: int) -> End:
    return End(len(history), cursor, history[cursor].theta)


def _meet(some: Sequence[Rectangle], others: Sequence[Rectangle]) -> bool:
    return any(meet(one, other) for one in some for other in others)
