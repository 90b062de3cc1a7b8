"""Relief of E over a grid: shading and labelled contours.

The shading is a picture of opacity only, used as the mask of one colour, so that it serves light and dark.
"""

import base64
import io
import itertools
import secrets
from collections.abc import Sequence
from typing import cast

import numpy as np
from contourpy import ContourGenerator, contour_generator
from PIL import Image

from ..geometry.arrays import Floats
from . import svg
from .labels import CHARACTER, LINE, Label, Rectangle

LEVELS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000)
MAX_LEVELS = 9
FINE = np.array([1, 1.5, 2, 3, 5, 7])  # levels of fine contours, times powers of ten
MAX_OPACITY = 0.78
MAX_RATIO = 2000  # E below the largest divided by this is shaded as the valley's floor
FINE_GRID = 40  # postures per joint from which the shading uses every second one
SPACING = 2.6  # px between vertices of a contour
MAX_DEVIATION = np.radians(40)  # between a label and its ray
_PROCESS, _ids = secrets.token_hex(3), itertools.count()  # drawings of several processes are shown on one page

Grid = tuple[Floats, Floats]


def shading(grid: Grid, E: Floats, box: tuple[float, float, float, float]) -> str:
    """Draw the shading of E, (rows, columns). grid: px of its columns and rows; box: x, y, w, h of the plot, px."""
    every = 2 if min(E.shape) >= FINE_GRID else 1  # browsers interpolate
    alpha, blind = _alpha(E[::every, ::every])
    parts = [_masked(grid, every, alpha, box, "vi-hills")]
    if blind.any():
        name = f"vi-h{_PROCESS}-{next(_ids)}"
        parts.append(
            f'<pattern id="{name}" width="6" height="6" patternUnits="userSpaceOnUse">'
            '<path class="vi-blind" d="M0 6L6 0"/></pattern>'
        )
        parts.append(_masked(grid, every, 255.0 * blind, box, f'" fill="url(#{name})'))
    return "".join(parts)


def _alpha(E: Floats) -> tuple[Floats, Floats]:
    """Return the opacity, 0 … 255, and where E is unknown."""
    top = np.nanmax(E)
    bottom = max(np.nanmin(E), top / MAX_RATIO, 1e-12)
    with np.errstate(invalid="ignore"):
        height = np.log(np.maximum(E, bottom) / bottom) / max(np.log(top / bottom), 1e-9)
    blind = np.isnan(height)
    return np.where(blind, 0, 255 * MAX_OPACITY * np.clip(height, 0, 1) ** 0.85), blind


def _masked(grid: Grid, every: int, alpha: Floats, box: tuple[float, float, float, float], fill: str) -> str:
    """Draw a rectangle of one colour, masked by a picture with a pixel at every `every`-th grid point."""
    x, y = grid
    buffer = io.BytesIO()
    Image.fromarray(np.rint(alpha[::-1]).astype(np.uint8)).save(buffer, "PNG")
    data = base64.b64encode(buffer.getvalue()).decode()
    rows, columns = alpha.shape
    dx, dy = every * (x[1] - x[0]), every * (y[0] - y[1])
    top = y[every * (rows - 1)]
    left, upper, w, h = box
    name, place = f"vi-m{_PROCESS}-{next(_ids)}", f'x="{left:.1f}" y="{upper:.1f}" width="{w:.1f}" height="{h:.1f}"'
    return (
        f'<mask id="{name}" maskUnits="userSpaceOnUse" {place}><image x="{x[0] - dx / 2:.2f}" y="{top - dy / 2:.2f}"'
        f' width="{columns * dx:.2f}" height="{rows * dy:.2f}" preserveAspectRatio="none"'
        f' href="data:image/png;base64,{data}"/></mask><rect class="{fill}" {place} mask="url(#{name})"/>'
    )


def contours(grid: Grid, E: Floats) -> str:
    """Draw contours at levels 1, 2, 5 …"""
    generator = _generator(grid, E)
    lines = [_thin(line) for level in _levels(E) for line in _lines(generator, level)]
    return f'<path class="vi-contour" d="{"".join(map(svg.path, lines))}"/>'


def level_labels(grid: Grid, E: Floats, bounds: Sequence[float], lowest: Floats) -> list[Label]:
    """Make labels of the contours near two opposite rays from `lowest`, (2,) px, to the plot's far corner.

    bounds: left, top, right and bottom of the plot, px.
    """
    generator, found = _generator(grid, E), []
    rays = _rays(bounds, lowest)
    for level in _levels(E):
        lines = [_thin(line) for line in _lines(generator, level)]
        if lines:
            found += [_level_label(np.concatenate(lines), f"{level:g}", lowest, ray) for ray in rays]
    return found


def _level_label(line: Floats, words: str, lowest: Floats, ray: float) -> Label:
    middle = lambda place: ((place[0] + place[2]) / 2, (place[1] + place[3]) / 2 + 4)
    draw = lambda place: (svg.text(*middle(place), words, "vi-2nd vi-halo vi-mid"), ())
    return Label(_places(line, words, lowest, ray), draw)


def fine_contours(grid: Grid, E: Floats) -> str:
    """Draw narrowly spaced contours without labels."""
    if np.isnan(E).all():
        return ""
    low, high = max(np.nanmin(E), np.nanmax(E) / 100, 1e-9), np.nanmax(E)
    decades = 10.0 ** np.arange(np.floor(np.log10(low)), np.log10(max(high, 2 * low)) + 1)
    levels = np.outer(decades, FINE).ravel()
    generator = _generator(grid, E)
    lines = [line for level in levels if low < level < high for line in _lines(generator, level)]
    return f'<path class="vi-contour" d="{"".join(svg.path(line) for line in lines)}"/>'


def _levels(E: Floats) -> list[float]:
    """Return the highest levels, at most MAX_LEVELS."""
    top = np.nanmax(E)
    return [level for level in LEVELS if max(np.nanmin(E), top / MAX_RATIO) < level < top][-MAX_LEVELS:]


def _generator(grid: Grid, E: Floats) -> ContourGenerator:
    """Contour log E, which is nearly linear between grid points."""
    with np.errstate(invalid="ignore"):
        z = np.log(np.maximum(E, 1e-12))
    return contour_generator(*grid, np.ma.masked_invalid(z))


def _lines(generator: ContourGenerator, level: float) -> list[Floats]:
    """Return the lines on which E has this value, px."""
    return cast(list[Floats], generator.lines(np.log(level)))  # of the default type


def _thin(line: Floats) -> Floats:
    """Keep vertices about SPACING px from each other, with the first and the last."""
    steps = np.diff(line, axis=0)
    length = np.sqrt((steps * steps).sum(1)).sum()
    return line[svg.thinned(len(line), max(int(length / SPACING) + 1, 8))]


def _rays(bounds: Sequence[float], lowest: Floats) -> list[float]:
    """Return the directions towards the corner farthest from `lowest` and away from it, rad."""
    left, top, right, bottom = bounds
    corners = np.array([[x, y] for x in (left, right) for y in (top, bottom)]) - lowest
    farthest = corners[np.argmax((corners * corners).sum(1))]
    angle = float(np.arctan2(farthest[1], farthest[0]))
    return [angle, angle + np.pi]


def _places(points: Floats, words: str, lowest: Floats, ray: float) -> list[Rectangle]:
    """List places on a contour, (n, 2) px, the nearest to the ray first."""
    x, y = (points - lowest).T
    off = np.abs((np.arctan2(y, x) - ray + np.pi) % (2 * np.pi) - np.pi)
    nearest = np.argsort(off)[:120:3]
    middle = points[nearest[off[nearest] <= MAX_DEVIATION]]
    half = np.array([CHARACTER * len(words) + 8, LINE + 2]) / 2
    return np.concatenate([middle - half, middle + half], 1).tolist()
