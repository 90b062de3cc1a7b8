"""Labels over a path that grows: they keep off it, and stay where they are as long as it keeps off them."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..loop.snapshot import Snapshot
from . import svg
from .labels import Label, Labels, Put, Rectangle, beside, line_taken, meet, places_beside, text_at
from .posture_plane import PosturePlane

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
