"""Places for labels in a plot, so that none covers another, a mark or a line. What finds no room is left out."""

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import svg

CHARACTER, LINE = 6.1, 13  # px of a letter of 11 px, of a line
OUT, UP = 30, 24  # px from a mark to the end of its leader
BESIDE = np.array(
    [(0, 1), (0, -1), (1, 0), (-1, 0), (0.5, 1), (-0.5, 1), (0.5, -1), (-0.5, -1), (0, 2), (0, -2), (0.7, 2), (-0.7, 2)]
)
OUTS, UPS = (1.0, 2.0, 0.3, 3.0, 4.0), (-1, 1, -2, 2, 0, -3, 3)  # of OUT, of UP, the better ones first
AT_ONCE = 8  # places that are tried together
STRIDE = 5.0  # px between the points of a line that are kept free


class Labels:
    """Rectangles (left, top, right, bottom) px that are taken, within bounds. letter: px of one; placed: (4,) px each,
    where labels stand."""

    def __init__(self, left: float, top: float, right: float, bottom: float):
        self.bounds, self.letter = (left, top, right, bottom), CHARACTER
        self._taken = np.empty((0, 4))
        self.placed: list[NDArray] = []

    def copy(self) -> "Labels":
        other = Labels(*self.bounds)
        other._taken, other.letter, other.placed = self._taken, self.letter, self.placed.copy()
        return other

    def take(self, rectangles: ArrayLike) -> None:
        """(4,) or (k, 4) px"""
        self._taken = np.concatenate([self._taken, np.reshape(rectangles, (-1, 4))])

    def take_points(self, places: NDArray, radius: float) -> None:
        """places: (2,) or (k, 2) px"""
        self.take(np.concatenate([places - radius, places + radius], -1))

    def take_line(self, points: NDArray, radius: float) -> None:
        """points: (k, 2) px"""
        length = np.append(0, np.cumsum(np.hypot(*np.diff(points, axis=0).T)))
        along = np.linspace(0, length[-1], int(length[-1] / STRIDE) + 1)
        self.take_points(np.stack([np.interp(along, length, x) for x in points.T], -1), radius)

    def since(self, before: "Labels") -> NDArray:
        """(k, 4) px, what has been taken since this was a copy of `before`."""
        return self._taken[len(before._taken) :]

    def covers(self, places: NDArray) -> NDArray:
        """(k,) bool: which of (k, 4) px meet what is taken."""
        left, top, right, bottom = (side[:, None] for side in places.T)
        a, b, c, d = self._taken.T
        return ((left < c) & (a < right) & (top < d) & (b < bottom)).any(1)

    def take_first_free(self, places: NDArray) -> NDArray | None:
        """The first of (k, 4) px that covers nothing and is within bounds."""
        left, top, right, bottom = self.bounds
        a, b, c, d = places.T
        places = places[(a >= left) & (b >= top) & (c <= right) & (d <= bottom)]
        for k in range(0, len(places), AT_ONCE):  # the better places come first, and mostly one of the first is free
            free = np.flatnonzero(~self.covers(places[k : k + AT_ONCE]))
            if len(free):
                self.take(places[k + free[0]])
                self.placed.append(places[k + free[0]])
                return self.placed[-1]
        return None

    def beside(self, x: float, y: float, words: str, classes: str, distance: float) -> str:
        """A label next to a mark, on the first side with room."""
        size = np.array([self.letter * len(words), LINE])
        middle = np.array([x, y]) + BESIDE * (distance + size / 2)
        place = self.take_first_free(np.concatenate([middle - size / 2, middle + size / 2], 1))
        return "" if place is None else _text(place, words, classes)

    def led(self, x: float, y: float, words: str, kind: str, to_left: bool) -> str:
        """A label with a line of class `kind` that leads from the mark to it."""
        place = self.take_first_free(_led_places(x, y, self.letter * len(words), to_left))
        if place is None:
            return ""
        left, top, right, _ = place.tolist()
        end_x, end_y = (right + 3 if right < x else left - 3), top + LINE / 2
        share = 7 / max(((end_x - x) ** 2 + (end_y - y) ** 2) ** 0.5, 7.0)
        from_x, from_y = x + share * (end_x - x), y + share * (end_y - y)
        self.take_line(np.array([[from_x, from_y], [end_x, end_y]]), 1)
        leader = f'<path class="{kind}" d="M{from_x:.1f} {from_y:.1f}L{end_x:.1f} {end_y:.1f}"/>'
        return leader + _text(place, words, "vi-halo")


@lru_cache(64)  # marks stay where they are while a path grows
def _led_places(x: float, y: float, w: float, to_left: bool) -> NDArray:
    """(k, 4) px around a mark, the better ones first. w: px of the words."""
    places = []
    for out in OUTS:
        for side in (-1, 1) if to_left else (1, -1):
            for up in UPS:
                left, middle = x - out * OUT - w if side < 0 else x + out * OUT, y + up * UP
                places.append((left, middle - LINE / 2, left + w, middle + LINE / 2))
    return np.array(places)


def _text(place: NDArray, words: str, classes: str) -> str:
    left, top, right, _ = place.tolist()
    return svg.text((left + right) / 2, top + 10, words, f"{classes} vi-mid")
