"""Fig. 9: joint angles with the demonstrator's as broken lines, and E, over the motions; a row a law."""

import numpy as np
from matplotlib.figure import Figure

from ..paper.fig9 import WITHIN_DEG, Fig9, Run
from .style import DASHED, DEMONSTRATOR, angle_name, in_degrees, of_servo

JOINT_COLOURS = ("#0072b2", "#b0508a", "#007f5c", "#d55e00", "#56b4e9", "#8a5a00", "#1b2430")


def figures(found: Fig9) -> dict[str, Figure]:
    laws = list(dict.fromkeys(run.law for run in found.runs))
    figure = Figure(figsize=(9.6, 2.7 * max(len(laws), 1)), layout="constrained")
    plots = figure.subplots(max(len(laws), 1), 2, squeeze=False)
    for (left, right), law in zip(plots, laws):
        first, *others = found.of(law)
        _angles(left, found, first, others)
        _conflict(right, found, first, others)
    figure.suptitle(f"From {in_degrees(found.starts_deg[0])}; faint: from {len(found.starts_deg) - 1} other starts")
    return {"": figure}


def _angles(axes, found: Fig9, first: Run, others: list[Run]) -> None:
    for k, (joint, colour) in enumerate(zip(found.joints, JOINT_COLOURS)):
        for run in others:
            axes.plot(run.theta_deg[:, k], color=colour, alpha=0.2, linewidth=0.8)
        axes.plot(first.theta_deg[:, k], color=colour, label=f"{angle_name(joint)}, learner")
        axes.axhline(first.demonstrator_deg[k], color=DEMONSTRATOR, linestyle=DASHED, linewidth=1)
    axes.set(xlabel="motions", ylabel="joint angles (°)")
    axes.set_title(f"{of_servo(first.law)[0]}: {_arrival(first)}")
    axes.legend(fontsize=7, loc="center right")


def _conflict(axes, found: Fig9, first: Run, others: list[Run]) -> None:
    colour = of_servo(first.law)[1]
    for run in others:
        axes.plot(run.E, color=colour, alpha=0.2, linewidth=0.8)
    axes.plot(first.E, color=colour, label="E")
    motions = np.flatnonzero(first.probe)
    axes.plot(motions, first.E[motions], "o", color=colour, markerfacecolor="white", markersize=4)
    if found.E_demo > 0:
        axes.axhline(found.E_demo, color=DEMONSTRATOR, linestyle=DASHED, linewidth=1)
    axes.set(xlabel="motions", ylabel="E (px²)", yscale="log")
    axes.set_title("broken line: E in the demonstrator's posture")


def _arrival(run: Run) -> str:
    counts = [run.motions_until(within) for within in WITHIN_DEG]
    if counts[0] is None:
        return f"not within {WITHIN_DEG[0]:g}° in {len(run.E) - 1} motions"
    told = [
        f"{within:g}° after {count}" if count is not None else f"{within:g}° never"
        for within, count in zip(WITHIN_DEG, counts)
    ]
    return "within " + ", ".join(told)
