"""Legend and figures of the panel Images."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ..geometry.affine import MIN_POINTS
from ..loop.snapshot import Snapshot
from . import svg
from .glossary import ask, key_of
from .theme import OBSERVED, RECOVERED

AMBER, RED = 40.0, 200.0  # conditions from which a transfer is called ill and badly conditioned
COLUMNS, LETTER = (0, 86, 152, 258, 352), 5.4  # px, LETTER of a label
LEGEND_SIZE, METRICS_SIZE = (424, 31), (424, 36)  # px


@lru_cache(256)
def draw_legend(gain: float, chosen: int | None, crossed: bool) -> str:
    """A drawing of its own: two rows. crossed: whether the chosen point's epipolar lines are drawn, or steps to it."""
    arrow = "residual e" if gain == 1 else f"residual e, ×{gain:g}"
    diamond = lambda r: f"M10-{r}l{r} {r}-{r} {r}-{r}-{r}z"
    entries = [
        ('<path class="vi-own" d="M10 0h0"/>', "own point"),
        (f'<path class="vi-found" d="{diamond(RECOVERED)}"/>', "recovered"),
        ('<path class="vi-e" d="M1 0H16"/><path class="vi-tip" d="M20 0l-4.6 1.9v-3.8z"/>', arrow),
        (f'<path class="vi-seen" d="{diamond(OBSERVED)}"/>', "demonstrator"),
    ]
    if chosen is not None:
        entries.append(('<circle class="vi-ring" cx="10" cy="0" r="5.5"/>', f"point {svg.point_name(chosen)}, its"))
    if chosen is not None and crossed:
        entries.append(('<path class="vi-line" d="M0 0H20"/>', "line from left"))
        entries.append(('<path class="vi-line vi-from-right" d="M0 0H20"/>', "line from right"))
        entries.append(('<path class="vi-line vi-partner" d="M0 0H20"/>', "line from partner"))
    if chosen is not None and not crossed:
        entries.append(('<path class="vi-steps" d="M0 0H20"/><path class="vi-stop" d="M10 0h0"/>', "steps to it"))
    (width, height), parts = LEGEND_SIZE, []
    for i, (mark, words) in enumerate(entries):
        label = f'<text class="vi-2nd" x="25" y="4">{words}</text>'
        parts.append(f'<g transform="translate({2 + 101 * (i % 4)} {8 + 16 * (i // 4)})">{mark}{label}</g>')
    return f'<svg class="vi vi-legend" viewBox="0 0 {width} {height}">{"".join(parts)}</svg>'


def residual_lengths(snapshot: Snapshot) -> NDArray:
    """(k, 2) px: |e| in L and in R of the points that are used; none without a transfer."""
    if snapshot.transfer is None:
        return np.empty((0, 2))
    e = snapshot.e[snapshot.usable]
    squares = e * e
    return np.sqrt(squares[:, ::2] + squares[:, 1::2])


def draw_metrics(snapshot: Snapshot, lengths: NDArray) -> str:
    """E, mean and largest |e|, the transfer's condition, points seen, each with its "?". lengths: (k, 2) px."""
    known = lengths.size > 0
    mean, largest, where = np.nan, np.nan, ""
    if known:
        each = lengths.ravel().tolist()  # few are soon added up: each call of numpy takes as long
        mean, largest = sum(each) / len(each), max(each)
        where = f" px at {svg.point_name(int(snapshot.usable.nonzero()[0][each.index(largest) // 2]))}"
    used, count = int(snapshot.usable.sum()), len(snapshot.usable)
    condition = float(snapshot.transfer.condition) if snapshot.transfer is not None else np.nan
    level, word = gauge(condition)
    name = snapshot.method.condition_name
    few = used < MIN_POINTS
    columns = (
        ("", "E", _short(snapshot.E), " px²" if known else ""),
        ("", "mean |e|", svg.number(mean), " px" if known else ""),
        ("", "largest |e|", svg.number(largest), where),
        (level, name + word, _short(condition, 100), ""),
        ("red" if few else "", "points seen", f"{used}", f" of {count}"),
    )
    drawn = "".join(_metric(x, *column) for x, column in zip(COLUMNS, columns))
    asked = _asks(tuple((label.split(":")[0], len(label)) for _, label, _, _ in columns))
    box = f"0 0 {METRICS_SIZE[0]} {METRICS_SIZE[1]}"
    return f'<div class="vi-metrics"><svg class="vi" viewBox="{box}">{drawn}</svg>{asked}</div>'


@lru_cache(32)
def _asks(labels: tuple[tuple[str, int], ...]) -> str:
    """A "?" behind each label. labels: what is asked about, and how many letters the label has."""
    keys = [key_of(symbol) for symbol, _ in labels]
    places = [100 * (x + LETTER * letters + 4) / METRICS_SIZE[0] for x, (_, letters) in zip(COLUMNS, labels)]
    return "".join(ask(key, f"left:{place:.1f}%") for key, place in zip(keys, places) if key is not None)


def gauge(condition: float) -> tuple[str, str]:
    """Colour and word of a transfer's condition."""
    if condition >= RED:
        return "red", ": too high"
    if condition >= AMBER:
        return "amber", ": high"
    return "", ""


def _short(value: float, whole_from: float = 1000) -> str:
    """One digit whatever the size, unlike `svg.short`: large figures that change all the time should not jump."""
    if value >= 99_999.5:
        return "∞" if np.isinf(value) else f"{value:.0e}".replace("e+0", "e")
    return svg.number(value, 1 if value < whole_from else 0)


def _metric(x: float, level: str, label: str, value: str, unit: str) -> str:
    y, mark, shift = 11, "", 0
    if level == "amber":
        mark, shift = f'<path class="vi-amber" d="{svg.diamonds(np.array([[x + 6, y + 13.5]]), 5.5)}"/>', 15
    elif level == "red":
        mark, shift = f'<rect class="vi-red" x="{x}" y="{y + 8}" width="11" height="11" rx="1.5"/>', 15
    return (
        f'<text class="vi-2nd" x="{x}" y="{y}">{label}</text>{mark}<text x="{x + shift}" y="{y + 20}">'
        f'<tspan class="vi-big">{value}</tspan><tspan class="vi-2nd">{unit}</tspan></text>'
    )
