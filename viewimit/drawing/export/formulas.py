"""Equations as a drawing: programs that show SVG know no MathML, so their letters become outlines."""

import html
import importlib.util
import re
import textwrap
import xml.etree.ElementTree as ET
from collections.abc import Sequence

from ...estimation.equations import Equation
from .. import svg
from ..equations import filled
from ..standalone import INSTALL
from .figures import GAP, LETTERS, LINE, WIDTH, Figure

TYPESETTER = "ziamath"
SIZE = 13  # px of a letter
SVG = "http://www.w3.org/2000/svg"


def can_typeset() -> bool:
    return importlib.util.find_spec(TYPESETTER) is not None


def require_typesetter() -> None:
    """Raises ValueError where equations cannot be drawn."""
    if not can_typeset():
        raise ValueError(f"a picture of equations needs {TYPESETTER}: {INSTALL}")


def draw_formulas(equations: Sequence[Equation], title: str) -> Figure:
    """One below the other, each with its number, its title and its note. Needs `can_typeset`."""
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
    """Its upper edge at y, px, as wide as it is or as there is room, and its height."""
    import ziamath

    before, ziamath.config.svg2 = ziamath.config.svg2, False  # outlines without names
    try:
        root = ziamath.Math(mathml, size=SIZE).svgxml()
    finally:
        ziamath.config.svg2 = before
    left, top, width, height = map(float, root.get("viewBox", "").split())
    scale = min(1.0, WIDTH / width)
    ET.register_namespace("", SVG)
    inside = (
        "".join(ET.tostring(child, "unicode") for child in root)
        .replace(f' xmlns="{SVG}"', "")
        .replace("black", "var(--ink)")
    )
    move = f"translate({-left * scale:.2f} {y - top * scale:.2f}) scale({scale:.4f})"
    return f'<g transform="{move}">{inside}</g>', height * scale
