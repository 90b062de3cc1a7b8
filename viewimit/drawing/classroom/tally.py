"""What a class has answered: bars, before and after it was talked about, and who moved from wrong to right. HTML."""

from collections.abc import Sequence
from dataclasses import dataclass

from .. import svg

MOVES = (264, 128)  # units
BAR, GAP, SIDE = 22, 7, 66  # units: a column's width, from it to its words, and room for these
TOP, HIGH = 22, 100  # units of the columns
LEAST = 1  # answers below which no share is shown


@dataclass(frozen=True)
class Bar:
    """words: of an answer; count: of who gave it; before: when it was asked first, None if it was asked once; right:
    None while that is not shown."""

    words: str
    count: int
    before: int | None = None
    right: bool | None = None


def draw_bars(bars: Sequence[Bar]) -> str:
    """One below the other; of the first time dashed, over that of now."""
    most = max([1, *(one.count for one in bars), *(one.before or 0 for one in bars)])
    rows = []
    for one in bars:
        kind = " vi-bar-right" if one.right else ""
        mark = " ✓" if one.right else ""
        rows.append(f'<div class="vi-tally-words">{svg.escape(one.words)}{mark}</div>')
        if one.before is not None:
            rows.append(_row("first", one.before, most, f"vi-tally-first{kind}"))
        rows.append(_row("again" if one.before is not None else "", one.count, most, f"vi-tally-now{kind}"))
    return f'<div class="vi-tally">{"".join(rows)}</div>'


def _row(when: str, count: int, most: int, kind: str) -> str:
    label = f"<small>{when}</small>" if when else ""
    return (
        f'<div class="vi-tally-row">{label}<i class="{kind}" style="width:{70 * count / most:.0f}%"></i>{count}</div>'
    )


def draw_moves(moved: tuple[int, int, int, int]) -> str:
    """From right to right, wrong to right, right to wrong, wrong to wrong: two columns, and bands between them."""
    rr, wr, rw, ww = moved
    total = sum(moved)
    if total < LEAST:
        return ""
    unit = HIGH / total
    left, right = SIDE, MOVES[0] - SIDE - BAR
    first_right, first_wrong, then_right, then_wrong = TOP, TOP + unit * (rr + rw), TOP, TOP + unit * (rr + wr)
    parts = [
        _band(left + BAR, first_right, right, then_right, unit * rr, "stayed"),
        _band(left + BAR, first_right + unit * rr, right, then_wrong, unit * rw, "lost"),
        _band(left + BAR, first_wrong, right, then_right + unit * rr, unit * wr, "won"),
        _band(left + BAR, first_wrong + unit * wr, right, then_wrong + unit * rw, unit * ww, "wrong"),
    ]
    for x, top_count, words_x, anchor, title in (
        (left, rr + rw, left - GAP, " vi-end", "first"),
        (right, rr + wr, right + BAR + GAP, "", "again"),
    ):
        for y, count, kind, words in (
            (TOP, top_count, "right", "right"),
            (TOP + unit * top_count, total - top_count, "wrong", "wrong"),
        ):
            if count:
                parts.append(
                    f'<rect class="vi-moves-{kind}" x="{x}" y="{y:.1f}" width="{BAR}" height="{unit * count:.1f}"/>'
                )
                parts.append(
                    svg.text(words_x, y + unit * count / 2 + 4, f"{count} {words}", f"vi-b vi-moves-words{anchor}")
                )
        parts.append(svg.text(x + BAR / 2, 14, title, "vi-2nd vi-mid"))
    label = f"{wr} moved from wrong to right, {rw} from right to wrong, {rr} stayed right, {ww} stayed wrong"
    box = f"0 0 {MOVES[0]} {MOVES[1]}"
    drawn = f'<svg class="vi vi-moves" viewBox="{box}" role="img" aria-label="{label}">{"".join(parts)}</svg>'
    return f"{drawn}<p>{_gain(moved)}</p>"


def _band(x: float, y: float, to_x: float, to_y: float, high: float, kind: str) -> str:
    if high <= 0:
        return ""
    middle = (x + to_x) / 2
    over = f"M{x} {y:.1f}C{middle} {y:.1f} {middle} {to_y:.1f} {to_x} {to_y:.1f}"
    under = f"v{high:.1f}C{middle} {to_y + high:.1f} {middle} {y + high:.1f} {x} {y + high:.1f}z"
    return f'<path class="vi-moves-{kind}" d="{over}{under}"/>'


def _gain(moved: tuple[int, int, int, int]) -> str:
    """In words: the normalised gain, of those who could still gain."""
    rr, wr, rw, ww = moved
    before, after, total = rr + rw, rr + wr, sum(moved)
    if before == total:
        return "All were right at first."
    gain = (after - before) / (total - before)
    return f"{before} of {total} were right at first, {after} again: normalised gain <b>{svg.number(gain, 2)}</b>."
