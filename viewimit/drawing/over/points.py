"""Links on the points of the four images: one element that stays, so that a click survives a moving arm, and a style
that says where each point is."""

import numpy as np
from numpy.typing import NDArray

from .. import svg
from ..image_planes import BOXES, WIDTH, Windows, placed
from ..images import HEIGHT
from .links import link, sink

HIT, HALO = 12, 11  # px, radii
LEAST = 1.5  # px, radius within which the nearest of crowded points is hit
NAME = 4  # px from a point's centre down to the foot of its number


def point_links(address: str, count: int, whole: bool) -> str:
    """Over the four images, whole or not. Tab stops at the points of L: those of the other images ask for the same.

    Each point is there twice: in a circle of HIT, and over all of these where it is nearest.
    """
    planes = []
    for view, (x, y, *_) in BOXES[whole].items():
        around = "".join(_link(address, view, i, "vi-around") for i in range(count))
        nearest = "".join(_link(address, view, i, "vi-nearest", stop=view == "L") for i in range(count))
        planes.append(f'<g transform="translate({x} {y})">{around}{nearest}</g>')
    return (
        f'<div class="vi-over vi-links"><div class="vi-panel"><svg class="vi" viewBox="0 0 {WIDTH} {HEIGHT}"'
        f' role="group" aria-label="Points to choose">{"".join(planes)}</svg></div>{sink()}</div>'
    )


def _link(address: str, view: str, i: int, kind: str, stop: bool = False) -> str:
    name = svg.point_name(i)
    shown = f'<circle class="vi-touched" r="{HALO}"/><text class="vi-b vi-mid" y="{NAME}">{name}</text>'
    inside = f'<g class="vi-at-{view}{i}"><circle class="{kind}" r="{HIT}"/>{shown}</g>'
    return link(address, f"point/{i}", f"point {name}", inside, stop)


def point_places(demo: NDArray, own: NDArray, visible: NDArray, windows: Windows, whole: bool) -> str:
    """A style. demo, own, visible: (N, 4), as `FourViews` has them; what is not visible, cannot be touched."""
    images = np.concatenate([demo, own], 1).reshape(-1, 4, 2).transpose(1, 0, 2)
    points = placed(images, windows[whole], "lrLR")
    boxes = np.array([BOXES[whole][view][2:] for view in "lrLR"])[:, None]
    inside = ((points >= 0) & (points <= boxes)).all(-1) & visible.T
    rules = []
    for k, view in enumerate("lrLR"):
        radii = _free_radii(np.where(inside[k, :, None], points[k], np.inf))
        for i, ((x, y), r) in enumerate(zip(points[k].tolist(), radii.tolist())):
            point = f".vi-at-{view}{i}"
            place = f"transform:translate({x:.1f}px,{y:.1f}px)" if inside[k, i] else "display:none"
            rules.append(f"{point}{{{place}}}")
            if r < HIT:
                rules.append(f"{point} .vi-nearest{{r:{r:.1f}px}}")
    return f"<style>{''.join(rules)}</style>"


def _free_radii(points: NDArray) -> NDArray:
    """(N, 2) px → (N,) px: half the way to the nearest other point, so that no two circles meet; inf: not there."""
    there = np.isfinite(points).all(-1)
    radii = np.full(len(points), float(HIT))
    if there.sum() > 1:
        apart = np.hypot(*(points[there][:, None] - points[there]).T)
        np.fill_diagonal(apart, np.inf)
        radii[there] = np.clip(apart.min(0) / 2, LEAST, HIT)
    return radii
