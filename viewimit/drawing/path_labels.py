"""Labels over a path that grows: they keep off it, and stay where they are as long as it keeps off them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..snapshot import Snapshot
from . import svg
from .labels import Labels, Rectangle, line_taken, text_at
from .posture_plane import PosturePlane

NOW = 5.8  # px, radius of the big dot
STAYS = 100  # motions for which labels that nothing covers stay; what a path takes of the plot grows with each
CLEAR = 3.0  # px on both sides of the path that labels leave free
AHEAD = 4.0  # px around the big dot that labels leave free for the next motions when they are placed


@dataclass
class Placed:
    """since: the motion for which they were placed; about: the path's moments and its cursor; present: the last of it;
    line: what the path, the marks and the big dot, wherever it has been since, take; labels: what the labels but the
    learner's own take, with their leaders; others: where these labels stand; own, words: the drawings of both."""

    since: int
    about: tuple[int, int]
    present: Snapshot
    line: Labels
    labels: list[Rectangle]
    others: Labels
    own: str
    words: str

    @cached_property
    def free(self) -> Labels:
        """With the line and these labels taken. Mostly the next motion covers one before it is asked for."""
        free = self.line.copy()
        free.take(*self.labels)
        return free

    def take(self, rectangles: Sequence[Rectangle]) -> None:
        """By the line."""
        self.line.take(*rectangles)
        if "free" in vars(self):
            self.free.take(*rectangles)


class PathLabels:
    """In a plane. draw(labels): those of marks and contours, where there is room."""

    def __init__(self, plane: PosturePlane, draw: Callable[[Labels], str]):
        self._plane, self._draw = plane, draw
        self._placed: Placed | None = None
        self._path = plane.labels  # what the path and the marks take
        self._begun = 0  # the motion until which that was made of the path as it is drawn

    def words(self, history: Sequence[Snapshot], cursor: int, theta: NDArray | None, points: NDArray) -> str:
        """All labels; those but the learner's own stay while the arm is on its way. theta: (m,) rad, where it is seen
        then; points: (k, 2) px of the path as it is drawn."""
        placed = self._placed
        if placed is None or (placed.about, placed.present) != ((len(history), cursor), history[cursor]):
            placed = self._placed = self._follow(history, cursor, points)
        return placed.words + (placed.own if theta is None else self._own(placed.free, theta, cursor)[0])

    def _follow(self, history: Sequence[Snapshot], cursor: int, points: NDArray) -> Placed:
        """Go on with more motions, or with another path."""
        placed, new = self._placed, self._since(history, cursor)
        if new is None or cursor - self._begun > STAYS:
            self._path, self._begun = self._plane.labels.copy(), cursor
            self._path.take_line(points, CLEAR)
        else:
            self._path.take(*new)
        if placed is not None and new is not None and self._gone_on(placed, history, cursor, new):
            return placed
        return self._place(history, cursor, points[0])

    def _since(self, history: Sequence[Snapshot], cursor: int) -> list[Rectangle] | None:
        """What the motions since labels were drawn last take; None if the path is another one."""
        placed = self._placed
        if placed is None or not len(history) - 1 == cursor > placed.about[1] == placed.about[0] - 1:
            return None
        since = history[placed.about[1] : cursor + 1]
        if since[0] is not placed.present:
            return None
        return line_taken(self._plane.place(np.degrees([moment.theta for moment in since])), CLEAR)

    def _place(self, history: Sequence[Snapshot], cursor: int, start: NDArray) -> Placed:
        """All labels, off the path. start: (2,) px of it."""
        present = history[cursor]
        line, others = self._path.copy(), Labels(*self._path.bounds)
        now = self._plane.place(np.degrees(present.theta))
        line.take_points(now, NOW + AHEAD)
        labels, words = line.copy(), ""
        own, place = self._own(labels, present.theta, cursor)
        if place is not None:
            labels.take(place)
        if cursor and np.abs(now - start).max() > 20:
            words = labels.beside(float(start[0]), float(start[1]), "start", "vi-2nd vi-halo", 8)
        words += self._draw(labels)
        others.take(*labels.placed)
        taken = labels.since(line)[place is not None :]
        return Placed(cursor, (len(history), cursor), present, line, taken, others, own, words)

    def _gone_on(self, placed: Placed, history: Sequence[Snapshot], cursor: int, new: list[Rectangle]) -> bool:
        """While more motions keep off the labels, these stay: they do not jump, and need not be placed. new: what these
        motions take."""
        if cursor - placed.since > STAYS:
            return False
        present = history[cursor]
        x, y = self._plane.place(np.degrees(present.theta)).tolist()
        new = [*new, (x - NOW, y - NOW, x + NOW, y + NOW)]
        if any(map(placed.others.covers, new)):
            return False
        placed.take(new)
        placed.own = self._own(placed.free, present.theta, cursor)[0]
        if not placed.own and self._own(placed.line, present.theta, cursor)[0]:
            return False  # it would have room if the others stood elsewhere
        placed.about, placed.present = (len(history), cursor), present
        return True

    def _own(self, labels: Labels, theta: NDArray, cursor: int) -> tuple[str, Rectangle | None]:
        """The learner's own label at theta, (m,) rad, and its place, which is not taken."""
        x, y = self._plane.place(np.degrees(theta)).tolist()
        words = f"{'now' if cursor else 'start'} ({svg.degrees(theta[0])}, {svg.degrees(theta[1])})"
        place = labels.free_beside(x, y, words, 11)
        return ("" if place is None else text_at(place, words, "vi-of-own vi-halo")), place
