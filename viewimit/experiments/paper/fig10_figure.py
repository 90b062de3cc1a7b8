"""Fig. 10 on the page: paths in the learner's views beside the true ones, and how far off joints and hand are."""

import numpy as np
from numpy.typing import NDArray

from ...analysis.trajectory import Trajectory
from ...drawing import svg
from ...drawing.plots import Axes, decade_ticks, decades, figure, log10, sentence, style_of
from ...simulation.scene import Scene
from .fig10 import BEFORE, CONVERGED, RUNS, Fig10

SENTENCE = (
    "The transfer found at convergence is frozen; the demonstrator moves,",
    "and the learner follows it in its own views.",
)
TITLES = {CONVERGED: "transfer as converged", BEFORE: "transfer fitted before"}
PANEL, PANEL_TOP, PANEL_BOTTOM = 102, 30, 114  # px
PANELS = ((CONVERGED, (0, 105)), (BEFORE, (217, 322)))  # left ends
LOWER = (136, 182)
MARGIN = 6  # image px around the paths
BARS = (1, 2, 5, 10, 20, 50, 100, 200, 500)  # image px
VERTICES = 80
DEGREES, MILLIMETRES = (0.1, 100.0), (1.0, 1000.0)  # that the axes show in any case
FLOOR = 0.01  # of them, below which errors are drawn as this


def draw(scene: Scene, found: Fig10 | None = None) -> str:
    """found: what is there so far."""
    runs = found.runs if found else {}
    parts = [_panels(runs), _errors(found), _legend()]
    if found is None:
        return figure(None, "".join(parts) + sentence(SENTENCE, 212, 66))
    return figure(found.settings, "".join(parts), f" · {found.motion.name}")


def _panels(runs: dict[str, Trajectory]) -> str:
    parts = []
    for name, lefts in PANELS:
        parts.append(svg.text(lefts[0], PANEL_TOP - 6, TITLES[name], "vi-b"))
        drawn = _pair(runs[name]) if name in runs else ("", "")
        parts += [_panel(left, view, inside) for left, view, inside in zip(lefts, "LR", drawn)]
    note = svg.text(WIDTH_OF_PANELS, PANEL_TOP - 6, "dashed = true", "vi-of-demo vi-end")
    return "".join(parts) + note


WIDTH_OF_PANELS = PANELS[-1][1][-1] + PANEL


def _panel(left: float, name: str, inside: str) -> str:
    size = f'width="{PANEL}" height="{PANEL_BOTTOM - PANEL_TOP}"'
    return (
        f'<svg x="{left}" y="{PANEL_TOP}" {size}><rect class="vi-plane" x=".5" y=".5" width="{PANEL - 1}"'
        f' height="{PANEL_BOTTOM - PANEL_TOP - 1}" rx="4"/>{inside}{svg.text(6, 15, name, "vi-name vi-halo")}</svg>'
    )


def _pair(run: Trajectory) -> list[str]:
    """What L and R show, to one scale, which a bar tells."""
    centres, spans = [], []
    for k in range(2):
        both = np.concatenate([_view(images, run, k).reshape(-1, 2) for images in (run.own, run.desired)])
        both = both[np.isfinite(both).all(-1)]
        low, high = (both.min(0) - MARGIN, both.max(0) + MARGIN) if len(both) else np.array([[0, 0], [1, 1]])
        centres.append((low + high) / 2)
        spans.append(high - low)
    scale = float(min(PANEL / np.max(spans, 0)[0], (PANEL_BOTTOM - PANEL_TOP) / np.max(spans, 0)[1]))
    paths = [_paths(run, k, centres[k], scale) for k in range(2)]
    return [paths[0], paths[1] + _scale_bar(scale)]


def _scale_bar(scale: float) -> str:
    length = max((size for size in BARS if size * scale < PANEL / 3), default=BARS[0])
    x, y = PANEL - 7, PANEL_BOTTOM - PANEL_TOP - 7
    bar = f'<path class="vi-lead" d="M{x - length * scale:.1f} {y}H{x}"/>'
    return bar + svg.text(x, y - 4, f"{length:g} px", "vi-2nd vi-end vi-halo")


def _paths(run: Trajectory, k: int, centre: NDArray, scale: float) -> str:
    """Of each point that is followed: the learner's path solid, the true one broken, and where both end."""
    middle = np.array([PANEL, PANEL_BOTTOM - PANEL_TOP]) / 2
    kept = svg.thinned(len(run.own), VERTICES)
    own, true = (middle + scale * (_view(images, run, k)[kept] - centre) for images in (run.own, run.desired))
    line = lambda paths: "".join(svg.path(path) for path in np.moveaxis(paths, 1, 0))
    end = lambda paths: paths[-1][np.isfinite(paths[-1]).all(-1)]
    return (
        f'<path class="vi-line-own vi-x-thin" d="{line(own)}"/><path class="vi-line-demo" d="{line(true)}"/>'
        f'<path class="vi-seen" d="{svg.diamonds(end(true), 3.4)}"/><path class="vi-dot-own" d="{svg.dots(end(own))}"/>'
    )


def _view(images: NDArray, run: Trajectory, k: int) -> NDArray:
    """(T, n, 2) px of the points followed, in [L] or [R]"""
    return images[:, run.followed, 2 * k : 2 * k + 2]


def _errors(found: Fig10 | None) -> str:
    """Largest joint error and distance of the hands, over the time, for all runs."""
    runs = found.runs if found else {}
    seconds, step_s = (found.motion.seconds, found.motion.step_s) if found else (6.0, 0.0)
    plots = (
        ("Joints off by", "°", 34, 200, DEGREES, {name: run.joint_deg for name, run in runs.items()}),
        ("Hand off by", "mm", 256, 422, MILLIMETRES, {name: 1e3 * run.hand_m for name, run in runs.items()}),
    )
    parts = []
    for title, unit, left, right, least, values in plots:
        values = {name: np.maximum(errors, FLOOR) for name, errors in values.items()}
        y = decades(np.concatenate([*values.values(), np.empty(0)]), *least)
        plot = Axes((left, LOWER[0], right, LOWER[1]), (0.0, max(seconds, 1e-3)), y, up=log10)
        ticks = [(time, f"{time:g}") for time in (0, float(f"{seconds / 2:.1g}"))]
        parts.append(plot.frame(title, f"{unit}, log", ticks, decade_ticks(*y, 3)))
        parts.append(svg.text(right, LOWER[1] + 13, f"{seconds:.3g} s", "vi-2nd vi-end"))
        for name, errors in reversed(values.items()):
            kept = svg.thinned(len(errors), VERTICES)
            time = step_s * np.array(kept)
            parts.append(plot.line(time, errors[kept], style_of(name, RUNS).line))
    return "".join(parts)


def _legend() -> str:
    parts = []
    for k, name in enumerate(RUNS):
        x = (0, 106, 202, 296)[k % 4]
        parts.append(style_of(name, RUNS).sample(x, 206) + svg.text(x + 27, 210, name, "vi-2nd"))
    return "".join(parts)
