"""The basin of a transfer and a servo over its landscape: where runs from many starts end, and what they claim."""

import numpy as np
from numpy.typing import NDArray

from ...analysis.convergence import Basin, Place
from ...simulation.scene import Scene
from .. import svg
from ..posture_plane import PosturePlane

SIZE = 4.6  # px, half a mark's
KINDS: dict[Place, str] = {"demonstrator": "there", "smallest E": "lowest", "elsewhere": "astray"}


def draw_basin(scene: Scene, found: Basin) -> str:
    """A mark at each start, by where its run ends, hollow if that does not claim to have arrived; and the figures."""
    plane = PosturePlane(scene)
    places = plane.place(np.degrees(found.starts))
    waiting = places[len(found.endings) :]
    parts = [f'<path class="vi-basin-waiting" d="{svg.dots(waiting)}"/>'] if len(waiting) else []
    for place, ending in zip(places, found.endings):
        if ending.place == "elsewhere":
            end = plane.place(np.degrees(ending.end))
            parts.append(f'<path class="vi-basin-way" d="{svg.segments(place[None], end[None])}"/>')
    for place, ending in zip(places, found.endings):
        hollow = "" if ending.claimed else " vi-basin-hollow"
        parts.append(_mark(ending.place, place, hollow))
    return plane.wrap("".join(parts), "vi-over") + f'<div class="vi-basin">{describe_basin(found)}</div>'


def describe_basin(found: Basin) -> str:
    """How many end where, and how many claim what; HTML."""
    count, made = found.count, len(found.endings)
    if made < len(found.starts):
        return f"{made} of {len(found.starts)} learners have come to rest …"
    shares = (
        f"{_sign('demonstrator')} <b>{count('demonstrator')} of {made}</b> end at the demonstrator",
        f"{_sign('smallest E')} {count('smallest E')} at the smallest E",
        f"{_sign('elsewhere')} {count('elsewhere')} elsewhere",
    )
    claims = sum(count(place, True) for place in KINDS)
    false = count("elsewhere", True)
    falsely = f", <b>{false} of them falsely</b>" if false else ", none of them falsely" if claims else ""
    return f"{', '.join(shares)}. {claims} claim to have arrived (filled){falsely}."


def _mark(where: Place, place: NDArray, more: str = "") -> str:
    x, y = place.tolist()
    classes = f'class="vi-basin-mark vi-basin-{KINDS[where]}{more}"'
    if where == "demonstrator":
        return f'<circle {classes} cx="{x:.1f}" cy="{y:.1f}" r="{SIZE}"/>'
    if where == "smallest E":
        return f'<path {classes} d="M{x:.1f} {y - SIZE - 1:.1f}l{SIZE + 1:g} {2 * SIZE:g}h-{2 * SIZE + 2:g}z"/>'
    return f'<path {classes} d="M{x - SIZE:.1f} {y - SIZE:.1f}h{2 * SIZE:g}v{2 * SIZE:g}h-{2 * SIZE:g}z"/>'


def _sign(where: Place) -> str:
    """A mark within a sentence."""
    return f'<svg viewBox="0 0 14 14" width="13" height="13">{_mark(where, np.full(2, 7.0))}</svg>'
