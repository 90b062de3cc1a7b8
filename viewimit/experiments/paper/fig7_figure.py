"""Fig. 7 on the page: E over the postures with its parabola, how far off its minimum is, and how far that holds."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...analysis.minima import MAX_RELATIVE_ERROR, RADII_DEG
from ...drawing import relief, svg
from ...drawing.labels import CHARACTER
from ...drawing.plots import Axes, decade_ticks, decades, figure, log10, sentence, style_of
from ...drawing.posture_plane import PosturePlane
from ...drawing.theme import OBSERVED
from ...estimation.transfers import TRANSFERS
from ...simulation.scene import Scene
from .claims import PAPER_DEMONSTRATOR_DEG
from .fig7 import PAPER_MINIMUM_DEG, Fig7, Surface

SENTENCE = ("Maps E over all postures: is there", "one valley, and does it end at the", "demonstrator's posture?")
MAP_WIDTH, MAP_HIGH, MAP_TOP = 270, 118, 19  # px; the plane's own margins are inside
CLOSE = (322, 31, 420, 107)  # left, top, right, bottom px of the plot of biases
VALID = (322, 139, 420, 191)
BIAS_DEG = 5.0  # that the plot shows at least
PERCENT = (1.0, 100.0)  # that the plot shows in any case
CROSS, DOT = 6.0, 1.8  # px
OUT = 32  # px from a title to its plot, left of it


def draw(scene: Scene, found: Fig7 | None = None) -> str:
    """found: what is there so far."""
    parts = [_map(scene, found), _biases(scene, found), _validity(found), _legend(found)]
    return figure(found.settings if found else None, "".join(parts))


def _map(scene: Scene, found: Fig7 | None) -> str:
    plane = PosturePlane(scene, MAP_WIDTH, MAP_HIGH)
    surface = found.surfaces.get(found.settings.transfer) if found else None
    if not plane.has_plane:
        inside = plane.message("two joints must move")
    elif found is None:
        x, y, w, h = plane.box
        inside = sentence(SENTENCE, x + w / 2, y + h / 2)
    elif surface is None:
        inside = plane.message("computing …")
    elif np.isnan(surface.landscape.E).all():
        inside = plane.message("nowhere are five points seen")
    else:
        inside = _relief(plane, found, surface)
    return f'<g transform="translate(0 {MAP_TOP - 7})">{plane.frame("vi-plane")}{inside}{plane.axes()}</g>'


def _relief(plane: PosturePlane, found: Fig7, surface: Surface) -> str:
    grid, E = plane.grid(surface.landscape.axes), surface.landscape.E
    demo = plane.place(np.array(found.demonstrator_deg))
    minima = plane.place(np.degrees(surface.minima.theta))
    lowest = minima[0] if len(minima) else demo
    plane.labels.take_points(np.stack([demo, *minima]), 9)
    levels = relief.level_labels(grid, E, plane.labels.bounds, lowest)
    parts = [relief.shading(grid, E, plane.box), relief.contours(grid, E), plane.labels.draw(levels)]
    parts.append(_ellipse(plane, surface))
    parts.append(f'<path class="vi-seen" d="{svg.diamonds(demo[None], OBSERVED + 1)}"/>')
    parts += [svg.cross(place, CROSS if k == 0 else CROSS / 2) for k, place in enumerate(minima)]
    return "".join(parts)


def _ellipse(plane: PosturePlane, surface: Surface) -> str:
    """How far the parabola δθᵀQδθ holds."""
    ring = surface.convexity.ring_deg() if surface.convexity else None
    if ring is None:
        return ""
    return f'<path class="vi-x-ellipse" d="{svg.path(plane.place(np.degrees(surface.minima.theta[0]) + ring))}"/>'


def _biases(scene: Scene, found: Fig7 | None) -> str:
    """Smallest E minus the demonstrator's posture: of this one, of others, and the paper's."""
    studies = found.studies if found else {}
    largest = [np.nanmax(np.abs(study.bias_deg), initial=0) for study in studies.values()]
    here = _here(found)
    most = float(np.ceil(max([BIAS_DEG, *largest, *np.abs(here).ravel()])))
    left, top, right, bottom = CLOSE
    wide = most * (right - left) / (bottom - top)
    plot = Axes(CLOSE, (-wide, wide), (-most, most))
    shown = 5.0 * max(1, most // 10)
    ticks = [(angle, svg.number(angle, 0) + "°") for angle in (-shown, 0, shown)]
    parts = [plot.frame("Minimum − demonstrator", "", ticks, ticks, OUT)]
    names = [svg.joint_symbol(joint) for joint in scene.moving_joints]
    parts.append(f'<path class="vi-rule" d="M{(left + right) / 2:.1f} {top}V{bottom}"/>')
    parts.append(svg.text((left + right) / 2 + 4, top + 9, names[0], "vi-2nd"))
    parts.append(svg.text(right, (top + bottom) / 2 - 4, names[-1], "vi-2nd vi-end"))
    for transfer, study in reversed(studies.items()):
        style = style_of(transfer, _transfers(found))
        parts.append(style.marks(plot.place(study.bias_deg[:, 1], study.bias_deg[:, 0]), DOT))
    parts += [svg.cross(plot.place(*bias[::-1]), CROSS) for bias in here]
    if found is None or found.demonstrator_deg == PAPER_DEMONSTRATOR_DEG:
        paper = np.subtract(PAPER_MINIMUM_DEG, PAPER_DEMONSTRATOR_DEG)
        parts.append(svg.saltire(plot.place(*paper[::-1])))
    return "".join(parts)


def _validity(found: Fig7 | None) -> str:
    """How far E is off its parabola, over the distance from the minimum."""
    curves = {name: each.convexity for name, each in found.surfaces.items() if each.convexity} if found else {}
    worst = np.concatenate([*(100 * curved.worst for curved in curves.values()), np.empty(0)])
    x, y = (float(RADII_DEG[0]), float(RADII_DEG[-1])), (decades(worst, *PERCENT)[0], np.nanmax([*worst, PERCENT[1]]))
    plot = Axes(VALID, x, y, log10, log10)
    ticks = [(value, f"{words} %") for value, words in decade_ticks(*y, 3)]
    degrees = [(radius, f"{radius}°") for radius in (1, 3, 10, 30)]
    parts = [plot.frame("E − δθᵀQδθ, relative", "", degrees, ticks, OUT)]
    parts.append(plot.level(100 * MAX_RELATIVE_ERROR, "vi-cursor"))
    for name, curved in reversed(curves.items()):
        style = style_of(name, _transfers(found))
        parts.append(plot.line(curved.radius_deg, 100 * curved.worst, style.line))
    return "".join(parts)


def _legend(found: Fig7 | None) -> str:
    """What the marks stand for, in two columns below the map."""
    here, transfers = _here(found), _transfers(found)
    off = "" if not len(here) else f" ({svg.number(here[0, 0])}°, {svg.number(here[0, 1])}°) off"
    demonstrator = f'<path class="vi-seen" d="{svg.diamonds(np.array([[8, 0]]), OBSERVED + 1)}"/>'
    entries = [(demonstrator, "demonstrator"), (svg.cross(np.array([8, 0]), CROSS), f"smallest E{off}")]
    entries.append((svg.saltire(np.array([8, 0])), "the paper's"))
    entries.append(('<ellipse class="vi-x-ellipse" cx="8" cy="0" rx="8" ry="4"/>', "δθᵀQδθ, where it holds"))
    places = [(2, 175), (122, 175), (2, 191), (122, 191)]
    parts = [_entry(*place, *entry) for place, entry in zip(places, entries)]
    x = 2.0
    for name in transfers:
        parts.append(_entry(x, 207, style_of(name, transfers).sample(-2, 0), name))
        x += 36 + CHARACTER * len(name)
    return "".join(parts)


def _entry(x: float, y: float, mark: str, words: str) -> str:
    return f'<g transform="translate({x:.1f} {y})">{mark}{svg.text(25, 4, words, "vi-2nd")}</g>'


def _here(found: Fig7 | None) -> NDArray:
    """(0 or 1, 2) degrees: bias of the smallest E with the transfer of the settings."""
    surface = found.surfaces.get(found.settings.transfer) if found else None
    if found is None or surface is None or not len(surface.minima):
        return np.empty((0, 2))
    return np.degrees(surface.minima.theta[:1]) - found.demonstrator_deg


def _transfers(found: Fig7 | None) -> Sequence[str]:
    """The one of the settings first."""
    own = found.settings.transfer if found else next(iter(TRANSFERS))
    return [own, *(name for name in TRANSFERS if name != own)]
