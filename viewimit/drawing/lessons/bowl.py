"""The landscape of E, large: empty, or with its relief, and with the ways that were gone over it."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...analysis.landscape import Landscape
from ...simulation.scene import Scene
from .. import relief, svg
from ..labels import Label, Labels
from ..posture_plane import PosturePlane
from ..theme import OBSERVED
from . import mark, narrow

WIDTH, MOST_HIGH = 640, 330  # units
MARGINS = (40, 12, 12, 36)
LAYERS = ("relief", "demonstrator", "smallest", "paths", "others", "apart")
MOST_DOTS = 60  # motions, of a longer way only the line is drawn
CLEAR = 4.0  # units on both sides of a way that labels leave free


@dataclass(frozen=True)
class Way:
    """Over the landscape. name: beside it; role: you, learner, opponent or slow; postures_deg: (k, 2); probes: (k,)
    whether each was made to learn from; best: with the smallest E, after which it only looked for something lower."""

    name: str
    role: str
    postures_deg: NDArray
    probes: NDArray
    best: int


@dataclass(frozen=True, eq=False)
class Hills:
    """Drawing of a landscape, the place of its smallest E, and the places of the labels of its levels."""

    parts: tuple[str, ...] = ()
    lowest: NDArray | None = None
    levels: Sequence[Label] = ()


def plane_of(scene: Scene, in_narrow: bool = False) -> PosturePlane:
    """in_narrow: of a window that is."""
    return PosturePlane(scene, narrow.WIDTH if in_narrow else WIDTH, MOST_HIGH, MARGINS)


def unplace(scene: Scene, at: NDArray, in_narrow: bool = False) -> NDArray:
    """(2,) units of the drawing → degrees of the two joints, within their range."""
    plane = plane_of(scene, in_narrow)
    corners = np.array(scene.range_deg, float).T
    first, last = plane.place(corners)
    low, high = corners
    return np.clip(low + (high - low) * ((at - first) / (last - first))[::-1], low, high)


def draw_bowl(
    scene: Scene,
    found: Landscape | None,
    layers: Collection[str],
    theta_demo: NDArray,
    ways: Sequence[Way] = (),
    guess: NDArray | None = None,
    distance: str = "",
    note: str = "",
    in_narrow: bool = False,
    others: NDArray | None = None,
) -> str:
    """HTML. found: None while it is computed; theta_demo: (2,) rad; guess: (2,) degrees, the visitor's mark; distance:
    in words, from there to the smallest E; others: (k, 2) degrees, a class's marks."""
    plane = plane_of(scene, in_narrow)
    labels = plane.labels.copy()
    labels.letter = narrow.LETTER if in_narrow else labels.letter
    hills = _hills(plane, found, labels) if "relief" in layers else Hills()
    parts, above, lowest = [plane.frame("vi-plane"), *hills.parts], [], hills.lowest
    if others is not None:
        above.append(mark.crowd(plane.place(others)))
    for way in ways:
        points = plane.place(way.postures_deg)
        labels.take_line(points, CLEAR)
        parts.append(_way(points, way))
    if lowest is not None and "smallest" in layers:
        above.append(svg.cross(lowest, 8))
        labels.take_points(lowest, 9)
    width = narrow.WIDTH if in_narrow else WIDTH
    if guess is not None:
        labels.take(*mark.room(plane.place(guess), "your mark", width).tolist())
    if "demonstrator" in layers:
        demo = plane.place(np.degrees(theta_demo))
        above.append(f'<path class="vi-seen" d="{svg.diamonds(demo[None], OBSERVED + 2)}"/>')
        labels.take_points(demo, 9)
        above.append(labels.led(float(demo[0]), float(demo[1]), "demonstrator", "vi-lead-demo", True))
    if lowest is not None and "smallest" in layers:
        above.append(labels.led(float(lowest[0]), float(lowest[1]), "smallest E", "vi-lead", False))
    above += [_name(way, plane, labels) for way in ways]
    if guess is not None:
        at = plane.place(guess)
        if "apart" in layers and lowest is not None:
            above.append(mark.distance(at, lowest, distance))
        above.append(mark.cross_hair(at, "your mark", (width, plane.height)))
    axes = plane.axes(note, named=not in_narrow)
    inside = "".join(parts) + labels.draw(hills.levels) + axes + "".join(above)
    label = "The landscape of E over both joints"
    box, kind = f"0 0 {width} {plane.height:.1f}", narrow.CLASS if in_narrow else ""
    return f'<svg class="vi vi-bowl{kind}" viewBox="{box}" role="img" aria-label="{label}">{inside}</svg>'


def _hills(plane: PosturePlane, found: Landscape | None, labels: Labels) -> Hills:
    """found: None while it is computed."""
    if found is None:
        return Hills((plane.message("computing …"),))
    if np.isnan(found.E).all():
        return Hills((plane.message("nowhere are five points seen in all four images"),))
    grid, lowest = plane.grid(found.axes), plane.place(np.degrees(found.minimum))
    drawn = relief.shading(grid, found.E, plane.box), relief.contours(grid, found.E)
    return Hills(drawn, lowest, relief.level_labels(grid, found.E, labels.bounds, lowest))


def _name(way: Way, plane: PosturePlane, labels: Labels) -> str:
    """Beside where it ends."""
    end = plane.place(way.postures_deg[way.best])
    labels.take_points(end, 6)
    return labels.beside(float(end[0]), float(end[1]), way.name, f"vi-b vi-halo vi-way-{way.role}-words", 12)


def _way(points: NDArray, way: Way) -> str:
    """Cased in paper, so that it reads on any shading; probes are hollow."""
    line, rest = svg.path(points[: way.best + 1]), svg.path(points[way.best :])
    drawn = f'<path class="vi-way vi-way-on vi-way-{way.role}" d="{rest}"/><path class="vi-way-case" d="{line}"/>'
    drawn += f'<path class="vi-way vi-way-{way.role}" d="{line}"/>'
    if len(points) > MOST_DOTS:
        return drawn
    points, probes = points[: way.best + 1], way.probes[: way.best + 1]
    if (~probes).any():
        drawn += f'<path class="vi-way-dots vi-way-{way.role}" d="{svg.dots(points[~probes])}"/>'
    if probes.any():
        drawn += f'<path class="vi-way-probes vi-way-{way.role}" d="{svg.circles(points[probes], 3.4)}"/>'
    return drawn
