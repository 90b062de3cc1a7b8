"""A drawing as a file of its own: SVG that needs nothing beside it, and PNG made of that.

Many programs that show SVG know neither CSS variables nor a page's stylesheet: the file has the rules that it uses,
with the light scheme's colours written out. No script, no address; a font is named, not brought along.
"""

import importlib.util
import re
from pathlib import Path

from ..assets import ROOT
from . import svg
from .theme import DRAWING_CSS, ROLES

FONTS = "Inter,'Helvetica Neue',Arial,'DejaVu Sans',sans-serif"
MARGIN = 8  # px around a drawing
PNG_SCALE = 3  # pixels a px
RENDERER = "resvg_py"
INSTALL = "pip install 'viewimit[plot]'"  # what brings the renderer
PNG_FONTS = [str(ROOT / "fonts" / f"Inter-{style}.ttf") for style in ("Regular", "SemiBold")]

_ROOT = re.compile(r'<svg class="([^"]*)" viewBox="0 0 ([\d.]+) ([\d.]+)"[^>]*>(.*)</svg>', re.DOTALL)
_APART = re.compile(r"/\*.*?\*/|@[^{};]*\{(?:[^{}]*\{[^{}]*\})*[^{}]*\}", re.DOTALL)  # comments, rules of some windows
_RULE = re.compile(r"([^{}]+)\{([^{}]*)\}")


def standalone(drawing: str, title: str, description: str = "", css: str = DRAWING_CSS) -> str:
    """drawing: HTML with one <svg class="vi …" viewBox="0 0 w h">; css: what its classes are looked up in. The same
    drawing gives the same file."""
    found = _ROOT.search(drawing)
    if found is None:
        raise ValueError("the drawing has no <svg class=… viewBox=…>")
    classes, width, height = found[1], float(found[2]) + 2 * MARGIN, float(found[3]) + 2 * MARGIN
    inside = _with_plain_ids(resolved(found[4]))
    frame = f'x="{-MARGIN}" y="{-MARGIN}" width="{width:g}" height="{height:g}"'
    own_size = f"svg.vi{{width:{width:g}px;height:{height:g}px;user-select:auto}}"  # not that of what it stands in
    told = f"<title>{svg.escape(title)}</title>" + (f"<desc>{svg.escape(description)}</desc>" if description else "")
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}" height="{height:g}" '
        f'viewBox="{-MARGIN} {-MARGIN} {width:g} {height:g}" class="{classes}" font-family="{FONTS}" font-size="11">'
        f"{told}<style>{styles_of(drawing, css)}{own_size}</style>"
        f'<rect {frame} fill="{ROLES["paper"][0]}"/>{inside}</svg>\n'
    )


def styles_of(drawing: str, css: str = DRAWING_CSS) -> str:
    """The rules of a stylesheet that apply to it in any window, with colours in place of variables."""
    used = {name for group in re.findall(r'class="([^"]*)"', drawing) for name in group.split()}
    rules = []
    for selectors, declarations in _RULE.findall(_APART.sub("", css)):
        kept = [each.strip() for each in selectors.split(",") if set(re.findall(r"\.([\w-]+)", each)) <= used]
        if kept:
            rules.append(f"{','.join(kept)}{{{declarations.strip()}}}")
    return resolved("".join(rules)).replace("Inter,system-ui,sans-serif", FONTS)


def resolved(text: str) -> str:
    """CSS variables replaced by the colours of the light scheme."""
    return re.sub(r"var\(--([a-z-]+)\)", lambda found: ROLES[found[1]][0], text)


def can_render() -> bool:
    """Whether PNGs can be made."""
    return importlib.util.find_spec(RENDERER) is not None


def require_renderer(path: Path, instead: str) -> None:
    """Raises ValueError if a PNG cannot be made. instead: the extension that needs nothing."""
    if not can_render():
        raise ValueError(f"{path}: .png needs {RENDERER}: {INSTALL}; {instead} does not")


def as_png(drawing: str, scale: int = PNG_SCALE) -> bytes:
    """A standalone drawing as PNG. scale: pixels a px. Needs `can_render`."""
    import resvg_py

    return bytes(
        resvg_py.svg_to_bytes(
            svg_string=drawing,
            zoom=scale,
            font_files=PNG_FONTS,
            font_family="Inter",
            sans_serif_family="Inter",
            skip_system_fonts=True,
        )
    )


def write(path: Path, drawing: str) -> None:
    """A standalone drawing as .svg or .png. Raises OSError."""
    if path.suffix.lower() == ".png":
        path.write_bytes(as_png(drawing))
    else:
        path.write_text(drawing, "utf-8")


def _with_plain_ids(inside: str) -> str:
    """Names of masks and patterns, which are unlike all others on a page, by their order."""
    names = dict.fromkeys(re.findall(r' id="([^"]+)"', inside))
    numbers = {name: f"{name[:4]}{k}" for k, name in enumerate(names)}
    return re.sub(r'(id="|url\(#)([\w-]+)', lambda found: found[1] + numbers.get(found[2], found[2]), inside)
