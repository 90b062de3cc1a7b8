"""Placement of labels in a plot: none covers another, a mark or a line. A label without a free place is left out."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import lru_cache
from itertools import pairwise
from math import hypot
from typing import NamedTuple

import numpy as np

from ..geometry.arrays import Floats
from . import svg

CHARACTER, LINE = 6.1, 13  # px: width of a letter of 11 px at most, height of a line
OUT, UP = 30, 24  # px from a mark to the end of its leader
BESIDE = (  # from a mark to the middle of a label, in units of its size; the best first
    (0, 1), (0, -1), (1, 0), (-1, 0), (0.5, 1), (-0.5, 1), (0.5, -1), (-0.5, -1), (0, 2), (0, -2), (0.7, 2), (-0.7, 2),
)  # fmt: skip
OUTS, UPS = (1.0, 2.0, 0.3, 3.0, 4.0), (-1, 1, -2, 2, 0, -3, 3)  # in units of OUT and UP; the best first
STRIDE = 5.0  # px between the occupied squares along a line
STRIP = 16.0  # px, height of the strips in which rectangles are indexed

Rectangle = Sequence[float]  # left, top, right, bottom: px


class Label(NamedTuple):
    """A label that can be placed."""

    places: Sequence[Rectangle]  # for its words, the best first
    draw: Callable[[Rectangle], tuple[str, Sequence[Rectangle]]]  # place → drawing, and what else it occupies


class PlacedLabel(NamedTuple):
    """A label with its place."""

    label: Label
    place: Rectangle | None = None  # None without a free place
    drawn: str = ""
    occupies: Sequence[Rectangle] = ()  # its place first


class Labels:
    """Occupied rectangles within bounds, px."""

    def __init__(self, left: float, top: float, right: float, bottom: float):
        self.bounds = left, top, right, bottom
        self._first = int(top // STRIP)
        self._strips: list[list[Rectangle]] = [[] for _ in range(self._first, int(bottom // STRIP) + 1)]

    def copy(self) -> "Labels":
        """Return a copy with the same occupied rectangles."""
        other = Labels(*self.bounds)
        other._strips = [there.copy() for there in self._strips]
        return other

    def take(self, *rectangles: Rectangle) -> None:
        """Occupy rectangles."""
        for rectangle in rectangles:
            for there in self._met(rectangle[1], rectangle[3]):
                there.append(rectangle)

    def take_points(self, places: Floats, radius: float) -> None:
        """Occupy squares around points, (2,) or (k, 2) px."""
        self.take(*_around(places.reshape(-1, 2).tolist(), radius))

    def covers(self, place: Rectangle) -> bool:
        """Say whether a rectangle within bounds overlaps an occupied one."""
        left, top, right, bottom = place
        for there in self._met(top, bottom):
            for a, b, c, d in there:
                if left < c and a < right and top < d and b < bottom:
                    return True
        return False

    def first_free(self, places: Iterable[Rectangle]) -> Rectangle | None:
        """Return the first place that is within bounds and free."""
        left, top, right, bottom = self.bounds
        for place in places:
            a, b, c, d = place
            if a >= left and b >= top and c <= right and d <= bottom and not self.covers(place):
                return place
        return None

    def put(self, label: Label) -> PlacedLabel:
        """Place a label at the first of its places that is free."""
        place = self.first_free(label.places)
        if place is None:
            return PlacedLabel(label)
        drawn, others = label.draw(place)
        occupies = (place, *others)
        self.take(*occupies)
        return PlacedLabel(label, place, drawn, occupies)

    def draw(self, labels: Iterable[Label]) -> str:
        """Place and draw labels in their order, without those that find no place."""
        return "".join([self.put(label).drawn for label in labels])

    def beside(self, x: float, y: float, words: str, classes: str, distance: float) -> str:
        """Draw a label next to a mark at (x, y) px."""
        return self.put(beside(x, y, words, classes, distance)).drawn

    def _met(self, top: float, bottom: float) -> list[list[Rectangle]]:
        """Return the strips between two heights, px; beyond the bounds the outermost one."""
        first = int(top // STRIP) - self._first
        last = int(bottom // STRIP) - self._first + 1
        return self._strips[first if first > 0 else 0 : last if last > 1 else 1] or self._strips[-1:]


def beside(x: float, y: float, words: str, classes: str, distance: float) -> Label:
    """Make a label with places around a mark."""
    places = list(places_beside(x, y, CHARACTER * len(words), distance))
    return Label(places, lambda place: (text_at(place, words, classes), ()))


def led(x: float, y: float, words: str, kind: str, to_left: bool) -> Label:
    """Make a label with a leader of class `kind` from the mark."""

    def draw(place: Rectangle) -> tuple[str, Sequence[Rectangle]]:
        left, top, right, _ = place
        end_x, end_y = (right + 3 if right < x else left - 3), top + LINE / 2
        share = 7 / max(((end_x - x) ** 2 + (end_y - y) ** 2) ** 0.5, 7.0)
        from_x, from_y = x + share * (end_x - x), y + share * (end_y - y)
        leader = f'<path class="{kind}" d="M{from_x:.1f} {from_y:.1f}L{end_x:.1f} {end_y:.1f}"/>'
        taken = line_rectangles(np.array([[from_x, from_y], [end_x, end_y]]), 1)
        return leader + text_at(place, words, "vi-halo"), taken

    return Label(_led_places(x, y, CHARACTER * len(words), to_left), draw)


def line_rectangles(points: Floats, radius: float) -> list[Rectangle]:
    """Return squares of half-width `radius` along a line through points, (k, 2) px."""
    return _around(_along(points.tolist()), radius)


def _around(places: Iterable[Sequence[float]], radius: float) -> list[Rectangle]:
    return [(x - radius, y - radius, x + radius, y + radius) for x, y in places]


def _along(points: list[list[float]]) -> Iterator[tuple[float, float]]:
    """Yield points STRIDE px or a little more from each other on a line, with its first and last point."""
    lengths = [hypot(x - a, y - b) for (a, b), (x, y) in pairwise(points)]
    total = sum(lengths)
    count = int(total / STRIDE)
    stride, at = total / max(count, 1), 0.0  # at: of the next point, px from the start of its segment
    left = count + 1
    for length, ((a, b), (x, y)) in zip(lengths, pairwise(points)):
        while left > 1 and at < length:
            yield a + at / length * (x - a), b + at / length * (y - b)
            at, left = at + stride, left - 1
        at -= length
    x, y = points[-1 if count else 0]
    yield x, y


def places_beside(x: float, y: float, w: float, distance: float) -> Iterator[Rectangle]:
    """Yield the places of a label around a mark, the best first. w: width of the words, px."""
    for across, down in BESIDE:
        left, top = x + across * (distance + w / 2) - w / 2, y + down * (distance + LINE / 2) - LINE / 2
        yield left, top, left + w, top + LINE


@lru_cache(64)  # marks stay while a path grows
def _led_places(x: float, y: float, w: float, to_left: bool) -> list[Rectangle]:
    """List the places of a label with a leader, the best first. w: width of the words, px."""
    places: list[Rectangle] = []
    for out in OUTS:
        for side in (-1, 1) if to_left else (1, -1):
            for up in UPS:
                left, middle = x - out * OUT - w if side < 0 else x + out * OUT, y + up * UP
                places.append((left, middle - LINE / 2, left + w, middle + LINE / 2))
    return places


def text_at(place: Rectangle, words: str, classes: str) -> str:
    """Draw words centred in their place."""
    left, top, right, _ = place
    return svg.text((left + right) / 2, top + 10, words, f"{classes} vi-mid")
