"""Who came how far from the same start: a table, the visitor first."""

from collections.abc import Sequence
from dataclasses import dataclass

from .. import svg

HEADS = (
    "who, from the same start",
    "E below {:g} after",
    "motions made",
    "E at the end",
    "off the demonstrator",
    "why it stopped",
)


@dataclass(frozen=True)
class Row:
    """reached: motions until E was below the goal, None if it never was; off_deg: largest joint, the truth; E, off_deg:
    at the end, None before that."""

    name: str
    role: str
    reached: int | None
    motions: int
    E: float | None
    off_deg: float | None
    why: str


def draw_standings(rows: Sequence[Row], goal: float) -> str:
    """HTML."""
    head = "".join(f"<th>{svg.escape(words.format(goal))}</th>" for words in HEADS)
    body = "".join(_row(row) for row in rows)
    return f'<table class="vi-standings"><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>'


def _row(row: Row) -> str:
    line = (
        f'<svg class="vi vi-way-sample" viewBox="0 0 40 12"><path class="vi-way vi-way-{row.role}" d="M2 6H38"/>'
        f'<path class="vi-way-dots vi-way-{row.role}" d="M20 6h0"/></svg>'
    )
    if row.E is None or row.off_deg is None:
        never, ends = "…", ("…", "…")
    else:
        never, ends = "never", (svg.short(row.E), f"{svg.number(row.off_deg, 1)}°")
    reached = never if row.reached is None else str(row.reached)
    cells = reached, str(row.motions), *ends, row.why
    kind = ' class="vi-own-row"' if row.role == "you" else ""
    return (
        f"<tr{kind}><td>{line}{svg.escape(row.name)}</td>"
        + "".join(f"<td>{svg.escape(c)}</td>" for c in cells)
        + "</tr>"
    )
