"""Fig. 10: the learner's trajectory and the true one in the learner's views, and how far off the posture is."""

import numpy as np
from matplotlib.figure import Figure

from ...analysis.trajectory import Trajectory
from ..paper.fig10 import BEFORE, BODY, CONVERGED, RUNS, SAME, Fig10
from .style import DASHED, DEMONSTRATOR, LEARNER, RECOVERED, in_degrees

LINES = {CONVERGED: (LEARNER, "-"), BODY: (RECOVERED, "-."), BEFORE: ("#d55e00", "--"), SAME: (DEMONSTRATOR, ":")}
ROOM_PX = 12


def figures(found: Fig10) -> dict[str, Figure]:
    figure = Figure(figsize=(9.6, 8.0), layout="constrained")
    upper, lower = figure.subfigures(2, 1, height_ratios=(1.25, 1))
    shown = [name for name in (CONVERGED, BEFORE) if name in found.runs]
    plots = upper.subplots(1, 2 * max(len(shown), 1), squeeze=False)[0]
    for name, pair in zip(shown, (plots[:2], plots[2:])):
        for k, axes in enumerate(pair):
            _image(axes, found.runs[name], k, f"[{'LR'[k]}] {name}")
    plots[0].legend(fontsize=7, loc="best")
    _errors(lower.subplots(1, 2), found)
    fitted = in_degrees(found.fitted_deg[CONVERGED])
    figure.suptitle(
        f"{found.motion.name}, {found.settings.transfer} transfer frozen at {fitted}, after {found.motions} motions"
    )
    return {"": figure}


def _image(axes, run: Trajectory, k: int, title: str) -> None:
    """Paths of the points followed in one of the learner's images."""
    view = slice(2 * k, 2 * k + 2)
    names = "learner", "true", "recovered"
    styles = ((LEARNER, "-", 1.6), (DEMONSTRATOR, DASHED, 1.3), (RECOVERED, ":", 1.0))
    for name, (colour, line, width), paths in zip(names, styles, (run.own, run.desired, run.target)):
        for j, point in enumerate(np.flatnonzero(run.wanted)):
            label = name if j == 0 else None
            axes.plot(*paths[:, point, view].T, color=colour, linestyle=line, linewidth=width, label=label)
    both = np.concatenate([run.own, run.desired])[:, run.wanted, view].reshape(-1, 2)
    low, high = both.min(0) - ROOM_PX, both.max(0) + ROOM_PX
    axes.set(xlim=(low[0], high[0]), ylim=(high[1], low[1]), aspect="equal", xlabel="x (px)", title=title)
    if k == 0:
        axes.set_ylabel("y (px)")


def _errors(plots, found: Fig10) -> None:
    for name, run in found.runs.items():
        colour, line = LINES[name]
        seconds = found.motion.step_s * np.arange(len(run.hand_m))
        plots[0].plot(seconds, run.joint_deg, color=colour, linestyle=line, label=RUNS[name])
        plots[1].plot(seconds, 1e3 * run.hand_m, color=colour, linestyle=line)
    plots[0].set(yscale="log", xlabel="time (s)", ylabel="largest joint error (°)")
    plots[1].set(yscale="log", xlabel="time (s)", ylabel="hand off by (mm)")
    plots[0].figure.legend(fontsize=8, loc="outside lower center", ncols=2)
