"""The panel Images: the learner's four image planes and what the transfer says about them."""

import math
from collections.abc import Mapping, Sequence
from functools import lru_cache
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from ...analysis.construction import Construction
from ...estimation.transfers.registry import BADLY_CONDITIONED, ILL_CONDITIONED
from ...estimation.transfers.transfer import FLATNESS
from ...estimation.views import VIEWS
from ...geometry.affine import LINE_VIEWS, MIN_POINTS, POINT_VIEWS
from ...geometry.arrays import Floats
from ...loop.snapshot import Snapshot
from ...simulation.appearance import Bodies
from .. import svg
from ..glossary import ask, glossary, key_of
from ..theme import HEAD, OBSERVED, RECOVERED, RING
from . import planes
from .planes import SIZES, Window, Windows, describe_construction, draw_construction, is_shown

GAINS = (10, 5, 2)
READOUT_UP = 8  # px from the bottom of L and R
READOUT_LETTER = 5.7  # px, width of a letter of the readout
GOAL_DOT = 3.4  # px, radius
SMALL, MAX_ARROW = 8.0, 20.0  # px: residuals below SMALL are drawn larger, up to MAX_ARROW
COUNTED = "seen", "named"  # of points: said wherever some are not
COLUMNS = (0, 74, 140, 236, 302, 372)  # px: of the metrics in print
LEGEND_SIZE, METRICS_SIZE = (424, 31), (424, 36)  # px, in print
SPARK, SPARK_MOTIONS = (96, 34), 60  # px of the small curve of E, and the motions that it shows at most
NO_PICTURES: Mapping[str, bytes] = MappingProxyType({})
HEADINGS = {"own": "The learner’s own arm, left and right eye", "demo": "Demonstrator"}  # of L and R, of l and r
PUT_BY = {True: "where the lines put it", False: "where the transfer puts it"}  # by whether lines are crossed
PRINTED_COLUMN = 108  # px, of the legend in print
RECTIFIED = {**HEADINGS, "own": "The learner’s own arm; pictures then rectified"}


def draw_images(
    snapshot: Snapshot,
    bodies: Bodies,
    windows: Windows,
    chosen: int | None = None,
    whole_frames: bool = False,
    pictures: Mapping[str, bytes] = NO_PICTURES,
    standing: Bodies | None = None,
    construction: Construction | None = None,
    stage: int | None = None,
    goal: bool = False,
    course: Sequence[float] = (),
    print_size: bool = False,
) -> str:
    """Draw the panel as HTML: the four images, the legend and the metrics, which the page's stylesheet arranges.

    windows: which part of each image is shown; chosen: a body point with a ring and its construction; whole_frames:
    whether the whole images are shown; pictures: JPEGs of the whole frames by view, drawn behind everything; standing:
    both arms where they are, if `bodies` previews another posture; construction: how the chosen point is recovered;
    stage: its last one to draw, None for all; goal: whether L and R show the learner as it would look in the
    demonstrator's posture; course: E after each motion so far, px², for a small curve; print_size: whether legend and
    metrics are drawings of a fixed width instead of text that wraps.
    """
    shown = windows[whole_frames]
    lengths = residual_lengths(snapshot)
    gain = arrow_gain(lengths)
    images = planes.image_points(snapshot.views)
    points = planes.placed(images, shown, "lrLR")
    marks = _own_marks(snapshot, points[2:], shown, gain) | _seen_marks(snapshot, points[:2])
    crossed = snapshot.method.crosses_lines
    lines = _epipolar_lines(snapshot, shown, chosen if crossed else None, stage)
    built = dict.fromkeys("lrLR", "")
    if construction is not None and chosen is not None:
        built = draw_construction(construction, shown, stage, images[2:, chosen], gain)
    content = _arms(bodies, windows, whole_frames)
    if standing is not None:
        for view, (hulls, __) in planes.draw_arm(standing.own, windows, whole_frames, "LR").items():
            content[view] = f'<path class="vi-standing" d="{hulls}"/>{content[view]}'
    if goal:
        content |= {view: ghost + content[view] for view, ghost in _ghosts(bodies, windows, whole_frames).items()}
    kind = "vi-images vi-whole" if whole_frames else "vi-images"
    kind += "" if stage is None else " vi-building"
    kind += " vi-pictured" if pictures else "" if standing is None else " vi-see-through"
    parts, rings = [], ["", "", "", ""] if chosen is None else _rings(snapshot, points, chosen)
    for k, view in enumerate("lrLR"):
        behind = planes.photograph(pictures[view], shown[view], bodies.frame) if view in pictures else ""
        all_points = marks[view] if stage is None else f'<g class="vi-faint">{marks[view]}</g>'
        inside = behind + content[view] + lines[view] + all_points + built[view]
        if is_shown(stage, crossed, view if view in "lr" else "own"):
            inside += rings[k]
        if view in "LR" and chosen is not None and is_shown(stage, crossed, "own"):
            inside += _readout(snapshot, chosen, k - 2, shown[view], SIZES[whole_frames][view])
        parts.append(planes.plane(view, shown[view], whole_frames, bodies.frame, inside))
    headings = HEADINGS if snapshot.rectification is None else RECTIFIED
    for pair, words in headings.items():
        parts.append(f'<div class="vi-heading vi-over-{pair}">{words} {ask(f"{pair}_views")}</div>')
    parts.append(draw_legend(gain, chosen, crossed, goal) if print_size else write_legend(gain, crossed, goal))
    how = "Click a point to see its lines." if crossed else "Click a point to see how it is transferred."
    if chosen is not None:
        how = describe_construction(construction, chosen, stage, crossed)
    if chosen is not None or not print_size:
        parts.append(f'<p class="vi-how">{how}</p>')
    metrics = _metrics(snapshot, lengths)
    parts.append(draw_metrics(metrics) if print_size else write_metrics(metrics, course))
    inside = "".join(parts)
    four = f'<div class="{kind}" role="group" aria-label="The four images">{inside}</div>'
    return f'<div class="vi-panel vi-four">{four}</div>'


def _ghosts(bodies: Bodies, windows: Windows, whole: bool) -> dict[str, str]:
    """Draw the learner as it would look in the demonstrator's posture, in L and R. Cached with that arm."""
    kept = bodies.goal.memory.get(("ghost", whole))
    if kept is None or kept[0] is not windows:
        points = planes.placed(bodies.goal.points, windows[whole], "LR")
        arms = planes.draw_arm(bodies.goal, windows, whole, "LR").values()
        drawn = {
            view: f'<g class="vi-ghost"><path class="vi-goal" d="{hulls}"/><path class="vi-goal-bone" d="{bones}"/>'
            f'<path class="vi-goal-ring" d="{svg.circles(points[k], GOAL_DOT)}"/></g>'
            for k, (view, (hulls, bones)) in enumerate(zip("LR", arms))
        }
        kept = bodies.goal.memory["ghost", whole] = windows, drawn
    return kept[1]


def arrow_gain(lengths: Floats) -> float:
    """Choose how many times longer residuals of these lengths, px, are drawn: 1, 2, 5 or 10."""
    largest = lengths.max(initial=0.0)
    if lengths.size == 0 or largest >= SMALL:
        return 1
    return next((gain for gain in GAINS if gain * largest <= MAX_ARROW), 1)


def _arms(bodies: Bodies, windows: Windows, whole: bool) -> dict[str, str]:
    """Draw silhouettes and skeletons by view; in L and R also the recovered skeleton."""
    drawn = {}
    for view, (hulls, bones) in planes.draw_arm(bodies.demo, windows, whole, "lr").items():
        drawn[view] = f'<g class="vi-demo"><path class="vi-hull" d="{hulls}"/><path class="vi-bone" d="{bones}"/></g>'
    found = {"L": "", "R": ""}
    if bodies.recovered is not None:
        both = planes.placed(bodies.recovered, windows[whole], "LR")
        found = {view: f'<path class="vi-bone vi-found" d="{d}"/>' for view, d in zip("LR", svg.paths(both))}
    for view, (hulls, bones) in planes.draw_arm(bodies.own, windows, whole, "LR").items():
        drawn[view] = f'<path class="vi-hull" d="{hulls}"/><path class="vi-bone" d="{bones}"/>{found[view]}'
    return drawn


def _seen_marks(snapshot: Snapshot, points: Floats) -> dict[str, str]:
    """Draw the demonstrator's points in l and r; those not visible in all four images are faint."""
    used, drawn = points[:, snapshot.usable], {}
    for k, view in enumerate("lr"):
        drawn[view] = f'<path class="vi-seen" d="{_observed(used[k].tobytes())}"/>'
    for k, idle in _partly_visible(snapshot, "lr"):
        drawn["lr"[k]] += f'<path class="vi-seen vi-idle" d="{_observed(points[k, idle].tobytes())}"/>'
    return drawn


@lru_cache(256)  # the demonstrator mostly rests while the learner moves
def _observed(points: bytes) -> str:
    return svg.diamonds(np.frombuffer(points).reshape(-1, 2), OBSERVED)


def _own_marks(snapshot: Snapshot, points: Floats, windows: dict[str, Window], gain: float) -> dict[str, str]:
    """Draw own points, recovered points, and residuals from recovered to own points, in L and R."""
    own, known = points[:, snapshot.usable], snapshot.transfer is not None
    numbers = _with_residuals(snapshot, own, windows["L"].scale, gain) if known else own.reshape(2, -1)
    drawn = dict(zip("LR", svg.filled(_marks_template(own.shape[1], known), numbers).split("|")))
    for k, idle in _partly_visible(snapshot, "LR"):
        drawn["LR"[k]] += f'<path class="vi-own vi-idle" d="{svg.dots(points[k, idle])}"/>'
    return drawn


def _with_residuals(snapshot: Snapshot, own: Floats, scale: float, gain: float) -> Floats:
    """Return the numbers that fill `_marks_template`, (2, 14 k) px, in L and in R. own: (2, k, 2) px."""
    e = snapshot.e.reshape(-1, 2, 2).transpose(1, 0, 2)[:, snapshot.usable] * scale  # (L R, k, 2)
    recovered = own - e
    tips = recovered + gain * e
    lines, heads = np.concatenate([recovered, tips], 2), svg.arrow_corners(recovered, tips, HEAD)
    return np.concatenate([numbers.reshape(2, -1) for numbers in (own, recovered, lines, heads)], 1)


@lru_cache(64)
def _marks_template(count: int, known: bool) -> str:
    """Write a template of `count` own points in L and R, with recovered points and residuals if these are known."""
    form = f'<path class="vi-own" d="{svg.DOT * count}"/>'
    if known:
        form += (
            f'<path class="vi-found" d="{svg.diamond(RECOVERED) * count}"/>'
            f'<path class="vi-e" d="{svg.SEGMENT * count}"/>'
            f'<path class="vi-tip" d="{svg.TIP * count}"/>'
        )
    return f"{form}|{form}"


def _partly_visible(snapshot: Snapshot, pair: str) -> list[tuple[int, Floats]]:
    """List the views of a pair with points that are not visible in all views, and which points these are, (N,) bool."""
    if snapshot.views.complete:
        return []
    idle = snapshot.views.visible.T & ~snapshot.usable
    return [(k, idle[view]) for k, view in enumerate(map(VIEWS.index, pair)) if idle[view].any()]


def _rings(snapshot: Snapshot, points: Floats, chosen: int) -> list[str]:
    """Draw the ring in l, r, L, R; "" where the chosen point is not visible. points: (4, N, 2) px."""
    places = zip(points[:, chosen].tolist(), snapshot.views.visible[chosen].tolist())
    ring = f'<circle class="vi-ring" cx="{{:.1f}}" cy="{{:.1f}}" r="{RING:g}"/>'
    return [ring.format(*place) if seen else "" for place, seen in places]


def _readout(snapshot: Snapshot, chosen: int, side: int, window: Window, size: tuple[int, int]) -> str:
    """Write the chosen point's residual in this image, px, in a corner that the arm leaves free."""
    e = snapshot.e[chosen, 2 * side : 2 * side + 2]
    words = f"point {chosen}: {svg.number(math.hypot(*e.tolist()))} px"
    x, end = (6, "") if window.readout_left else (size[0] - 6, " vi-end")
    width = READOUT_LETTER * len(words) + 6
    left = x - 3 if window.readout_left else x + 3 - width
    y = size[1] - READOUT_UP
    behind = f'<rect class="vi-behind" x="{left:.1f}" y="{y - 11}" width="{width:.1f}" height="15" rx="3"/>'
    return behind + svg.text(x, y, words, f"vi-chosen{end}")


def _epipolar_lines(
    snapshot: Snapshot, windows: dict[str, Window], chosen: int | None, stage: int | None
) -> dict[str, str]:
    """Draw the chosen point's epipolar lines by view; during the construction only those of the stage, in L and R."""
    drawn = dict.fromkeys("lrLR", "")
    lines = None if chosen is None else snapshot.epipolar_lines(chosen)
    if chosen is None or lines is None:
        return drawn
    seen = snapshot.views.visible[chosen].tolist()
    for k, source, line in zip(LINE_VIEWS.tolist(), POINT_VIEWS.tolist(), lines.tolist()):
        if seen[source] and (stage is None or k > 1 >= source and is_shown(stage, True, ("left", "right")[source])):
            view = "lrLR"[k]
            if d := _chord(line, windows[view]):
                style = " vi-partner" if source // 2 == k // 2 else " vi-from-right" if source % 2 else ""
                drawn[view] += f'<path class="vi-line{style}" d="{d}"/>'
    return drawn


def _chord(line: list[float], window: Window) -> str:
    """Write the part of a line a x + b y + c = 0, image px, inside the circle around a window; "" without any.

    For a dozen lines, plain numbers are faster than numpy.
    """
    a, b, c = line
    length, middle_x, middle_y = math.hypot(a, b), window.w / 2, window.h / 2
    if not length > 0:
        return ""
    a, b = a / length, b / length
    distance = (window.x + middle_x) * a + (window.y + middle_y) * b + c / length
    square = middle_x * middle_x + middle_y * middle_y - distance * distance
    if not square > 0:
        return ""
    k, half = window.scale, math.sqrt(square)
    x, y = (middle_x - distance * a) * k, (middle_y - distance * b) * k
    along_x, along_y = -half * b * k, half * a * k
    return f"M{x - along_x:.1f} {y - along_y:.1f}L{x + along_x:.1f} {y + along_y:.1f}"


# Legend and metrics


class LegendEntry(NamedTuple):
    """A mark and what it means."""

    mark: str  # SVG around (10, 0)
    words: str
    left: float  # px of the mark's left edge
    width: float  # px


def _legend_entries(gain: float, crossed: bool, goal: bool) -> list[LegendEntry]:
    """List all marks but those of the chosen point. crossed: whether the construction has epipolar lines, or steps."""
    arrow = "residual e" if gain == 1 else f"residual e, ×{gain:g}"
    diamond = lambda r: f"M10-{r}l{r} {r}-{r} {r}-{r}-{r}z"
    entries = [
        LegendEntry('<path class="vi-own" d="M10 0h0"/>', "own point", 5, 10),
        LegendEntry(f'<path class="vi-found" d="{diamond(RECOVERED)}"/>', PUT_BY[crossed], 5, 10),
        LegendEntry('<path class="vi-e" d="M1 0H16"/><path class="vi-tip" d="M20 0l-4.6 1.9v-3.8z"/>', arrow, 0, 21),
    ]
    if goal:
        ghost = '<rect class="vi-goal" x="3.5" y="-5.5" width="13" height="11" rx="4"/>'
        ring = f'<circle class="vi-goal-ring" cx="10" cy="0" r="{GOAL_DOT}"/>'
        entries.append(LegendEntry(f'<g class="vi-ghost">{ghost}{ring}</g>', "goal", 3, 14))
    return entries


@lru_cache(256)
def write_legend(gain: float, crossed: bool, goal: bool) -> str:
    """Write the legend as HTML that wraps where it must; `describe_construction` tells of the chosen point's marks."""
    written = "".join(
        f"<span>{svg.sample(one.mark, one.left, one.width)}{one.words}</span> "
        for one in _legend_entries(gain, crossed, goal)
    )
    return f'<div class="vi-legend">{written}</div>'


@lru_cache(256)
def draw_legend(gain: float, chosen: int | None, crossed: bool, goal: bool) -> str:
    """Draw the legend in two rows, for print."""
    entries = _legend_entries(gain, crossed, goal)
    if chosen is not None:
        entries.append(LegendEntry('<circle class="vi-ring" cx="10" cy="0" r="5"/>', f"point {chosen}, its", 3, 14))
    if chosen is not None and crossed:
        entries += [LegendEntry(planes.line_sample(kind), words, 0, 20) for kind, words in planes.LINE_NAMES.items()]
    elif chosen is not None:
        entries.append(LegendEntry(planes.STEPS_SAMPLE, "steps to it", 0, 20))
    (width, height), parts = LEGEND_SIZE, []
    for i, entry in enumerate(entries):
        label = f'<text class="vi-2nd" x="25" y="4">{entry.words}</text>'
        place = f"translate({2 + PRINTED_COLUMN * (i % 4)} {8 + 16 * (i // 4)})"
        parts.append(f'<g transform="{place}">{entry.mark}{label}</g>')
    return f'<svg class="vi vi-legend" viewBox="0 0 {width} {height}">{"".join(parts)}</svg>'


def residual_lengths(snapshot: Snapshot) -> Floats:
    """Return |e| of the used points in L and in R, (k, 2) px; k is 0 without a transfer."""
    if snapshot.transfer is None:
        return np.empty((0, 2))
    e = snapshot.e[snapshot.usable]
    squares = e * e
    return np.sqrt(squares[:, ::2] + squares[:, 1::2])


class Metric(NamedTuple):
    """A number of the transfer."""

    level: str  # of `gauge`
    label: str
    value: str
    text: str = "{value}"  # with unit, in which the value stands out
    title: str = ""  # the label's symbol, by which the glossary knows it


def metrics_of(snapshot: Snapshot) -> tuple[Metric, ...]:
    """Return E, mean and largest |e|, the transfer's condition, the points' flatness, and how many are visible."""
    return _metrics(snapshot, residual_lengths(snapshot))


def _metrics(snapshot: Snapshot, lengths: Floats) -> tuple[Metric, ...]:
    """lengths: from `residual_lengths`."""
    known = lengths.size > 0
    mean, largest, where = np.nan, np.nan, "{value}"
    if known:
        each = lengths.ravel().tolist()  # for few numbers faster than numpy
        mean, largest = sum(each) / len(each), max(each)
        point = snapshot.usable.nonzero()[0][each.index(largest) // 2]
        where = f"{{value}} px at {point}"
    used, count = int(snapshot.usable.sum()), len(snapshot.usable)
    condition = float(snapshot.transfer.condition) if snapshot.transfer is not None else np.nan
    name = snapshot.method.condition_name
    level, label = gauge(condition, name)
    found = [
        Metric("", "E", svg.escape(svg.short_E(snapshot.E)), "{value} px²" if known else "{value}"),
        Metric("", "mean |e|", svg.number(mean), "{value} px" if known else "{value}"),
        Metric("", "largest |e|", svg.number(largest), where),
        Metric(level, label, _short(condition, 100), title=name),
    ]
    if name != FLATNESS:
        flat = snapshot.flatness if known else np.nan
        found.append(Metric("amber" if flat >= BADLY_CONDITIONED else "", FLATNESS, _short(flat, 100)))
    if used < count:
        level, text = "red" if used < MIN_POINTS else "", f"{{value}} of {count}"
        counted = COUNTED[not snapshot.views.matched]
        found.append(Metric(level, counted, str(used), text, glossary()["points_seen"].symbol))
    return tuple(found)


def write_metrics(metrics: Sequence[Metric], course: Sequence[float] = ()) -> str:
    """Write E large, with a small curve of its course, and the other numbers small, as HTML: those that warn of nothing
    are details."""
    first, *others = metrics
    large = f'<div class="vi-metric vi-E"><span>Conflict E {_ask(first)}</span>{_value(first)}</div>'
    small = "".join(
        f'<div class="vi-metric{"" if metric.level or metric.label in COUNTED else " vi-detail"}">'
        f"<span>{metric.label} {_ask(metric)}</span>{_value(metric)}</div>"
        for metric in others
    )
    return f'<div class="vi-metrics">{large}{_small_curve(course)}{small}</div>'


def _ask(metric: Metric) -> str:
    key = key_of(metric.title or metric.label)
    return "" if key is None else ask(key)


def _value(metric: Metric) -> str:
    mark = ""
    if metric.level:
        shape = svg.diamonds(np.array([[6.0, 6.0]]), 5.5) if metric.level == "amber" else "M1 1h10v10h-10z"
        path = f'<path class="vi-{metric.level}" d="{shape}"/>'
        mark = f'<svg class="vi" viewBox="0 0 12 12" aria-hidden="true">{path}</svg>'
    return f"<span>{mark}{metric.text.format(value=f'<b>{metric.value}</b>')}</span>"


def _small_curve(course: Sequence[float]) -> str:
    """Draw log E of the last motions, with a dot at the present; the width fills as motions are made."""
    if not len(course):
        return ""
    (width, height), E = SPARK, np.asarray(course[-SPARK_MOTIONS:], float)
    log_E = np.log10(np.clip(np.nan_to_num(E, nan=svg.UNSEEN_E), svg.UNSEEN_E, None))
    low, high = min(log_E.min(), 0.0), max(log_E.max(), log_E.min() + 0.5)
    x = np.linspace(4, width - 5, max(len(E), 12))[: len(E)]
    points = np.stack([x, height - 5 - (height - 10) * (log_E - low) / (high - low)], -1)
    return (
        f'<svg class="vi vi-spark" viewBox="0 0 {width} {height}" role="img" aria-label="E over the steps">'
        f'<path class="vi-axis" d="M2 {height - 1}H{width - 2}"/><path class="vi-line-E" d="{svg.path(points)}"/>'
        f'<path class="vi-dot-E" d="{svg.dots(points[-1:])}"/></svg>'
    )


def draw_metrics(metrics: Sequence[Metric]) -> str:
    """Draw all numbers in a row, for print."""
    drawn = "".join(_metric(x, metric) for x, metric in zip(COLUMNS, metrics))
    box = f"0 0 {METRICS_SIZE[0]} {METRICS_SIZE[1]}"
    return f'<svg class="vi vi-metrics" viewBox="{box}">{drawn}</svg>'


def gauge(condition: float, name: str) -> tuple[str, str]:
    """Return the colour of a transfer's condition, and its name with a word if it is high."""
    if condition >= BADLY_CONDITIONED:
        return "red", f"{name}: too high"
    if condition >= ILL_CONDITIONED:
        return "amber", f"{name}: high"
    return "", name


def _short(value: float, whole_from: float = 1000) -> str:
    """Write one decimal for all sizes, unlike `svg.short`: large numbers that change all the time should not jump."""
    if value >= 99_999.5:
        return "∞" if np.isinf(value) else f"{value:.0e}".replace("e+0", "e")
    return svg.number(value, 1 if value < whole_from else 0)


def _metric(x: float, metric: Metric) -> str:
    y, mark, shift = 11, "", 0
    if metric.level == "amber":
        mark, shift = f'<path class="vi-amber" d="{svg.diamonds(np.array([[x + 6, y + 13.5]]), 5.5)}"/>', 15
    elif metric.level == "red":
        mark, shift = f'<rect class="vi-red" x="{x}" y="{y + 8}" width="11" height="11" rx="1.5"/>', 15
    value = f'</tspan><tspan class="vi-big">{metric.value}</tspan><tspan class="vi-2nd">'
    words = f'<tspan class="vi-2nd">{metric.text.format(value=value)}</tspan>'.replace(
        '<tspan class="vi-2nd"></tspan>', ""
    )
    return (
        f'<text class="vi-2nd" x="{x}" y="{y}">{metric.label}</text>{mark}'
        f'<text x="{x + shift}" y="{y + 20}">{words}</text>'
    )
