"""Drawings as files: standalone SVG, PNG, PDF, and figures with a caption that makes them citable.

Many programs that show SVG know neither CSS variables nor a page's stylesheet. A standalone file therefore holds the
rules that it uses, with the light scheme's colours written out. It has no script and no address; it names its font
without embedding it. Such programs know no MathML either, so equations are typeset as outlines.

A PDF is made by Typst, whose SVG reader is that of resvg, which renders the PNGs: its lines stay lines, and its text
stays text, in a subset of the font that the file holds.
"""

import html
import importlib.util
import re
import textwrap
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from ...assets import ROOT
from ...estimation.equations import MISSING, Equation
from .. import svg
from ..equations import filled
from ..theme import DRAWING_CSS, ROLES
from .citation import Citation

FONTS = "Inter,'Helvetica Neue',Arial,'DejaVu Sans',sans-serif"
MARGIN = 8  # px around a drawing
PNG_SCALE, PRINT_SCALE = 3, 4  # pixels per px of a drawing; PRINT_SCALE: 15 cm at 300 pixels per inch
RENDERER, TYPESETTER = "resvg_py", "ziamath"
INSTALL = "pip install 'viewimit[plot]'"  # installs both
NO_PNG = f"PNG needs {RENDERER}: {INSTALL}; SVG does not"
WRITERS = {".png": (RENDERER, INSTALL), ".pdf": ("typst", "pip install 'viewimit[typst]'")}  # packages, by extension
PICTURES = (".svg", *WRITERS)
TYPST = """#set document(title: sys.inputs.title, date: none)
#set page(width: auto, height: auto, margin: 0pt)
#image(bytes(sys.inputs.picture), format: "svg", alt: sys.inputs.title)"""
PNG_FONTS = [str(ROOT / "fonts" / f"Inter-{style}.ttf") for style in ("Regular", "SemiBold")]
WIDTH = 424  # px of most drawings
GAP, LINE = 8, 12  # px between drawings, and between the lines of the caption
LETTERS = 70  # per line of a caption that is WIDTH px wide
EQUATION_PX = 13  # height of a letter
LARGE, SMALL = ("L", "R"), ("l", "r")
SVG_NAMESPACE = "http://www.w3.org/2000/svg"
COLUMNS = ((0, 17), (110, 14), (195, 16), (299, 14), (398, 5))  # of the paper's claims: px, letters per line
HEADS = ("", "paper", "here", "tolerance", "")
WORDS = {True: "pass", False: "miss", None: MISSING}

_ROOT = re.compile(r'<svg class="([^"]*)" viewBox="0 0 ([\d.]+) ([\d.]+)"[^>]*>(.*)</svg>', re.DOTALL)
_COMMENT_OR_AT_RULE = re.compile(r"/\*.*?\*/|@[^{};]*\{(?:[^{}]*\{[^{}]*\})*[^{}]*\}", re.DOTALL)
_RULE = re.compile(r"([^{}]+)\{([^{}]*)\}")


# Files


def standalone(drawing: str, title: str, description: str = "", css: str = DRAWING_CSS) -> str:
    """Turn a drawing into an SVG file with its own styles. The same drawing gives the same file.

    drawing: HTML with one `<svg class="vi …" viewBox="0 0 w h">`; title, description: what screen readers say of the
    file; css: the stylesheet in which the drawing's classes are looked up. Returns text of the file. Raises ValueError
    if the drawing has no such element.
    """
    found = _ROOT.search(drawing)
    if found is None:
        raise ValueError("the drawing has no <svg class=… viewBox=…>")
    classes, width, height = found[1], float(found[2]) + 2 * MARGIN, float(found[3]) + 2 * MARGIN
    inside = _with_short_ids(with_light_colours(found[4]))
    frame = f'x="{-MARGIN}" y="{-MARGIN}" width="{width:g}" height="{height:g}"'
    own_size = f"svg.vi{{width:{width:g}px;height:{height:g}px;user-select:auto}}"  # not that of its container
    head = f"<title>{svg.escape(title)}</title>" + (f"<desc>{svg.escape(description)}</desc>" if description else "")
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<svg xmlns="{SVG_NAMESPACE}" width="{width:g}" height="{height:g}" '
        f'viewBox="{-MARGIN} {-MARGIN} {width:g} {height:g}" class="{classes}" font-family="{FONTS}" font-size="11">'
        f"{head}<style>{used_rules(drawing, css)}{own_size}</style>"
        f'<rect {frame} fill="{ROLES["paper"][0]}"/>{inside}</svg>\n'
    )


def used_rules(drawing: str, css: str = DRAWING_CSS) -> str:
    """Select the rules of a stylesheet that apply to a drawing in any window, with colours instead of variables."""
    used = {name for group in re.findall(r'class="([^"]*)"', drawing) for name in group.split()}
    rules = []
    for selectors, declarations in _RULE.findall(_COMMENT_OR_AT_RULE.sub("", css)):
        kept = [each.strip() for each in selectors.split(",") if set(re.findall(r"\.([\w-]+)", each)) <= used]
        if kept:
            rules.append(f"{','.join(kept)}{{{declarations.strip()}}}")
    return with_light_colours("".join(rules)).replace("Inter,system-ui,sans-serif", FONTS)


def with_light_colours(text: str) -> str:
    """Replace CSS variables by the colours of the light scheme."""
    return re.sub(r"var\(--([a-z-]+)\)", lambda found: ROLES[found[1]][0], text)


def _with_short_ids(inside: str) -> str:
    """Number the ids of masks and patterns, which are unique on a page, in their order."""
    names = dict.fromkeys(re.findall(r' id="([^"]+)"', inside))
    numbers = {name: f"{name[:4]}{k}" for k, name in enumerate(names)}
    return re.sub(r'(id="|url\(#)([\w-]+)', lambda found: found[1] + numbers.get(found[2], found[2]), inside)


def can_render(suffix: str = ".png") -> bool:
    """Say whether the package that writes this kind of picture is installed."""
    return importlib.util.find_spec(WRITERS[suffix][0]) is not None


def require_renderer(path: Path, instead: str) -> None:
    """Raise ValueError if a picture of this name cannot be written. instead: the extension that needs no package."""
    suffix = path.suffix.lower()
    if suffix in WRITERS and not can_render(suffix):
        package, install = WRITERS[suffix]
        raise ValueError(f"{path}: {suffix} needs {package}: {install}; {instead} does not")


def as_png(picture: str, scale: int = PRINT_SCALE) -> bytes:
    """Render a standalone SVG; this may hold the interpreter for a second. scale: pixels per px. Needs `can_render`."""
    import resvg_py

    return bytes(
        resvg_py.svg_to_bytes(
            svg_string=picture,
            zoom=scale,
            font_files=PNG_FONTS,
            font_family="Inter",
            sans_serif_family="Inter",
            skip_system_fonts=True,
        )
    )


def as_pdf(picture: str) -> bytes:
    """Convert a standalone SVG to PDF, 1 px to 0.75 pt. The same picture gives the same file. Needs `can_render`."""
    import typst

    title = re.search(r"<title>(.*?)</title>", picture)
    inputs = {"picture": picture, "title": html.unescape(title[1]) if title else ""}
    compile_source: Callable[..., bytes] = typst.compile
    return compile_source(TYPST.encode(), sys_inputs=inputs, font_paths=[str(ROOT / "fonts")], ignore_system_fonts=True)


def write(path: Path, picture: str) -> None:
    """Write a standalone SVG as .svg, .png or .pdf. Raises OSError."""
    suffix = path.suffix.lower()
    if suffix in WRITERS:
        path.write_bytes(as_pdf(picture) if suffix == ".pdf" else as_png(picture, PNG_SCALE))
    else:
        path.write_text(picture, "utf-8")


# Figures: drawings of panels, composed and captioned


class SvgElement(NamedTuple):
    """An `<svg>` element of a panel's HTML."""

    classes: str  # of the element, which say what it is
    width: float  # px
    height: float  # px
    inside: str  # its children

    def at(self, x: float, y: float, width: float | None = None) -> str:
        """Place it in another drawing at (x, y) px, scaled to a width in px."""
        width = self.width if width is None else width
        size = f'width="{width:g}" height="{self.height * width / self.width:g}"'
        box = f'viewBox="0 0 {self.width:g} {self.height:g}"'
        return f'<svg x="{x:g}" y="{y:g}" {size} {box}><g class="{self.classes}">{self.inside}</g></svg>'


@dataclass(frozen=True)
class Figure:
    """A drawing without its `<svg>` element and without a caption."""

    inside: str  # children of the `<svg>`
    width: float  # px
    height: float  # px
    title: str  # a sentence

    def captioned(self, citation: Citation, css: str = DRAWING_CSS) -> str:
        """Make a standalone SVG with the caption below. css: the stylesheet of the drawing's classes."""
        letters = round(LETTERS * self.width / WIDTH)
        lines = [(line, "vi-b") for line in textwrap.wrap(f"{self.title}.", letters)]
        lines += [(line, "vi-2nd") for line in textwrap.wrap(f"{citation.conditions}. {citation.software}.", letters)]
        if citation.command:
            wrapped = textwrap.wrap(f"Repeated by: {citation.command}", letters, break_on_hyphens=False)
            lines += [(line, "vi-2nd") for line in wrapped]
        caption = "".join(
            svg.text(0, self.height + GAP + LINE * (k + 1), line, kind) for k, (line, kind) in enumerate(lines)
        )
        height = self.height + GAP + LINE * (len(lines) + 0.5)
        drawing = f'<svg class="vi" viewBox="0 0 {self.width:g} {height:g}">{self.inside}{caption}</svg>'
        return standalone(drawing, self.title, f"{citation.conditions}. {citation.software}.", css)


def svg_elements(panel: str) -> list[SvgElement]:
    """List the outermost `<svg class=… viewBox="0 0 w h">` of HTML in their order; icons, which lack these, are not."""
    found: list[SvgElement] = []
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
            if box and classes:
                inside = panel[start.end() : tag.start()]
                found.append(SvgElement(classes[1], float(box[1]), float(box[2]), inside))
    return found


def stack(panels: Sequence[str], title: str) -> Figure:
    """Place the drawings of panels' HTML below each other."""
    parts, y = [], 0.0
    elements = [element for panel in panels for element in svg_elements(panel)]
    width = max((element.width for element in elements), default=WIDTH)
    for element in elements:
        scale = width / element.width if element.width < WIDTH / 2 else 1
        parts.append(element.at(0, y, element.width if scale == 1 else width))
        y += element.height * scale + GAP
    return Figure("".join(parts), width, y - GAP, title)


def overlay(panels: Sequence[str], title: str) -> Figure:
    """Place panels' HTML with one drawing each over each other, as wide as the first."""
    elements = [element for panel in panels for element in svg_elements(panel)]
    first = elements[0]
    return Figure("".join(element.at(0, 0, first.width) for element in elements), first.width, first.height, title)


def append_below(figure: Figure, panel: str) -> Figure:
    """Add a panel's HTML below a figure."""
    added = stack([panel], figure.title)
    part = SvgElement("", added.width, added.height, added.inside).at(0, figure.height + GAP)
    height = figure.height + GAP + added.height
    return Figure(figure.inside + part, max(figure.width, added.width), height, figure.title)


def four_images(panel: str, title: str) -> Figure:
    """Arrange the panel Images: L, R, l, r in a row, or whole frames two by two; below them legend and metrics."""
    elements = svg_elements(panel)
    by_view = {view: one for view in "lrLR" for one in elements if f"vi-at-{view}" in one.classes.split()}
    if len(by_view) < 4:
        return stack([panel], title)
    rest = [element for element in elements if element not in by_view.values()]
    whole = by_view["l"].width == by_view["L"].width
    rows = (LARGE, SMALL) if whole else ((*LARGE, *SMALL),)
    parts, y = [], 0.0
    for row in rows:
        x = 0.0
        for view in row:
            parts.append(by_view[view].at(x, y))
            x += by_view[view].width + 4
        words = _view_captions(panel, row, by_view, y)
        parts += words
        y += max(by_view[view].height for view in row) + (LINE + 6 if words else 4)
    for element in rest:
        parts.append(element.at(0, y))
        y += element.height + 2
    return Figure("".join(parts), WIDTH, y, title)


def _view_captions(panel: str, row: Sequence[str], by_view: dict[str, SvgElement], y: float) -> list[str]:
    """Repeat below a row the page's words on which arm each pair of images shows."""
    parts, x = [], 0.0
    for pair, views in (("own", LARGE), ("demo", SMALL)):
        if set(views) <= set(row):
            width = sum(by_view[view].width + 4 for view in views) - 4
            words = re.search(rf'vi-over-{pair}">([^<]*?)\s*<', panel)
            height = max(by_view[view].height for view in views)
            if words:
                parts.append(f"<g>{svg.text(x + width / 2, y + height + LINE, words[1], 'vi-2nd vi-mid')}</g>")
            x += width + 4
    return parts


# Equations


def can_typeset() -> bool:
    """Say whether the package that typesets equations is installed."""
    return importlib.util.find_spec(TYPESETTER) is not None


def typeset_equations(equations: Sequence[Equation], title: str) -> Figure:
    """Typeset equations below each other, each with its number, title and note. Needs `can_typeset`."""
    parts, y = [], 0.0
    for equation in equations:
        head = f"{equation.number} {equation.title}".strip()
        parts += [svg.text(0, (y := y + LINE + 2), line, "vi-b") for line in textwrap.wrap(head, LETTERS)]
        drawn, height = _typeset(filled(equation), y + GAP)
        parts.append(drawn)
        y += height + 2 * GAP
        note = html.unescape(re.sub(r"<[^>]*>", "", equation.note))
        parts += [svg.text(0, (y := y + LINE), line, "vi-2nd") for line in textwrap.wrap(note, LETTERS)]
        y += GAP
    return Figure("".join(parts), WIDTH, y, title)


def _typeset(mathml: str, y: float) -> tuple[str, float]:
    """Typeset one equation with its upper edge at y px, at most WIDTH px wide. → the drawing, its height in px."""
    import ziamath

    before, ziamath.config.svg2 = ziamath.config.svg2, False  # outlines without names
    try:
        root = ziamath.Math(mathml, size=EQUATION_PX).svgxml()
    finally:
        ziamath.config.svg2 = before
    left, top, width, height = map(float, root.get("viewBox", "").split())
    scale = min(1.0, WIDTH / width)
    ET.register_namespace("", SVG_NAMESPACE)
    inside = (
        "".join(ET.tostring(child, "unicode") for child in root)
        .replace(f' xmlns="{SVG_NAMESPACE}"', "")
        .replace("black", "var(--ink)")
    )
    move = f"translate({-left * scale:.2f} {y - top * scale:.2f}) scale({scale:.4f})"
    return f'<g transform="{move}">{inside}</g>', height * scale


# Claims


class ClaimRow(NamedTuple):
    """One statement of the paper beside the result found here."""

    name: str
    paper: str  # the paper's value
    here: str  # the value found here
    tolerance: str  # within which they agree
    holds: bool | None  # None if this is not judged


def draw_claims(claims: Iterable[ClaimRow]) -> str:
    """Draw a table of the paper's claims below an experiment's figure."""
    parts, y = [_row(HEADS, LINE, "vi-2nd")[0]], LINE
    for one in claims:
        cells = one.name.split(": ", 1)[-1], one.paper, one.here, one.tolerance, WORDS[one.holds]
        drawn, lines = _row(cells, y + LINE + 3, "" if one.holds is not False else "vi-b")
        parts.append(drawn)
        y += LINE * lines + 3
    return f'<svg class="vi" viewBox="0 0 {WIDTH} {y + 4:g}">{"".join(parts)}</svg>'


def _row(cells: Sequence[str], y: float, kind: str) -> tuple[str, int]:
    """Draw a row of the table, its first line at y px. → the drawing, its number of lines."""
    wrapped = [textwrap.wrap(cell, letters) for cell, (_x, letters) in zip(cells, COLUMNS)]
    placed = [(x, k, line) for lines, (x, _) in zip(wrapped, COLUMNS) for k, line in enumerate(lines)]
    drawn = "".join(svg.text(x, y + LINE * k, line, kind) for x, k, line in placed)
    return drawn, max(map(len, wrapped))
