"""Fig. 8: E over the grid of postures, a panel a transfer, and how many points the four pictures share."""

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from ..paper.fig8 import PAPER_MINIMUM_DEG, Fig8
from .style import MARK, RESIDUAL, angle_name, in_degrees, of_transfer


def figures(found: Fig8) -> dict[str, Figure]:
    names = [*found.surfaces]
    figure = Figure(figsize=(9.6, 1.6 + 2.6 * -(-(len(names) + 1) // 2)), layout="constrained")
    plots = figure.subplots(-(-(len(names) + 1) // 2), 2, squeeze=False).ravel()
    for axes, name in zip(plots, names):
        _surface(axes, found, name)
    _usable(plots[len(names)], found)
    for axes in plots[len(names) + 1 :]:
        axes.set_axis_off()
    where = in_degrees(found.demonstrator_deg)
    figure.suptitle(f"E of detected points over {found.usable.size} postures, demonstrator at {where}")
    return {"": figure}


def _surface(axes, found: Fig8, name: str) -> None:
    surface = found.surfaces[name]
    first, second = (np.degrees(axis) for axis in surface.landscape.axes)
    E = surface.landscape.E
    norm = LogNorm(max(np.nanmin(E), 1e-6), np.nanmax(E))
    shading = axes.pcolormesh(second, first, E, cmap="cividis", norm=norm, shading="nearest")
    axes.figure.colorbar(shading, label="E (px²)")
    axes.plot(*found.demonstrator_deg[::-1], label="demonstrator", markersize=8, **MARK)
    lowest = np.degrees(surface.landscape.minimum)
    axes.plot(lowest[1], lowest[0], "+", color=RESIDUAL, markersize=11, markeredgewidth=2, label="smallest E")
    paper = PAPER_MINIMUM_DEG[::-1]
    axes.plot(*paper, "x", color="white", markersize=8, markeredgewidth=2, label="minimum in the paper")
    axes.set(title=of_transfer(name)[0], xlabel=f"{angle_name(found.joints[1])} (°)")
    axes.set_ylabel(f"{angle_name(found.joints[0])} (°)")
    axes.grid(False)
    axes.legend(fontsize=7, facecolor="#8f9aa8", frameon=True, framealpha=0.8)


def _usable(axes, found: Fig8) -> None:
    first, second = (np.degrees(axis) for axis in next(iter(found.surfaces.values())).landscape.axes)
    shading = axes.pcolormesh(second, first, found.usable, cmap="cividis", shading="nearest")
    axes.figure.colorbar(shading, label="points")
    axes.set(title="points seen in all four pictures", xlabel=f"{angle_name(found.joints[1])} (°)")
    axes.set_ylabel(f"{angle_name(found.joints[0])} (°)")
    axes.grid(False)
