"""Places for labels in a plot, so that none covers another, a mark or a line. What finds no room is left out."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import lru_cache
from itertools import pairwise
from math import hypot
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import svg

CHARACTER, LINE = 6.1, 13  # px of a letter of 11 px, of a line
OUT, UP = 30, 24  # px from a mark to the end of its leader
BESIDE = (  # of a label's size, from a mark to its middle
    (0, 1), (0, -1), (1, 0), (-1, 0), (0.5, 1), (-0.5, 1), (0.5, -1), (-0.5, -1), (0, 2), (0, -2), (0.7, 2), (-0.7, 2),
)  # fmt: skip
OUTS, UPS = (1.0, 2.0, 0.3, 3.0, 4.0), (-1, 1, -2, 2, 0, -3, 3)  # of OUT, of UP, the better ones first
STRIDE = 5.0  # px between the points of a line that are kept free
STRIP = 16.0  # px: what a label meets is looked for in strips of that height

Rectangle = Sequence[float]  # left, top, right, bottom: px


class Label(NamedTuple):
    """What looks for room. places: for its words, the better ones first; draw(place): it there, and what it takes
    besides."""

    places: Sequence[Rectangle]
    draw: Callable[[Rectangle], tuple[str, Sequence[Rectangle]]]


class Put(NamedTuple):
    """A label where it stands, None if there was no room; as it is drawn, with all that it takes, its place first."""

    label: Label
    place: Rectangle | None = None
    drawn: str = ""
    takes: Sequence[Rectangle] = ()


class Labels:
    """Rectangles that are taken, within bounds. letter: px of one."""

    def __init__(self, left: float, top: float, right: float, bottom: float):
        self.bounds, self.letter = (left, top, right, bottom), CHARACTER
        self._first = int(top // STRIP)
        self._strips: list[list[Rectangle]] = [[] for _ in range(self._first, int(bottom // STRIP) + 1)]

    def copy(self) -> "Labels":
        other = Labels(*self.bounds)
        other.letter = self.letter
        other._strips = [there.copy() for there in self._strips]
        return other

    def take(self, *rectangles: Rectangle) -> None:
        for rectangle in rectangles:
            for there in self._met(rectangle[1], rectangle[3]):
                there.append(rectangle)

    def take_points(self, places: NDArray, radius: float) -> None:
        """places: (2,) or (k, 2) px"""
        self.take(*_around(places.reshape(-1, 2).tolist(), radius))

    def take_line(self, points: NDArray, radius: float) -> None:
        """points: (k, 2) px"""
        self.take(*line_taken(points, radius))

    def covers(self, place: Rectangle) -> bool:
        """Whether it meets what is taken; within bounds."""
        left, top, right, bottom = place
        for there in self._met(top, bottom):
            for a, b, c, d in there:
                if left < c and a < right and top < d and b < bottom:
                    return True
        return False

    def first_free(self, places: Iterable[Rectangle]) -> Rectangle | None:
        """The first that covers nothing and is within bounds."""
        left, top, right, bottom = self.bounds
        for place in places:
            a, b, c, d = place
            if a >= left and b >= top and c <= right and d <= bottom and not self.covers(place):
                return place
        return None

    def put(self, label: Label) -> Put:
        """Take the first of its places that is free."""
        place = self.first_free(label.places)
        if place is None:
            return Put(label)
        drawn, besides = label.draw(place)
        takes = (place, *besides)
        self.take(*takes)
        return Put(label, place, drawn, takes)

    def draw(self, labels: Iterable[Label]) -> str:
        """Those for which there is room, the first of them first."""
        return "".join([self.put(label).drawn for label in labels])

    def beside(self, x: float, y: float, words: str, classes: str, distance: float) -> str:
        """A label next to a mark, on the first side with room."""
        return self.put(beside(x, y, words, classes, distance, self.letter)).drawn

    def led(self, x: float, y: float, words: str, kind: str, to_left: bool) -> str:
        """A label with a line of class `kind` that leads from the mark to it."""
        return self.put(led(x, y, words, kind, to_left, self.letter)).drawn

    def _met(self, top: float, bottom: float) -> list[list[Rectangle]]:
        """Strips between two heights, px; of what lies beyond the bounds the outermost one."""
        first = int(top // STRIP) - self._first
        last = int(bottom // STRIP) - self._first + 1
        return self._strips[first if first > 0 else 0 : last if last > 1 else 1] or self._strips[-1:]


def beside(x: float, y: float, words: str, classes: str, distance: float, letter: float = CHARACTER) -> Label:
    """Next to a mark, around which its places are. letter: px of one."""
    places = list(places_beside(x, y, letter * len(words), distance))
    return Label(places, lambda place: (text_at(place, words, classes), ()))


def led(x: float, y: float, words: str, kind: str, to_left: bool, letter: float = CHARACTER) -> Label:
    """With a line of class `kind` that leads to it from the mark."""

    def draw(place: Rectangle) -> tuple[str, Sequence[Rectangle]]:
        left, top, right, _ = place
        end_x, end_y = (right + 3 if right < x else left - 3), top + LINE / 2
        share = 7 / max(((end_x - x) ** 2 + (end_y - y) ** 2) ** 0.5, 7.0)
        from_x, from_y = x + share * (end_x - x), y + share * (end_y - y)
        leader = f'<path class="{kind}" d="M{from_x:.1f} {from_y:.1f}L{end_x:.1f} {end_y:.1f}"/>'
        taken = line_taken(np.array([[from_x, from_y], [end_x, end_y]]), 1)
        return leader + text_at(place, words, "vi-halo"), taken

    return Label(_led_places(x, y, letter * len(words), to_left), draw)


def line_taken(points: NDArray, radius: float) -> list[Rectangle]:
    """What a line through these, (k, 2) px, takes."""
    return _around(_along(points.tolist()), radius)


def meet(one: Rectangle, other: Rectangle) -> bool:
    left, top, right, bottom = one
    a, b, c, d = other
    return left < c and a < right and top < d and b < bottom


def _around(places: Iterable[Sequence[float]], radius: float) -> list[Rectangle]:
    """places: x, y px each"""
    return [(x - radius, y - radius, x + radius, y + radius) for x, y in places]


def _along(points: list[list[float]]) -> Iterator[tuple[float, float]]:
    """Places on a line through these, all px, the first and the last among them, STRIDE apart or a little more."""
    lengths = [hypot(x - a, y - b) for (a, b), (x, y) in pairwise(points)]
    whole = sum(lengths)
    count = int(whole / STRIDE)
    stride, at = whole / max(count, 1), 0.0  # of the next place, px from the beginning of its piece
    left = count + 1
    for length, ((a, b), (x, y)) in zip(lengths, pairwise(points)):
        while left > 1 and at < length:
            yield a + at / length * (x - a), b + at / length * (y - b)
            at, left = at + stride, left - 1
        at -= length
    x, y = points[-1 if count else 0]
    yield x, y


def places_beside(x: float, y: float, w: float, distance: float) -> Iterator[Rectangle]:
    """Around a mark, the better ones first. w: px of the words."""
    for across, down in BESIDE:
        left, top = x + across * (distance + w / 2) - w / 2, y + down * (distance + LINE / 2) - LINE / 2
        yield left, top, left + w, top + LINE


@lru_cache(64)  # marks stay where they are while a path grows
def _led_places(x: float, y: float, w: float, to_left: bool) -> list[Rectangle]:
    """Around a mark, the better ones first. w: px of the words."""
    places: list[Rectangle] = []
    for out in OUTS:
        for side in (-1, 1) if to_left else (1, -1):
            for up in UPS:
                left, middle = x - out * OUT - w if side < 0 else x + out * OUT, y + up * UP
                places.append((left, middle - LINE / 2, left + w, middle + LINE / 2))
    return places


def text_at(place: Rectangle, words: str, classes: str) -> str:
    left, top, right, _ = place
    return svg.text((left + right) / 2, top + 10, words, f"{classes} vi-mid")
