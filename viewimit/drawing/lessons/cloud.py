"""Where E was least, time for time, under noise: clouds of postures about the demonstrator's, and how wide they are."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .. import svg
from ..plots import Axes, linear_ticks
from ..theme import OBSERVED
from . import narrow

SIZE = (640, 470)  # units
BOX = (66, 44, 624, 412)  # units: left, top, right, bottom of the plot
NARROW, NARROW_BOX = (narrow.WIDTH, 372), (46, 26, 356, 300)
ROOM = 1.06  # of the posture that is farthest
LAYERS = ("one", "averaged", "spread")
NAME_X = 10  # units from the left, of the names of clouds


@dataclass(frozen=True)
class Cloud:
    """layer: of LAYERS, by which it is shown; name: in words; postures_deg: (k, 2)."""

    layer: str
    name: str
    postures_deg: NDArray

    @property
    def spread_deg(self) -> NDArray:
        """(2,) standard deviations."""
        return self.postures_deg.std(0)


def draw_cloud(
    joints: Sequence[str],
    theta_demo: NDArray,
    clouds: Sequence[Cloud],
    layers: Collection[str],
    note: str,
    in_narrow: bool = False,
) -> str:
    """HTML. joints: names of the one drawn upwards and of the one drawn to the right; theta_demo: (2,) rad; clouds:
    none while they are computed; note: above, at the right, or below in a narrow one."""
    demo = np.degrees(theta_demo)
    size, box = (NARROW, NARROW_BOX) if in_narrow else (SIZE, BOX)
    plot = _axes(demo, clouds, box)
    shown = [cloud for cloud in clouds if cloud.layer in layers]
    left, top, right, bottom = box
    ticks = [(value, f"{words}°") for value, words in linear_ticks(*plot.x, 5 if in_narrow else 8)]
    frame = f'<rect class="vi-plane" x="{left}" y="{top}" width="{right - left}" height="{bottom - top}"/>'
    parts = [frame, plot.beside([(value, f"{words}°") for value, words in linear_ticks(*plot.y, 6)], 7)]
    parts.append(plot.below(ticks, 17))
    parts.append(svg.text((left + right) / 2, bottom + 38, joints[1], "vi-b vi-mid vi-line-words"))
    parts.append(svg.text(left - 4, top - 10, joints[0], "vi-b vi-line-words"))
    at = (right, bottom + 62) if in_narrow else (right, top - 10)
    parts.append(svg.text(*at, note, "vi-2nd vi-end" if in_narrow else "vi-2nd vi-end vi-line-words"))
    if not clouds:
        parts.append(svg.text((left + right) / 2, (top + bottom) / 2 - 30, "computing …", "vi-2nd vi-mid"))
    for cloud in shown:
        points = plot.place(cloud.postures_deg[:, 1], cloud.postures_deg[:, 0])
        parts.append(f'<path class="vi-cloud vi-cloud-{cloud.layer}" d="{svg.dots(points)}"/>')
    for row, cloud in enumerate(shown):
        y = top + 22 + 20 * row
        x = left + NAME_X
        dot = f'<path class="vi-cloud vi-cloud-{cloud.layer} vi-cloud-key" d="M{x} {y - 4.5:.1f}h0"/>'
        parts.append(dot + svg.text(x + 12, y, cloud.name, "vi-b vi-halo vi-line-words"))
    if "spread" in layers:
        parts += [_spread(plot, joints, cloud, row) for row, cloud in enumerate(shown)]
    middle = plot.place(demo[1:], demo[:1])[0]
    parts.append(f'<path class="vi-seen" d="{svg.diamonds(middle[None], OBSERVED + 3)}"/>')
    x, y = middle.tolist()
    if not shown:
        parts.append(svg.text(x, y + 24, "where the demonstrator stands", "vi-halo vi-line-words vi-mid"))
    label = f"Where E is least under noise: {joints[0]} upwards, {joints[1]} to the right"
    kind, view_box = narrow.CLASS if in_narrow else "", f"0 0 {size[0]} {size[1]}"
    return (
        f'<svg class="vi vi-clouds{kind}" viewBox="{view_box}" role="img" aria-label="{label}">{"".join(parts)}</svg>'
    )


def _axes(demo: NDArray, clouds: Sequence[Cloud], box: tuple[float, float, float, float]) -> Axes:
    """One scale for both, wide enough for all clouds, shown or not. demo: (2,) degrees."""
    left, top, right, bottom = box
    most = [np.abs(cloud.postures_deg - demo).max(0) for cloud in clouds]
    up, across = ROOM * np.max(most, 0) if most else (10.0, 10.0)
    per_unit = max(2 * up / (bottom - top), 2 * across / (right - left), 1e-9)
    half_x, half_y = per_unit * (right - left) / 2, per_unit * (bottom - top) / 2
    return Axes(box, (demo[1] - half_x, demo[1] + half_x), (demo[0] - half_y, demo[0] + half_y))


def _spread(plot: Axes, joints: Sequence[str], cloud: Cloud, row: int) -> str:
    """A bracket at the right and one below, a standard deviation to either side of the middle, with degrees."""
    right, bottom = plot.right, plot.bottom
    middle, spread = cloud.postures_deg.mean(0), cloud.spread_deg
    x, y = right - 24 - 108 * row, bottom - 22 - 26 * row
    low, high = (float(plot.y_px(middle[0] + sign * spread[0])) for sign in (-1, 1))
    first, last = (float(plot.x_px(middle[1] + sign * spread[1])) for sign in (-1, 1))
    lines = f"M{x} {low:.1f}V{high:.1f}M{x - 6} {low:.1f}h12M{x - 6} {high:.1f}h12"
    lines += f"M{first:.1f} {y}H{last:.1f}M{first:.1f} {y - 6}v12M{last:.1f} {y - 6}v12"
    kind = f"vi-cloud-words-{cloud.layer} vi-b vi-halo vi-line-words"
    words = svg.text(x - 10, (low + high) / 2 + 4.5, f"± {svg.number(spread[0], 1)}°", f"{kind} vi-end")
    words += svg.text(last + 10, y + 4.5, f"± {svg.number(spread[1], 1)}°", kind)
    return f'<path class="vi-cloud-bracket vi-cloud-{cloud.layer}" d="{lines}"/>{words}'
