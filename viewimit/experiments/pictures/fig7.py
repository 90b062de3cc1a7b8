"""Fig. 7: E as a surface, whole and close up, with contours and both minima; its parabola; other demonstrators."""

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ...analysis.convexity import GOOD, Convexity
from ...transfer import TRANSFERS
from ..paper.fig7 import PAPER_MINIMUM_DEG, Fig7, Study, Surface
from .style import DEMONSTRATOR, MARK, RESIDUAL, angle_name, in_degrees, of_transfer

ENLARGED = 5
CLOSE_DEG = 15.0  # half the width of the close-up
LEVELS = (2, 3, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000)


def figures(found: Fig7) -> dict[str, Figure]:
    drawn = {"": _surface(found)}
    if any(surface.convexity for surface in found.surfaces.values()):
        drawn["convexity"] = _convexity(found)
    if found.studies:
        drawn["demonstrators"] = _study(found)
    return drawn


def _surface(found: Fig7) -> Figure:
    transfer = found.settings.transfer
    surface = found.surfaces[transfer]
    first, second = (np.degrees(axis) for axis in surface.landscape.axes)
    E = surface.landscape.E
    centre = np.degrees(surface.minima.theta[0]) if len(surface.minima) else np.array(found.demonstrator_deg)
    near = [
        np.flatnonzero(np.abs(axis - c) <= max(CLOSE_DEG, 1.5 * np.diff(axis).max()))
        for axis, c in zip((first, second), centre)
    ]
    figure = Figure(figsize=(9.6, 8.2), layout="constrained")
    where, by = in_degrees(found.demonstrator_deg), of_transfer(transfer)[0]
    figure.suptitle(f"E over the learner's postures, demonstrator at {where}, {by}")
    parts = (("global view", slice(None), slice(None)), (f"close-up, ±{CLOSE_DEG:g}°", *near))
    for column, (title, rows, columns) in enumerate(parts):
        part = E[rows][:, columns]
        axes = figure.add_subplot(2, 2, 1 + column, projection="3d")
        _relief(axes, first[rows], second[columns], part, found.joints)
        axes.set_title(title)
        _contours(figure.add_subplot(2, 2, 3 + column), first[rows], second[columns], part, found, surface)
    return figure


def _relief(axes, first: NDArray, second: NDArray, E: NDArray, joints: tuple[int, ...]) -> None:
    x, y = np.meshgrid(first, second, indexing="ij")
    every = max(1, len(first) // 45), max(1, len(second) // 45)
    axes.plot_surface(x, y, E, rstride=every[0], cstride=every[1], cmap="cividis", linewidth=0.2, edgecolor="#46566b")
    axes.contour(x, y, E, levels=_levels(E), offset=0, cmap="cividis", linewidths=0.7)
    axes.set(xlabel=f"{angle_name(joints[0])} (°)", ylabel=f"{angle_name(joints[1])} (°)", zlabel="E (px²)")
    axes.view_init(elev=28, azim=-125)


def _contours(axes, first: NDArray, second: NDArray, E: NDArray, found: Fig7, surface: Surface) -> None:
    norm = LogNorm(max(np.nanmin(E), 1e-6), np.nanmax(E))
    shading = axes.pcolormesh(second, first, E, cmap="cividis", norm=norm, shading="nearest", rasterized=True)
    axes.figure.colorbar(shading, label="E (px²)")
    lines = axes.contour(second, first, E, levels=_levels(E), colors="white", linewidths=0.7)
    axes.clabel(lines, fontsize=7)
    axes.plot(*found.demonstrator_deg[::-1], label="demonstrator", markersize=8, **MARK)
    minima = np.degrees(surface.minima.theta)
    inside = [k for k, place in enumerate(minima) if first.min() <= place[0] <= first.max()]
    style = {"marker": "+", "linestyle": "none", "markersize": 11, "markeredgewidth": 2}
    for rank, k in enumerate(inside):
        name = f"smallest E {in_degrees(minima[k])}" if k == 0 else "another minimum" if rank == 1 else None
        axes.plot(minima[k][1], minima[k][0], color=RESIDUAL if k == 0 else "white", label=name, **style)
    axes.plot(
        *PAPER_MINIMUM_DEG[::-1], "x", color="white", markersize=8, markeredgewidth=2, label="minimum in the paper"
    )
    axes.set(xlabel=f"{angle_name(found.joints[1])} (°)", ylabel=f"{angle_name(found.joints[0])} (°)")
    axes.set(xlim=(second.min(), second.max()), ylim=(first.min(), first.max()))
    axes.grid(False)
    axes.legend(fontsize=7, loc="upper right", facecolor="#8f9aa8", frameon=True, framealpha=0.8)


def _levels(E: NDArray) -> list[float]:
    return [level for level in LEVELS if np.nanmin(E) < level < np.nanmax(E)] or [float(np.nanmean(E))]


def _convexity(found: Fig7) -> Figure:
    """E against the parabola of Eq. (11)."""
    figure = Figure(figsize=(9.6, 4.2), layout="constrained")
    first, second = figure.subplots(1, 2)
    surface = found.surfaces[found.settings.transfer]
    if surface.convexity is not None:
        _parabola(first, found, surface, surface.convexity)
    for name, each in found.surfaces.items():
        if each.convexity is not None:
            words, colour = of_transfer(name)
            curved = each.convexity
            second.plot(
                curved.radius_deg, 100 * curved.worst, "-o", color=colour, markersize=3, label=f"{words}, largest"
            )
            second.plot(curved.radius_deg, 100 * curved.error, "--", color=colour, label=f"{words}, median")
    second.axhline(100 * GOOD, color="black", linewidth=0.8, linestyle=":")
    second.set(
        xscale="log", yscale="log", xlabel="distance from the minimum (°)", ylabel="difference from the parabola (%)"
    )
    second.set_title("How far E ≈ δθᵀQδθ holds")
    second.legend(fontsize=8)
    return figure


def _parabola(axes, found: Fig7, surface: Surface, curved: Convexity) -> None:
    """Contours of E, and those of the parabola at the same levels."""
    place, E_min = np.degrees(surface.minima.theta[0]), surface.minima.E[0]
    first, second = (np.degrees(axis) for axis in surface.landscape.axes)
    x, y = np.meshgrid(second - place[1], first - place[0])
    delta = np.stack([y, x], -1)
    parabola = E_min + np.einsum("...i,ij,...j->...", delta, curved.Q, delta)
    levels = [level for level in LEVELS if level > E_min][:6]
    axes.contour(second, first, surface.landscape.E, levels=levels, colors="#0072b2", linewidths=1.2)
    axes.contour(second, first, parabola, levels=levels, colors=DEMONSTRATOR, linewidths=1, linestyles="dashed")
    low, high = curved.eigenvalues
    axes.set_title(
        f"E (solid) and its parabola (dashed) at {', '.join(map(str, levels))} px²\nQ: {low:.4f}, {high:.4f} px²/°²"
    )
    axes.set(xlabel=f"{angle_name(found.joints[1])} (°)", ylabel=f"{angle_name(found.joints[0])} (°)", aspect="equal")


def _study(found: Fig7) -> Figure:
    """Where the minimum is for other demonstrators."""
    rows = -(-len(TRANSFERS) // 2)
    figure = Figure(figsize=(9.6, 0.7 + 2.7 * rows), layout="constrained")
    plots = figure.subplots(rows, 2, sharex=True, sharey=True, squeeze=False)
    for axes, name in zip(plots.flat, TRANSFERS):
        words, colour = of_transfer(name)
        axes.set_title(words)
        if name in found.studies:
            _biases(axes, found.studies[name], colour)
    for axes in plots[:, 0]:
        axes.set_ylabel(f"{angle_name(found.joints[0])} (°)")
    for axes in plots[-1]:
        axes.set_xlabel(f"{angle_name(found.joints[1])} (°)")
    figure.legend(*plots[0, 0].get_legend_handles_labels(), fontsize=8, loc="outside lower center", ncols=2)
    figure.suptitle(f"Bias of E's minimum, drawn {ENLARGED} times longer")
    return figure


def _biases(axes, study: Study, colour: str) -> None:
    place, arrow = study.demonstrator_deg, ENLARGED * study.bias_deg
    axes.plot(place[:, 1], place[:, 0], markersize=5, label="demonstrator", zorder=2, **MARK)
    scale = {"angles": "xy", "scale_units": "xy", "scale": 1, "width": 0.006, "zorder": 3}
    arrows = axes.quiver(place[:, 1], place[:, 0], arrow[:, 1], arrow[:, 0], color=colour, **scale)
    axes.quiverkey(arrows, 0.8, 1.04, 2 * ENLARGED, "bias of 2°", labelpos="E", fontproperties={"size": 8})
    several = study.minima - study.on_limit > 1
    ring = {"marker": "o", "markerfacecolor": "none", "markersize": 12, "linestyle": "none"}
    axes.plot(place[several, 1], place[several, 0], color=RESIDUAL, label="more than one minimum inside", **ring)
    axes.margins(0.06, 0.14)
    axes.set(aspect="equal", axisbelow=True)
