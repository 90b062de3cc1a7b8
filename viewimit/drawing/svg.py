"""Text of drawings: numbers with a real minus, and paths from arrays of points."""

import math
from collections.abc import Sequence
from functools import cache, lru_cache
from html import escape
from typing import NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from ..estimation.equations import MISSING as MISSING
from ..estimation.equations import number


def short(value: float, one_digit_to: float = 1000) -> str:
    """Fewer digits the larger the number: two below 10, one below `one_digit_to`, then none."""
    return number(value, 2 if value < 10 else 1 if value < one_digit_to else 0)


UNSEEN_E = 0.01  # px²: a conflict below it nobody could see


def short_E(E: float, one_digit_to: float = 1000) -> str:
    """px²"""
    return f"< {UNSEEN_E:g}" if E < UNSEEN_E else short(E, one_digit_to)


def degrees(rad: float, digits: int = 1) -> str:
    """An angle in rad as degrees."""
    return number(math.degrees(rad), digits) + "°"


def joint_symbol(joint: int) -> str:
    """θ with the joint's number, from 1, as subscript"""
    return "θ" + "".join("₀₁₂₃₄₅₆₇₈₉"[int(digit)] for digit in str(joint))


def point_name(i: int) -> str:
    """How the page calls body point i."""
    return str(i)


def path(points: NDArray) -> str:
    """points: (k, 2) px → one open line; NaN interrupts it."""
    broken = np.isnan(points[:, 1])
    if not broken.any():
        return _line(points)
    runs = np.split(points, np.flatnonzero(broken))
    return "".join(_line(run) for run in (run[~np.isnan(run[:, 1])] for run in runs) if len(run))


def paths(points: NDArray) -> list[str]:
    """points: (views, k, 2) px → an open line a view; NaN interrupts them."""
    if np.isnan(points).any():
        return [path(view) for view in points]
    return [_written(view) for view in points.reshape(len(points), -1).round(1).tolist()]


def _line(points: NDArray) -> str:
    return _written(points.round(1).ravel().tolist())


def _written(numbers: list[float]) -> str:
    """Long lines are frequent: msgspec writes numbers twice as fast as formatting does."""
    return f"M{_as_json(numbers)[1:-1].decode()}"


_as_json = msgspec.json.Encoder().encode


SEGMENT, DOT, TIP = "M%s %sL%s %s", "M%s %sh0", "M%s %sL%s %s %s %sz"  # forms of what the next functions draw


def segments(start: NDArray, end: NDArray) -> str:
    """start, end: (k, 2) px → k separate lines."""
    return filled(SEGMENT * len(start), np.concatenate([start, end], 1))


def dots(points: NDArray) -> str:
    """points: (k, 2) px → filled circles, as wide as the stroke."""
    return filled(DOT * len(points), points)


def circles(points: NDArray, radius: float) -> str:
    """points: (k, 2) px → circles, to be stroked."""
    r, d = f"{radius:g}", f"{2 * radius:g}"
    return filled(f"M%s %sm-{r} 0a{r} {r} 0 1 0 {d} 0a{r} {r} 0 1 0-{d} 0" * len(points), points)


def diamond(radius: float) -> str:
    """The form of one, to be filled with its centre."""
    r = f"{radius:g}"
    return f"M%s %sm0-{r}l{r} {r}-{r} {r}-{r}-{r}z"


def diamonds(points: NDArray, radius: float) -> str:
    """points: (k, 2) px, their centres."""
    return filled(diamond(radius) * len(points), points)


def arrow_tips(start: NDArray, end: NDArray, size: float) -> list[str]:
    """Filled heads of arrows from start to end, (views, k, 2) px → a path a view. Short arrows have shorter heads."""
    return [filled(TIP * end.shape[1], view) for view in arrow_corners(start, end, size)]


def arrow_corners(start: NDArray, end: NDArray, size: float) -> NDArray:
    """Of these heads: (views, k, 6) px, their points first."""
    tips = end.view(complex)  # x + iy: a quarter turn is a product
    along = tips - start.view(complex)
    length = np.abs(along)
    along *= np.minimum(size, length) / np.maximum(length, 1e-9)
    back, across = tips - along, 0.42j * along
    return np.concatenate([tips, back + across, back - across], 2).view(float)


def polygons(corners: NDArray) -> list[str]:
    """corners: (views, k, c, 2) px of closed polygons → a path a view.

    A corner that would be written as its predecessor is left out.
    """
    views, k, c, _ = corners.shape
    if k == 0:
        return [""] * views
    tenths = np.rint(corners * 10)  # of a px, so that relative steps add up exactly
    steps = tenths.copy()
    steps[:, :, 1:] -= tenths[:, :, :-1]
    form = _polygons(views, k, c)
    if not np.abs(steps).max() <= FAR_OUT:
        return filled(form, steps / 10).split("|")
    known = form_of(form)
    texts = known.texts(steps.ravel())
    texts[1::2] >>= BYTE * (steps[..., 1].ravel() < 0)  # a minus parts two numbers as well as a blank
    stays = steps.view(complex).ravel() == 0
    stays[::c] = False  # where each begins
    texts.reshape(-1, 2)[stays] = 0
    return known.written(texts).split("|")


@lru_cache(64)
def _polygons(views: int, k: int, c: int) -> str:
    """The form of that many."""
    return "|".join([("M%s %s" + "l%s %s" * (c - 1) + "z") * k] * views)


def cross(place: NDArray, size: float) -> str:
    """An upright cross at (2,) px; size: px from its middle to its ends."""
    x, y = place
    return f'<path class="vi-cross" d="M{x - size:.1f} {y:.1f}h{2 * size:g}M{x:.1f} {y - size:.1f}v{2 * size:g}"/>'


def saltire(place: NDArray) -> str:
    """The mark of what the paper says, at (2,) px."""
    x, y = place
    return f'<path class="vi-x-paper" d="M{x - 4:.1f} {y - 4:.1f}l8 8m0-8l-8 8"/>'


def text(x: float, y: float, content: str, classes: str = "") -> str:
    """One label; content is escaped."""
    attribute = f' class="{classes}"' if classes else ""
    return f'<text x="{x:.1f}" y="{y:.1f}"{attribute}>{escape(content)}</text>'


def thinned(count: int, limit: int, keep: int = 0) -> Sequence[int]:
    """Indices of at most `limit` of `count` items, evenly spaced; the first, the last and `keep` are among them."""
    if count <= limit:
        return range(count)
    kept = set(range(0, count, -(-count // (limit - 2))))
    return sorted(kept | {keep, count - 1})


def thinned_between(count: int, limit: int, keep: int) -> Sequence[int]:
    """As `thinned`, but all next to the first and to `keep`, and ever fewer the farther from both: thousands of motions
    begin with a few long ones, and go on with those that are made now."""
    if count <= limit:
        return range(count)
    families = (0, 1), (keep, -1), (keep, 1)
    room = [max(count - 1 - end if way > 0 else end, 0) for end, way in families]
    each = (limit - 2) // sum(map(bool, room))
    kept = [end + way * _ever_farther(most, each) for (end, way), most in zip(families, room)]
    return np.unique(np.concatenate([*kept, [0, keep]])).tolist()


@lru_cache(1024)  # a class has paths about as long as each other
def _ever_farther(most: int, count: int) -> NDArray:
    """Whole numbers from 1 to most, `count` or fewer, in ever larger steps; none if most is 0."""
    return np.unique(np.geomspace(1, most, count).astype(int)) if most else np.empty(0, int)


# Text with many numbers in it, all of which are put in their places at once.

FAR_OUT = 9_999  # tenths: few numbers of a drawing are larger
BYTE = np.uint64(8)  # bits


@cache
def _texts() -> NDArray:
    """(2 FAR_OUT + 1,) uint64: numbers with one decimal as bytes, filled up with 0 behind and by a byte for their lead
    before, by how many tenths they are, those below 0 counted from the end. 0 is written in one way."""
    counts = np.roll(np.arange(-FAR_OUT, FAR_OUT + 1), -FAR_OUT)
    return np.array([f"{count / 10:.1f}" for count in counts.tolist()], "S8").view("<u8") << BYTE


class Form(NamedTuple):
    """A form cut in pieces of eight bytes, filled up with 0, so that numbers are put in their places at once. places:
    (n,), of the numbers; leads: (n,), the byte before each."""

    pieces: NDArray
    places: NDArray
    leads: NDArray

    def written(self, texts: NDArray) -> str:
        """texts: (n,), of numbers with their leads."""
        pieces = self.pieces.copy()
        pieces[self.places] = texts
        return pieces.tobytes().translate(None, b"\0").decode()

    def texts(self, tenths: NDArray) -> NDArray:
        """Of so many tenths, (n,), at most FAR_OUT, each with its lead."""
        return _texts()[tenths.astype(np.intp)] | self.leads


@lru_cache(512)
def form_of(form: str) -> Form:
    """form: with %s where a number stands"""
    *before, last = [part.encode() for part in form.split("%s")]
    pieces, places = b"", []
    for part in before:
        pieces += _padded(part[:-1])
        places.append(len(pieces) // 8)
        pieces += _padded(part[-1:] or b"\0")
    leads = np.array([part[-1] if part else 0 for part in before], "<u8")
    return Form(np.frombuffer(pieces + _padded(last), "<u8"), np.array(places, np.intp), leads)


def _padded(text: bytes) -> bytes:
    return text + b"\0" * (-len(text) % 8)


def filled(form: str, values: NDArray) -> str:
    """A form with a number of one decimal in place of each %s. Texts of all numbers are taken from a table at once,
    which takes a quarter of what it takes to write hundreds of them one by one."""
    tenths = np.rint(values * 10).ravel()
    if not (np.abs(tenths) <= FAR_OUT).all():
        return form % tuple(f"{count / 10 + 0.0:.1f}" for count in tenths.tolist())
    known = form_of(form)
    return known.written(known.texts(tenths))
