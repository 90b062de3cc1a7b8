"""A sheet of square markers to print and cut out, for both arms."""

from collections.abc import Iterator
from html import escape
from typing import TYPE_CHECKING

from .theme import font_faces

if TYPE_CHECKING:
    from ..sensing.detection import Fiducials

RIM = 1  # cells of white paper around a marker, which the detector needs
WIDTH, HEIGHT, MARGIN = 210.0, 297.0, 16.0  # mm, of A4
LABEL_MM, GAP_MM, HEAD_MM = 4.5, 4.0, 36.0
RULER = (
    f'<path class="ruler" d="M{MARGIN:g} 33h100m-100-1v2m100-2v2"/>'
    '<text x="118" y="34">100 mm, if printed at its size</text>'
)
SECTION = """<section><h1>Markers of the {arm}</h1>
<p>Print at <b>100 %</b> and cut along the grey lines. Stick number 0 on the learner where number {n} is on the
demonstrator, 1 where {m} is, and so on: on the base and on every link, eight or more in sight of both cameras.
Keep them flat. Detect them with <b>--aruco {dictionary}</b>.</p>
<svg viewBox="0 0 210 297" xml:space="preserve">{svg}</svg></section>"""
CSS = """@page{size:A4;margin:0}body{margin:0;font:8.5pt/1.3 Inter,sans-serif}
section{position:relative;width:210mm;height:296.9mm;box-sizing:border-box;padding:9mm 16mm 0;overflow:hidden}
section+section{break-before:page}h1{font-size:13pt;margin:0 0 1mm}p{margin:0}
svg{position:absolute;inset:0;width:210mm;height:297mm}text{font-size:3px;white-space:pre}
.cut{fill:none;stroke:#b9bec8;stroke-width:.25}.ruler{fill:none;stroke:#000;stroke-width:.25}
@media screen{body{background:#d9dce2}section{margin:6mm auto;background:#fff}}"""
PAGE = """<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{title}</title>
<meta http-equiv="Content-Security-Policy" content="default-src 'none';style-src 'unsafe-inline';font-src data:">
<style>{css}</style></head><body>{pages}</body></html>"""


def marker_sheet(fiducials: "Fiducials", count: int, demonstrator_from: int, size_mm: float) -> str:
    """Return a page of HTML with `count` markers for each arm, the demonstrator's from a number on.

    Raises ValueError for a side, mm, that does not fit on A4.
    """
    pages = [
        page
        for arm, first in (("learner", 0), ("demonstrator", demonstrator_from))
        for page in _pages_of_arm(fiducials, arm, first, count, demonstrator_from, size_mm)
    ]
    title = f"Markers {fiducials.name} for two arms · viewimit"
    return PAGE.format(title=title, css=f"{font_faces()}{CSS}", pages="".join(pages))


def _pages_of_arm(
    fiducials: "Fiducials", arm: str, first: int, count: int, demonstrator_from: int, size_mm: float
) -> Iterator[str]:
    """Yield the pages of one arm: their markers on an SVG in mm."""
    cells = fiducials.dictionary.markerSize + 2 * (1 + RIM)
    cell = size_mm / (cells - 2 * RIM)
    paper = cells * cell
    columns = int((WIDTH - 2 * MARGIN + GAP_MM) // (paper + GAP_MM))
    rows = int((HEIGHT - MARGIN - HEAD_MM + GAP_MM) // (paper + LABEL_MM + GAP_MM))
    if columns < 1 or rows < 1:
        raise ValueError(f"a marker of {size_mm:g} mm does not fit on A4")
    for begin in range(0, count, rows * columns):
        markers = [RULER]
        for k in range(begin, min(begin + rows * columns, count)):
            row, column = divmod(k - begin, columns)
            x, y = MARGIN + column * (paper + GAP_MM), HEAD_MM + row * (paper + LABEL_MM + GAP_MM)
            inner = fiducials.cells(first + k, cells)[RIM:-RIM, RIM:-RIM].tolist()
            markers.append(f'<path class="cut" d="{_rectangle(x, y, paper, paper + LABEL_MM)}"/>')
            markers.append(f'<text x="{x + 1:.2f}" y="{y + paper + LABEL_MM - 1.3:.2f}">{first + k}  {arm}</text>')
            markers.append(_marker(x + RIM * cell, y + RIM * cell, cell, inner))
        yield SECTION.format(arm=arm, n=demonstrator_from, m=demonstrator_from + 1, svg="".join(markers),
                             dictionary=escape(fiducials.name))  # fmt: skip


def _marker(left: float, top: float, cell: float, white: list[list[bool]]) -> str:
    """A black square of which the white cells are cut out, run by run."""
    d = _rectangle(left, top, len(white) * cell, len(white) * cell)
    for line, row in enumerate(white):
        edges = [k for k, (a, b) in enumerate(zip([False, *row], [*row, False])) if a != b]
        for begin, end in zip(edges[::2], edges[1::2]):
            d += _rectangle(left + begin * cell, top + line * cell, (end - begin) * cell, cell)
    return f'<path fill-rule="evenodd" d="{d}"/>'


def _rectangle(x: float, y: float, width: float, height: float) -> str:
    return f"M{x:.3f} {y:.3f}h{width:.3f}v{height:.3f}h{-width:.3f}z"
