"""SVG as text: numbers with a real minus sign, path data from arrays of points, marks and labels.

Arrays of points are (k, 2) px, with y downwards. Coordinates are written with one decimal.
"""

import math
from collections.abc import Sequence
from functools import cache, lru_cache
from html import escape
from typing import NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from ..estimation.equations import number
from ..geometry.arrays import Floats
from ..wording import plural

UNSEEN_E = 0.01  # px²: nobody could see a smaller conflict
SEGMENT, DOT, TIP = "M%s %sL%s %s", "M%s %sh0", "M%s %sL%s %s %s %sz"  # templates of lines, dots and arrow heads
MAX_TENTHS = 9_999  # a table holds the texts of numbers up to this many tenths
BYTE = np.uint64(8)  # bits


def short(value: float, one_digit_to: float = 1000) -> str:
    """Write a number with two decimals below 10, one below `one_digit_to`, and none above."""
    return number(value, 2 if value < 10 else 1 if value < one_digit_to else 0)


def short_E(E: float, one_digit_to: float = 1000) -> str:
    """Write E, px², as `short` does, or that it is below UNSEEN_E."""
    return f"< {UNSEEN_E:g}" if E < UNSEEN_E else short(E, one_digit_to)


def degrees(rad: float, digits: int = 1) -> str:
    """Write an angle in rad as degrees."""
    return number(math.degrees(rad), digits) + "°"


def count_motions(count: int) -> str:
    """Write a number of steps, which are the learner's motions."""
    return f"{count} {plural('step', 'steps', count)}"


def count_points(count: int) -> str:
    """Write a number of body points."""
    return f"{count} {plural('point', 'points', count)}"


def joint_symbol(joint: int) -> str:
    """Write θ with the joint's number, from 1, as subscript."""
    return "θ" + "".join("₀₁₂₃₄₅₆₇₈₉"[int(digit)] for digit in str(joint))


def path(points: Floats) -> str:
    """Write an open line through points; NaN interrupts it."""
    broken = np.isnan(points[:, 1])
    if not broken.any():
        return _line(points)
    runs = np.split(points, np.flatnonzero(broken))
    return "".join(_line(run) for run in (run[~np.isnan(run[:, 1])] for run in runs) if len(run))


def paths(points: Floats) -> list[str]:
    """Write an open line per view through (views, k, 2) px; NaN interrupts it."""
    if np.isnan(points).any():
        return [path(view) for view in points]
    return [_written(view) for view in points.reshape(len(points), -1).round(1).tolist()]


def _line(points: Floats) -> str:
    return _written(points.round(1).ravel().tolist())


def _written(numbers: list[float]) -> str:
    # long lines are frequent, and msgspec writes numbers twice as fast as formatting does
    return f"M{_as_json(numbers)[1:-1].decode()}"


_as_json = msgspec.json.Encoder().encode


def segments(start: Floats, end: Floats) -> str:
    """Write k separate lines from start to end."""
    return filled(SEGMENT * len(start), np.concatenate([start, end], 1))


def dots(points: Floats) -> str:
    """Write dots as wide as the stroke."""
    return filled(DOT * len(points), points)


def circles(points: Floats, radius: float) -> str:
    """Write circles of a radius in px."""
    r, d = f"{radius:g}", f"{2 * radius:g}"
    return filled(f"M%s %sm-{r} 0a{r} {r} 0 1 0 {d} 0a{r} {r} 0 1 0-{d} 0" * len(points), points)


def diamond(radius: float) -> str:
    """Return the template of a diamond, to be filled with its centre. radius: half its diagonal, px."""
    r = f"{radius:g}"
    return f"M%s %sm0-{r}l{r} {r}-{r} {r}-{r}-{r}z"


def diamonds(points: Floats, radius: float) -> str:
    """Write diamonds centred on points. radius: half the diagonal, px."""
    return filled(diamond(radius) * len(points), points)


def arrow_tips(start: Floats, end: Floats, size: float) -> list[str]:
    """Write per view the heads of k arrows from start to end, (views, k, 2) px; short arrows have shorter heads."""
    return [filled(TIP * end.shape[1], view) for view in arrow_corners(start, end, size)]


def arrow_corners(start: Floats, end: Floats, size: float) -> Floats:
    """Return the corners of the heads of `arrow_tips`, tip first: (views, k, 6) px."""
    tips = end.view(complex)  # x + iy: a quarter turn is a product
    along = tips - start.view(complex)
    length = np.abs(along)
    along *= np.minimum(size, length) / np.maximum(length, 1e-9)
    back, across = tips - along, 0.42j * along
    return np.concatenate([tips, back + across, back - across], 2).view(float)


def polygons(corners: Floats) -> list[str]:
    """Write per view k polygons of c corners, (views, k, c, 2) px, without corners that repeat their predecessor."""
    views, k, c, __ = corners.shape
    if k == 0:
        return [""] * views
    tenths = np.rint(corners * 10)  # of a px, so that relative steps add up exactly
    steps = tenths.copy()
    steps[:, :, 1:] -= tenths[:, :, :-1]
    template = _polygon_template(views, k, c)
    if not np.abs(steps).max() <= MAX_TENTHS:
        return filled(template, steps / 10).split("|")
    known = _template(template)
    texts = known.texts(steps.ravel())
    texts[1::2] >>= BYTE * (steps[..., 1].ravel() < 0)  # a minus sign separates two numbers without a blank
    repeated = steps.view(complex).ravel() == 0
    repeated[::c] = False  # first corners
    texts.reshape(-1, 2)[repeated] = 0
    return known.fill(texts).split("|")


@lru_cache(64)
def _polygon_template(views: int, k: int, c: int) -> str:
    return "|".join([("M%s %s" + "l%s %s" * (c - 1) + "z") * k] * views)


def cross(place: Floats, size: float) -> str:
    """Draw an upright cross at a point, (2,) px. size: from its middle to its ends, px."""
    x, y = place
    return f'<path class="vi-cross" d="M{x - size:.1f} {y:.1f}h{2 * size:g}M{x:.1f} {y - size:.1f}v{2 * size:g}"/>'


def saltire(place: Floats) -> str:
    """Draw the mark of the paper's own result at a point, (2,) px."""
    x, y = place
    return f'<path class="vi-x-paper" d="M{x - 4:.1f} {y - 4:.1f}l8 8m0-8l-8 8"/>'


def sample(mark: str, left: float, width: float) -> str:
    """Draw a mark around y = 0 that stands in a line of text. left, width: of the part that is shown, px."""
    box = f'viewBox="{left:g} -7 {width:g} 14" style="width:{width / 12:.3g}em"'
    return f'<svg class="vi vi-sample" {box} aria-hidden="true">{mark}</svg>'


def text(x: float, y: float, content: str, classes: str = "") -> str:
    """Draw a label with its baseline at (x, y) px; content is escaped."""
    attribute = f' class="{classes}"' if classes else ""
    return f'<text x="{x:.1f}" y="{y:.1f}"{attribute}>{escape(content)}</text>'


def thinned(count: int, limit: int, keep: int = 0) -> Sequence[int]:
    """Choose at most `limit` of `count` indices, evenly spaced; the first, the last and `keep` are among them."""
    if count <= limit:
        return range(count)
    kept = set(range(0, count, -(-count // (limit - 2))))
    return sorted(kept | {keep, count - 1})


def thinned_between(count: int, limit: int, keep: int) -> Sequence[int]:
    """Choose indices as `thinned` does, but densely near the first and `keep`: a path's long motions are its first."""
    if count <= limit:
        return range(count)
    families = (0, 1), (keep, -1), (keep, 1)
    room = [max(count - 1 - end if way > 0 else end, 0) for end, way in families]
    each = (limit - 2) // sum(map(bool, room))
    kept = [end + way * _geometric_steps(most, each) for (end, way), most in zip(families, room)]
    return np.unique(np.concatenate([*kept, [0, keep]])).tolist()


@lru_cache(1024)  # the pages of a class show paths of similar lengths
def _geometric_steps(most: int, count: int) -> NDArray[np.intp]:
    """Return at most `count` integers from 1 to most, geometrically spaced; none if most is 0."""
    return np.unique(np.geomspace(1, most, count).astype(int)) if most else np.empty(0, int)


# Templates with many numbers


def filled(template: str, values: Floats) -> str:
    """Fill a number with one decimal into each %s of a template.

    A table gives the texts of all numbers at once, in a quarter of the time that formatting hundreds of them takes.
    """
    tenths = np.rint(values * 10).ravel()
    if not (np.abs(tenths) <= MAX_TENTHS).all():
        return template % tuple(f"{count / 10 + 0.0:.1f}" for count in tenths.tolist())
    known = _template(template)
    return known.fill(known.texts(tenths))


class _Template(NamedTuple):
    """A template cut into words of eight bytes, padded with 0, so that numpy can fill in all numbers at once."""

    words: NDArray[np.uint64]  # uint64
    places: NDArray[np.intp]  # (n,) indices of the numbers' words
    leads: NDArray[np.uint64]  # (n,) the byte before each number, which shares its word

    def fill(self, texts: NDArray[np.uint64]) -> str:
        words = self.words.copy()
        words[self.places] = texts
        return words.tobytes().translate(None, b"\0").decode()

    def texts(self, tenths: Floats) -> NDArray[np.uint64]:
        """Look up the words of n numbers, given in tenths, with their leads."""
        return _number_words()[tenths.astype(np.intp)] | self.leads


@lru_cache(512)
def _template(text: str) -> _Template:
    *before, last = [part.encode() for part in text.split("%s")]
    words, places = b"", []
    for part in before:
        words += _padded(part[:-1])
        places.append(len(words) // 8)
        words += _padded(part[-1:] or b"\0")
    leads = np.array([part[-1] if part else 0 for part in before], "<u8")
    return _Template(np.frombuffer(words + _padded(last), "<u8"), np.array(places, np.intp), leads)


@cache
def _number_words() -> NDArray[np.uint64]:
    """Return the words of all numbers of the table, indexed by their tenths, negative ones from the end.

    The first byte of a word is free for the lead. -0 is written as 0.
    """
    counts = np.roll(np.arange(-MAX_TENTHS, MAX_TENTHS + 1), -MAX_TENTHS)
    return np.array([f"{count / 10:.1f}" for count in counts.tolist()], "S8").view("<u8") << BYTE


def _padded(text: bytes) -> bytes:
    return text + b"\0" * (-len(text) % 8)
