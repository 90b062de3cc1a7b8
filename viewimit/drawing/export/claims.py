"""What the paper says beside what was found, as a drawing under an experiment's figure."""

import textwrap
from collections.abc import Sequence
from typing import Protocol

from .. import svg
from .figures import LINE, WIDTH

COLUMNS = ((0, 17), (110, 14), (195, 16), (299, 14), (398, 5))  # px, and letters of a line
HEADS = ("", "paper", "here", "tolerance", "")
WORDS = {True: "pass", False: "miss", None: svg.MISSING}


class Claim(Protocol):
    """holds: None where nothing is judged."""

    @property
    def name(self) -> str: ...
    @property
    def paper(self) -> str: ...
    @property
    def here(self) -> str: ...
    @property
    def tolerance(self) -> str: ...
    @property
    def holds(self) -> bool | None: ...


def draw_claims(claims: Sequence[Claim]) -> str:
    """HTML of an SVG; "" without claims."""
    parts, y = [_row(HEADS, LINE, "vi-2nd")[0]], LINE
    for claim in claims:
        cells = claim.name.split(": ", 1)[-1], claim.paper, claim.here, claim.tolerance, WORDS[claim.holds]
        drawn, lines = _row(cells, y + LINE + 3, "" if claim.holds is not False else "vi-b")
        parts.append(drawn)
        y += LINE * lines + 3
    box = f"0 0 {WIDTH} {y + 4:g}"
    return f'<svg class="vi" viewBox="{box}">{"".join(parts)}</svg>' if claims else ""


def _row(cells: Sequence[str], y: float, kind: str) -> tuple[str, int]:
    """y: px, of its first line. → the drawing, and how many lines it has."""
    wrapped = [textwrap.wrap(cell, letters) for cell, (_, letters) in zip(cells, COLUMNS)]
    drawn = (
        svg.text(x, y + LINE * k, line, kind) for lines, (x, _) in zip(wrapped, COLUMNS) for k, line in enumerate(lines)
    )
    return "".join(drawn), max(map(len, wrapped))
