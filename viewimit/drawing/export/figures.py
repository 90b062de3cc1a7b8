"""Drawings of the page as pictures that stand alone: in colours of print, with the caption that makes them citable."""

import re
import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from .. import standalone, svg
from ..theme import DRAWING_CSS
from .citation import Citation

WIDTH = 424  # px of most drawings
GAP, LINE = 8, 12  # px between drawings, and from line to line of the caption
LETTERS = 70  # of a line of the caption, WIDTH px wide
PRINT_SCALE = 4  # pixels a px: 15 cm at 300 pixels an inch
SUFFIXES = (".svg", ".png")
LARGE, SMALL = ("L", "R"), ("l", "r")


class Drawn(NamedTuple):
    """An <svg> of a panel. inside: what it holds; classes: its own, which say what it is."""

    classes: str
    width: float
    height: float
    inside: str

    def at(self, x: float, y: float, width: float | None = None) -> str:
        """As part of another one; width: px, in place of its own."""
        width = self.width if width is None else width
        size = f'width="{width:g}" height="{self.height * width / self.width:g}"'
        box = f'viewBox="0 0 {self.width:g} {self.height:g}"'
        return f'<svg x="{x:g}" y="{y:g}" {size} {box}><g class="{self.classes}">{self.inside}</g></svg>'


@dataclass(frozen=True)
class Figure:
    """inside: of an <svg>, width x height px; title: a sentence on what is shown."""

    inside: str
    width: float
    height: float
    title: str

    def captioned(self, citation: Citation, css: str = DRAWING_CSS) -> str:
        """A standalone SVG. css: what its classes are looked up in. The same drawing gives the same file."""
        words = _caption(self.title, citation, round(LETTERS * self.width / WIDTH))
        lines = "".join(
            svg.text(0, self.height + GAP + LINE * (k + 1), line, kind) for k, (line, kind) in enumerate(words)
        )
        height = self.height + GAP + LINE * (len(words) + 0.5)
        drawing = f'<svg class="vi" viewBox="0 0 {self.width:g} {height:g}">{self.inside}{lines}</svg>'
        return standalone.standalone(drawing, self.title, f"{citation.conditions}. {citation.software}.", css)


def as_png(picture: str) -> bytes:
    """At print size. It holds the interpreter for a second or more."""
    return standalone.as_png(picture, PRINT_SCALE)


def written(picture: str, suffix: str, render: Callable[[str], bytes] = as_png) -> bytes:
    """A standalone SVG as .svg or .png. Raises ValueError for a PNG without what renders it."""
    if suffix == ".svg":
        return picture.encode()
    if not standalone.can_render():
        raise ValueError(f"PNG needs {standalone.RENDERER}: {standalone.INSTALL}; SVG does not")
    return render(picture)


def stacked(panels: Sequence[str], title: str) -> Figure:
    """Panels' HTML, each of one drawing or several, under each other."""
    parts, y = [], 0.0
    drawings = [drawn for panel in panels for drawn in drawings_in(panel)]
    width = max((drawn.width for drawn in drawings), default=WIDTH)
    for drawn in drawings:
        parts.append(drawn.at(0, y, width if drawn.width < WIDTH / 2 else None))
        y += drawn.height * (width / drawn.width if drawn.width < WIDTH / 2 else 1) + GAP
    return Figure("".join(parts), width, y - GAP, title)


def laid_over(panels: Sequence[str], title: str) -> Figure:
    """Panels' HTML, of one drawing each, over each other."""
    drawings = [drawn for panel in panels for drawn in drawings_in(panel)]
    first = drawings[0]
    return Figure("".join(drawn.at(0, 0, first.width) for drawn in drawings), first.width, first.height, title)


def beneath(figure: Figure, panel: str) -> Figure:
    """A panel's HTML below it."""
    added = stacked([panel], figure.title)
    part = Drawn("", added.width, added.height, added.inside).at(0, figure.height + GAP)
    height = figure.height + GAP + added.height
    return Figure(figure.inside + part, max(figure.width, added.width), height, figure.title)


def four_images(panel: str, title: str) -> Figure:
    """The panel Images: L and R large, l and r beside them, legend and figures beneath; whole frames two by two."""
    drawings = drawings_in(panel)
    by_view = {view: drawn for view in "lrLR" for drawn in drawings if f"vi-at-{view}" in drawn.classes.split()}
    if len(by_view) < 4:
        return stacked([panel], title)
    rest = [drawn for drawn in drawings if drawn not in by_view.values()]
    whole = by_view["l"].width == by_view["L"].width
    rows = (LARGE, SMALL) if whole else ((*LARGE, *SMALL),)
    parts, y = [], 0.0
    for row in rows:
        x = 0.0
        for view in row:
            parts.append(by_view[view].at(x, y))
            x += by_view[view].width + 4
        words = _views_named(panel, row, {view: by_view[view] for view in row}, y)
        parts += words
        y += max(by_view[view].height for view in row) + (LINE + 6 if words else 4)
    for drawn in rest:
        parts.append(drawn.at(0, y))
        y += drawn.height + 2
    return Figure("".join(parts), WIDTH, y, title)


def _views_named(panel: str, row: Sequence[str], drawn: dict[str, Drawn], y: float) -> list[str]:
    """Which arm the images of a row show, as the page says it, beneath them."""
    parts, x = [], 0.0
    for pair, views in (("own", LARGE), ("demo", SMALL)):
        if set(views) <= set(row):
            width = sum(drawn[view].width + 4 for view in views) - 4
            said = re.search(rf'vi-over-{pair}">([^<]*?)\s*<', panel)
            height = max(drawn[view].height for view in views)
            if said:
                parts.append(f"<g>{svg.text(x + width / 2, y + height + LINE, said[1], 'vi-2nd vi-mid')}</g>")
            x += width + 4
    return parts


def drawings_in(panel: str) -> list[Drawn]:
    """The outermost <svg class=… viewBox="0 0 w h"> of HTML, in their order."""
    found: list[Drawn] = []
    depth, start = 0, None
    for tag in re.finditer(r"<svg\b[^>]*>|</svg>", panel):
        if tag[0] != "</svg>":
            depth += 1
            if depth == 1:
                start = tag
            continue
        depth -= 1
        if depth == 0 and start is not None:
            box = re.search(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', start[0])
            classes = re.search(r'class="([^"]*)"', start[0])
            if box and classes:  # else an icon
                found.append(Drawn(classes[1], float(box[1]), float(box[2]), panel[start.end() : tag.start()]))
    return found


def _caption(title: str, citation: Citation, letters: int) -> list[tuple[str, str]]:
    """Lines and their classes."""
    lines = [(line, "vi-b") for line in textwrap.wrap(f"{title}.", letters)]
    lines += [(line, "vi-2nd") for line in textwrap.wrap(f"{citation.conditions}. {citation.software}.", letters)]
    if citation.repeated_by:
        wrapped = textwrap.wrap(f"Repeated by: {citation.repeated_by}", letters, break_on_hyphens=False)
        lines += [(line, "vi-2nd") for line in wrapped]
    return lines
