"""Links on the points of the four images: one element that stays, so that a click survives a moving arm, and a style
that says where each point is."""

from collections.abc import Mapping
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ...estimation.views import FourViews
from .. import svg
from ..images.planes import SIZES, Window, Windows, placed
from ..metrics import LEGEND_SIZE, METRICS_SIZE
from .links import link, sink

MORE, LESS = "M1-4h3v3M-1 4h-3v-3M4-4l-3 3M-4 4l3-3", "M4-1h-3v-3M-4 1h3v3M1-1l3-3M-1 1l-3 3"  # icons, 12 px
HIT, HALO = 12, 11  # px, radii
LEAST = 1.5  # px, radius within which the nearest of crowded points is hit
FIRST_LARGE = 2  # of what can be enlarged, the images follow two panels
PROPOSED = 4.5  # px, radius
NAME = 4  # px from a point's centre down to the foot of its number


def point_links(address: str, count: int, whole: bool) -> str:
    """Over the four images, whole or not. Tab stops at the points of L: those of the other images ask for the same.

    Each point is there twice: in a circle of HIT, and over all of these where it is nearest.
    """
    planes = []
    for k, (view, size) in enumerate(SIZES[whole].items()):
        around = "".join(_link(address, view, i, "vi-around") for i in range(count))
        nearest = "".join(_link(address, view, i, "vi-nearest", stop=view == "L") for i in range(count))
        large = link(address, f"large/{FIRST_LARGE + k}", f"image {view}, large or not", _corners(size[0]))
        planes.append(_drawing(f"vi-at-{view}", size, around + nearest + large))
    construct = link(address, "construction/0", "Build up how the point is recovered", "▸ Build it up <kbd>C</kbd>")
    planes += [f'<p class="vi-how">{construct}</p>']
    planes += [_drawing("vi-legend", LEGEND_SIZE), _drawing("vi-metrics", METRICS_SIZE)]
    kind = f"vi-images{' vi-whole' if whole else ''}"
    return (
        f'<div class="vi-over vi-links"><div class="vi-panel vi-four"><div class="{kind}" role="group"'
        f' aria-label="Points to choose">{"".join(planes)}</div></div></div>{sink()}'
    )


def proposed_marks(views: FourViews, windows: Windows, whole: bool) -> str:
    """Rings over the four images where a single point would be, which nobody has placed yet."""
    images = np.concatenate([views.demo, views.own], 1).reshape(-1, 4, 2).transpose(1, 0, 2)
    places, planes = placed(images, windows[whole], "lrLR"), []
    for view, size in SIZES[whole].items():
        x, y = places["lrLR".index(view), 0].tolist()
        ring = f'<circle class="vi-proposed" cx="{x:.1f}" cy="{y:.1f}" r="{PROPOSED}"/>' if views.usable[0] else ""
        planes.append(_drawing(f"vi-at-{view}", size, ring))
    planes += ['<p class="vi-how"></p>', _drawing("vi-legend", LEGEND_SIZE), _drawing("vi-metrics", METRICS_SIZE)]
    kind = f"vi-images{' vi-whole' if whole else ''}"
    return f'<div class="vi-over"><div class="vi-panel vi-four"><div class="{kind}">{"".join(planes)}</div></div></div>'


def _drawing(kind: str, size: tuple[int, int], inside: str = "") -> str:
    """It lies over the one of the same class, as large as that, and catches nothing but its links."""
    return f'<svg class="vi {kind}" viewBox="0 0 {size[0]} {size[1]}">{inside}</svg>'


def _corners(width: int) -> str:
    """The mark of what can be enlarged, at the top of an image of that width."""
    square = '<rect x="-8" y="-8" width="16" height="16" rx="3"/>'
    return f'<g class="vi-larger" transform="translate({width / 2:g} 10)">{square}<path d="{MORE}"/></g>'


def _link(address: str, view: str, i: int, kind: str, stop: bool = False) -> str:
    name = svg.point_name(i)
    shown = f'<circle class="vi-touched" r="{HALO}"/><text class="vi-b vi-mid" y="{NAME}">{name}</text>'
    inside = f'<g class="vi-at-{view}{i}"><circle class="{kind}" r="{HIT}"/>{shown}</g>'
    return link(address, f"point/{i}", f"point {name}", inside, stop)


def point_places(demo: NDArray, own: NDArray, visible: NDArray, windows: Windows, whole: bool) -> str:
    """A style. demo, own, visible: (N, 4), as `FourViews` has them; what is not visible, cannot be touched."""
    shown = windows[whole]
    rules = _resting_rules(demo.tobytes(), visible[:, :2].tobytes(), (shown["l"], shown["r"]), whole)
    return f"<style>{rules}{_rules(own, visible[:, 2:], shown, whole, 'LR')}</style>"


@lru_cache(64)  # the demonstrator mostly rests while the learner moves
def _resting_rules(demo: bytes, visible: bytes, windows: tuple[Window, Window], whole: bool) -> str:
    points, seen = np.frombuffer(demo).reshape(-1, 4), np.frombuffer(visible, bool).reshape(-1, 2)
    return _rules(points, seen, dict(zip("lr", windows)), whole, "lr")


def _rules(images: NDArray, visible: NDArray, windows: Mapping[str, Window], whole: bool, pair: str) -> str:
    """Of a body's points, (N, 4) px, of which visible, (N, 2), are seen, in a pair of views."""
    points = placed(images.reshape(-1, 2, 2).transpose(1, 0, 2), windows, pair)
    inside = ((points >= 0) & (points <= _SIZES[whole, pair])).all(-1) & visible.T
    numbers, hidden = np.concatenate([points, _free_radii(points, inside)[..., None]], -1), ""
    if not inside.all():
        numbers[~inside] = 0
        hidden = "".join([f".vi-at-{pair[k]}{i}{{display:none}}" for k, i in np.argwhere(~inside).tolist()])
    return svg.filled(_form(len(images), pair), numbers) + hidden


_SIZES = {
    (whole, pair): np.array([sizes[view] for view in pair])[:, None]
    for whole, sizes in SIZES.items()
    for pair in ("lr", "LR")
}


@lru_cache(16)
def _form(count: int, pair: str) -> str:
    """Of the rules of so many points: x, y and r of each in both views. One format is faster than many."""
    rule = ".vi-at-{0}{1}{{transform:translate(%spx,%spx)}}.vi-at-{0}{1} .vi-nearest{{r:%spx}}"
    return "".join(rule.format(view, i) for view in pair for i in range(count))


def _free_radii(points: NDArray, there: NDArray) -> NDArray:
    """(2, N, 2) px → (2, N) px: half the way to the nearest other point that is there, so that no two circles meet."""
    places = points.view(complex)[..., 0]
    apart = np.abs(places[:, :, None] - places[:, None]) + _to_itself(points.shape[1])
    if not there.all():
        apart = np.where(there[:, None], apart, np.inf)
    return np.minimum(np.maximum(apart.min(-1, initial=np.inf) / 2, LEAST), HIT)


@lru_cache(16)
def _to_itself(count: int) -> NDArray:
    """(count, count): no point is its own neighbour."""
    return np.diag(np.full(count, np.inf))
