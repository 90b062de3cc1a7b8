"""Places for labels in a plot, so that none covers another or a mark."""

from numpy.typing import NDArray

from . import svg

CHARACTER, LINE = 6.1, 13  # px of a letter of 11 px, of a line
OUT, UP = 30, 24  # px from a mark to the end of its leader
BESIDE = (
    (0, 1), (0, -1), (1, 0), (-1, 0), (0.5, 1), (-0.5, 1), (0.5, -1), (-0.5, -1), (0, 2), (0, -2), (0.7, 2), (-0.7, 2),
)  # fmt: skip
BEYOND = 40  # px² that a px out of bounds counts for

Rectangle = tuple[float, float, float, float]  # left, top, right, bottom, px


class Labels:
    """Rectangles that are taken, within bounds."""

    def __init__(self, left: float, top: float, right: float, bottom: float):
        self.bounds: Rectangle = left, top, right, bottom
        self._taken: list[Rectangle] = []

    def copy(self) -> "Labels":
        other = Labels(*self.bounds)
        other._taken = list(self._taken)
        return other

    def take(self, left: float, top: float, right: float, bottom: float) -> Rectangle:
        rectangle = float(left), float(top), float(right), float(bottom)
        self._taken.append(rectangle)
        return rectangle

    def take_point(self, place: NDArray, radius: float) -> Rectangle:
        """place: (2,) px"""
        x, y = place.tolist()
        return self.take(x - radius, y - radius, x + radius, y + radius)

    def release(self, rectangles: list[Rectangle]) -> None:
        self._taken = [rectangle for rectangle in self._taken if rectangle not in rectangles]

    def overlap(self, left: float, top: float, right: float, bottom: float) -> float:
        """px² over what is taken or out of bounds."""
        a, b, c, d = self.bounds
        total = BEYOND * (max(a - left, 0.0) + max(right - c, 0.0) + max(b - top, 0.0) + max(bottom - d, 0.0))
        for a, b, c, d in self._taken:
            if left < c and a < right and top < d and b < bottom:
                total += (min(right, c) - max(left, a)) * (min(bottom, d) - max(top, b))
        return total

    def beside(self, x: float, y: float, words: str, classes: str, distance: float) -> str:
        """A label next to a mark, on the first side with room."""
        w = CHARACTER * len(words)
        places = []
        for dx, dy in BESIDE:
            left, top = x + dx * (distance + w / 2) - w / 2, y + dy * (distance + LINE / 2) - LINE / 2
            places.append((left, top, left + w, top + LINE))
        return self._put(places, words, classes)[0]

    def led(self, x: float, y: float, words: str, kind: str, to_left: bool) -> str:
        """A label with a line of class `kind` that leads from the mark to it."""
        w = CHARACTER * len(words)
        places = []
        for out in (OUT, 2 * OUT, 0.3 * OUT):
            for side in (-1, 1) if to_left else (1, -1):
                for up in (-UP, UP, -2 * UP, 2 * UP):
                    left = x - out - w if side < 0 else x + out
                    places.append((left, y + up - LINE / 2, left + w, y + up + LINE / 2))
        label, (left, top, right, _) = self._put(places, words, "vi-halo")
        end_x, end_y = (right + 3 if right < x else left - 3), top + LINE / 2
        share = 7 / max(((end_x - x) ** 2 + (end_y - y) ** 2) ** 0.5, 7.0)
        from_x, from_y = x + share * (end_x - x), y + share * (end_y - y)
        return f'<path class="{kind}" d="M{from_x:.1f} {from_y:.1f}L{end_x:.1f} {end_y:.1f}"/>{label}'

    def _put(self, places: list[Rectangle], words: str, classes: str) -> tuple[str, Rectangle]:
        """In the first free place, or the one that covers least."""
        best, least = places[0], float("inf")
        for place in places:
            overlap = self.overlap(*place)
            if overlap < least:
                best, least = place, overlap
            if overlap == 0:
                break
        self.take(*best)
        left, top, right, _ = best
        return svg.text((left + right) / 2, top + 10, words, f"{classes} vi-mid"), best
