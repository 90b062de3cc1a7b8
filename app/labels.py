"""Places for labels in a plot, so that none covers another or a mark."""

import numpy as np

from . import svg

CHARACTER, LINE = 6.1, 13  # px of a letter of 11 px, of a line
AROUND = ((0, 1), (0, -1), (1, 0), (-1, 0), (0.5, 1), (-0.5, 1), (0.5, -1), (-0.5, -1), (0, 2), (0, -2), (0.7, 2), (-0.7, 2))
OUT, UP = 30, 24  # px from a mark to the end of its leader


class Labels:
    """Rectangles (left, top, right, bottom) px that are taken, within bounds."""

    def __init__(self, left: float, top: float, right: float, bottom: float):
        self.bounds = left, top, right, bottom
        self._taken: list[tuple[float, float, float, float]] = []

    def copy(self) -> "Labels":
        other = Labels(*self.bounds)
        other._taken = list(self._taken)
        return other

    def take(self, left: float, top: float, right: float, bottom: float) -> None:
        self._taken.append((left, top, right, bottom))

    def take_point(self, x: float, y: float, radius: float) -> None:
        self.take(x - radius, y - radius, x + radius, y + radius)

    def overlap(self, left: float, top: float, right: float, bottom: float) -> float:
        """px² over what is taken or out of bounds."""
        total = 0.0
        for a, b, c, d in self._taken:
            w, h = min(right, c) - max(left, a), min(bottom, d) - max(top, b)
            if w > 0 and h > 0:
                total += w * h
        a, b, c, d = self.bounds
        out = max(a - left, 0) + max(right - c, 0) + max(b - top, 0) + max(bottom - d, 0)
        return total + 40 * out

    def beside(self, x: float, y: float, words: str, classes: str, distance: float) -> str:
        """A label next to a mark, on the side with the most room."""
        w = CHARACTER * len(words)
        places = []
        for dx, dy in AROUND:
            centre_x = x + dx * (distance + w / 2)
            centre_y = y + dy * (distance + LINE / 2)
            places.append((centre_x - w / 2, centre_y - LINE / 2, centre_x + w / 2, centre_y + LINE / 2))
        return self._put(places, words, classes)[0]

    def led(self, x: float, y: float, words: str, kind: str, to_left: bool) -> str:
        """A label with a line that leads from the mark to it."""
        w = CHARACTER * len(words)
        places = []
        for out in (OUT, 2 * OUT, 0.3 * OUT):
            for side in (-1, 1) if to_left else (1, -1):
                for up in (-UP, UP, -2 * UP, 2 * UP):
                    near = x + side * out
                    left = near - w if side < 0 else near
                    places.append((left, y + up - LINE / 2, left + w, y + up + LINE / 2))
        label, (left, top, right, _) = self._put(places, words, "vi-halo")
        end_x = right + 3 if right < x else left - 3 if left > x else x
        end_y = top + LINE / 2
        reach = max(np.hypot(end_x - x, end_y - y), 1e-9)
        from_x, from_y = x + 7 * (end_x - x) / reach, y + 7 * (end_y - y) / reach
        return f'<path class="{kind}" d="M{from_x:.1f} {from_y:.1f}L{end_x:.1f} {end_y:.1f}"/>{label}'

    def _put(self, places: list[tuple], words: str, classes: str) -> tuple[str, tuple]:
        """In the first free place, or the one that covers least."""
        best, least = places[0], np.inf
        for place in places:
            overlap = self.overlap(*place)
            if overlap < least:
                best, least = place, overlap
            if overlap == 0:
                break
        self.take(*best)
        left, top, right, _ = best
        return svg.text((left + right) / 2, top + 10, words, f"{classes} vi-mid"), best
