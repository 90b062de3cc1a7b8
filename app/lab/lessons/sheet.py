"""A4 pages with text, lines and shapes, as HTML or PDF: the drawing is the same in both.

Coordinates are in mm from the top left corner. Text is set in the page's own font, and its width is measured with it.
PDF needs fpdf2 (`pip install 'viewimit[pdf]'`): pure Python, it embeds our fonts and draws paths; the alternatives
need a browser or native libraries, or are several times larger.
"""

import html
import re
from collections.abc import Sequence
from functools import cache
from typing import Protocol

from PIL import ImageFont
from viewimit.assets import ROOT

from viewimit.drawing.theme import font_faces

WIDTH, HEIGHT, MARGIN = 210.0, 297.0, 16.0  # mm
PT = 25.4 / 72  # mm
LEADING = 1.38  # of a line, times the letters' size
INK, GREY, PALE, FILL = "#1b2130", "#5b6270", "#b9bec8", "#eef0f3"
FONTS = {False: "Inter-Regular.ttf", True: "Inter-SemiBold.ttf"}
Point = tuple[float, float]
Word = tuple[str, bool]  # and whether it is bold


class Canvas(Protocol):
    """Pages that shapes and text are drawn on."""

    def page(self) -> None:
        """Begin a page."""
        ...

    def path(
        self, points: Sequence[Point], stroke: str = INK, width: float = 0.25, fill: str = "", closed: bool = False,
        dashes: tuple[float, float] | None = None,
    ) -> None:  # fmt: skip
        """Draw a line through points; stroke or fill "" for none."""
        ...

    def circle(self, at: Point, radius: float, stroke: str = INK, width: float = 0.25, fill: str = "") -> None:
        """Draw a circle."""
        ...

    def text(self, at: Point, words: str, size: float, bold: bool = False, colour: str = INK) -> None:
        """Write one line, its baseline beginning at a point; size in pt."""
        ...


class HtmlCanvas:
    """Pages as SVG in one HTML file, to be printed by a browser."""

    def __init__(self) -> None:
        self._pages: list[list[str]] = []

    def page(self) -> None:
        self._pages.append([])

    def path(self, points, stroke=INK, width=0.25, fill="", closed=False, dashes=None) -> None:
        d = "M" + "L".join(f"{x:.2f} {y:.2f}" for x, y in points) + ("Z" if closed else "")
        dashed = f' stroke-dasharray="{dashes[0]} {dashes[1]}"' if dashes else ""
        self._pages[-1].append(f'<path d="{d}"{self._paint(stroke, width, fill)}{dashed}/>')

    def circle(self, at, radius, stroke=INK, width=0.25, fill="") -> None:
        shape = f'<circle cx="{at[0]:.2f}" cy="{at[1]:.2f}" r="{radius:.2f}"{self._paint(stroke, width, fill)}/>'
        self._pages[-1].append(shape)

    def text(self, at, words, size, bold=False, colour=INK) -> None:
        weight = ' font-weight="600"' if bold else ""
        place = f'x="{at[0]:.2f}" y="{at[1]:.2f}" font-size="{size * PT:.3f}"'
        self._pages[-1].append(f'<text {place}{weight} fill="{colour}">{html.escape(words, quote=False)}</text>')

    @staticmethod
    def _paint(stroke: str, width: float, fill: str) -> str:
        return f' fill="{fill or "none"}" stroke="{stroke or "none"}" stroke-width="{width:.2f}"'

    def finish(self, title: str) -> str:
        """Return the file."""
        size = f'width="{WIDTH:g}mm" height="{HEIGHT:g}mm" viewBox="0 0 {WIDTH:g} {HEIGHT:g}"'
        pages = "".join(
            f'<svg xmlns="http://www.w3.org/2000/svg" {size} role="group" aria-label="Page {k}">{"".join(shapes)}</svg>'
            for k, shapes in enumerate(self._pages, 1)
        )
        css = (
            f"{font_faces()}@page{{size:A4;margin:0}}body{{margin:0;background:#d9dce2}}"
            "svg{display:block;margin:6mm auto;background:#fff;font-family:Inter,sans-serif;max-width:100%;height:auto}"
            "text{white-space:pre;font-kerning:none;font-feature-settings:'calt' 0}"
            "@media print{body{background:none}svg{margin:0;break-after:page;max-width:none}}"
        )
        policy = "default-src 'none';style-src 'unsafe-inline';font-src data:"
        return (
            f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{html.escape(title)}</title>'
            f'<meta http-equiv="Content-Security-Policy" content="{policy}">'
            '<meta name="viewport" content="width=device-width,initial-scale=1">'
            f"<style>{css}</style></head><body>{pages}</body></html>"
        )


class PdfCanvas:
    """Pages as PDF.

    Raises
    ------
    ModuleNotFoundError
        Without fpdf2.
    """

    def __init__(self) -> None:
        from fpdf import FPDF

        self._pdf = FPDF(unit="mm", format="A4")
        self._pdf.set_auto_page_break(False)
        for bold, name in FONTS.items():
            self._pdf.add_font("Inter", "B" if bold else "", ROOT / "fonts" / name)

    def page(self) -> None:
        self._pdf.add_page()

    def path(self, points, stroke=INK, width=0.25, fill="", closed=False, dashes=None) -> None:
        with self._pdf.new_path() as path:
            self._paint(path, stroke, width, fill)
            if dashes:
                path.style.stroke_dash_pattern = dashes
            path.move_to(*points[0])
            for point in points[1:]:
                path.line_to(*point)
            path.style.auto_close = False
            if closed:
                path.close()

    def circle(self, at, radius, stroke=INK, width=0.25, fill="") -> None:
        with self._pdf.new_path() as path:
            self._paint(path, stroke, width, fill)
            path.circle(at[0], at[1], radius)

    @staticmethod
    def _paint(path, stroke: str, width: float, fill: str) -> None:
        path.style.stroke_color = stroke or None
        path.style.fill_color = fill or None
        path.style.stroke_width = width

    def text(self, at, words, size, bold=False, colour=INK) -> None:
        self._pdf.set_font("Inter", "B" if bold else "", size)
        self._pdf.set_text_color(colour)
        self._pdf.text(at[0], at[1], words)

    def finish(self, title: str) -> bytes:
        """Return the file."""
        self._pdf.set_title(title)
        self._pdf.set_lang("en")
        return bytes(self._pdf.output())


@cache
def _font(bold: bool) -> ImageFont.FreeTypeFont:
    return ImageFont.truetype(str(ROOT / "fonts" / FONTS[bold]), 1000)


@cache
def _advance(letter: str, bold: bool) -> float:
    return _font(bold).getlength(letter) / 1000


def text_width(words: str, size: float, bold: bool = False) -> float:
    """Return how wide words are [mm], in letters of a size [pt], without kerning."""
    return sum(_advance(letter, bold) for letter in words) * size * PT


def wrapped(text: str, size: float, width: float, bold: bool = False) -> list[list[Word]]:
    """Break a text with **bold** parts into lines of at most a width [mm]."""
    words = [
        (word, bold or bool(k % 2))
        for k, part in enumerate(text.split("**"))
        for word in re.findall(r"\S+\s*|\s+", part)
    ]
    lines: list[list[Word]] = [[]]
    used = 0.0
    for word, is_bold in words:
        if used + text_width(word.rstrip(), size, is_bold) > width and lines[-1]:
            lines.append([])
            used = 0.0
            if not word.strip():
                continue
        lines[-1].append((word, is_bold))
        used += text_width(word, size, is_bold)
    return [line for line in lines if line]


def write(
    canvas: Canvas, at: Point, text: str, size: float, width: float, bold: bool = False, colour: str = INK
) -> float:
    """Write a text from its top left corner; return the height that it takes [mm]."""
    x, y = at
    lines = wrapped(text, size, width, bold)
    for k, line in enumerate(lines):
        place, baseline = x, y + (k * LEADING + 1.0) * size * PT
        for word, is_bold in line:
            canvas.text((place, baseline), word.rstrip(), size, is_bold, colour)
            place += text_width(word, size, is_bold)
    return len(lines) * size * PT * LEADING
