"""Fig. 10: the transfer found at convergence is frozen, and transfers the demonstrator's motion.

Overlap in the image alone proves nothing. So the errors of joints and hand are reported too, and three controls: all
points followed instead of the hand's, a transfer fitted before convergence, and one fitted in the demonstrator's own
posture, which no learner knows.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...analysis.trajectory import MOTIONS, Imitation, Motion, Trajectory, follow, hand_points
from ...drawing import svg
from ...drawing.plots import Axes, decade_ticks, decades, figure, log10, sentence, style_of
from ...estimation.transfers import FittedTransfer
from ...loop.session import Session
from ...loop.settings import Settings
from ...servo.status import ServoStatus
from ...simulation.scene import Scene
from ..experiment import Tables, joint_columns, stacked
from .common import Claims, Progress, no_progress

CONVERGED, BODY, BEFORE, SAME = "converged", "all points", "before", "same posture"
RUNS = {
    CONVERGED: "the hand's points, transfer as converged",
    BODY: "all points, transfer as converged",
    BEFORE: "the hand's points, transfer fitted before convergence",
    SAME: "the hand's points, transfer fitted in the demonstrator's own posture",
}
NAMES = {CONVERGED: "converged", BODY: "all points", BEFORE: "before", SAME: "same posture"}
MAX_MOTIONS = 3_000  # until the servo must rest
CONVERGENCE_SHARE = 0.3  # of the progress bar

SENTENCE = (
    "The transfer found at convergence is frozen; the demonstrator moves,\nand the learner follows it in its own views."
).split("\n")
TITLES = {CONVERGED: "transfer as converged", BEFORE: "transfer fitted before"}
PANEL, PANEL_TOP, PANEL_BOTTOM = 102, 30, 114  # px
PANELS = ((CONVERGED, (0, 105)), (BEFORE, (217, 322)))  # left ends
PANELS_WIDTH = PANELS[-1][1][-1] + PANEL
PLOT_TOP, PLOT_BOTTOM = 136, 182
MARGIN = 6  # image px around the paths
BARS = (1, 2, 5, 10, 20, 50, 100, 200, 500)  # image px
VERTICES = 80
DEGREES, MILLIMETRES = (0.1, 100.0), (1.0, 1000.0)  # ranges that the axes show at least
MIN_ERROR = 0.01  # in their units: smaller errors are drawn as this


@dataclass(frozen=True)
class Fig10:
    """The result so far."""

    settings: Settings
    joints: tuple[int, ...]
    image: tuple[int, int]
    motion: Motion  # the demonstrator's
    recorded: bool  # the motion, or else it is one of MOTIONS
    motions: int  # of the convergence
    status: ServoStatus  # at its end
    converged: FittedTransfer  # fitted at the end of the convergence
    runs: dict[str, Trajectory]  # by RUNS

    @property
    def claims(self) -> Claims:
        """What the paper says beside the result."""
        claims = Claims(self.settings, "a recorded motion may be as rough as it likes" if self.recorded else "")
        for name, followed in self.runs.items():
            for what, paper, unit, values in (
                ("image", "almost overlap", " px", followed.image_px),
                ("joints", "–", "°", followed.joint_deg),
                ("hand", "–", " mm", 1e3 * followed.hand_m),
            ):
                median = float(np.median(values))
                line = f"Fig. 10: {NAMES[name]}, {what}"
                here = f"median {median:.3g}{unit}, most {values.max():.3g}{unit}"
                if name == CONVERGED:
                    claims.judge(line, paper, here, what, median, f"median ≤ {{:g}}{unit}")
                else:
                    claims.add(line, "–", here)
        if BEFORE in self.runs:
            times = float(np.median(self.runs[BEFORE].hand_m) / np.median(self.runs[CONVERGED].hand_m))
            line = "Fig. 10: before against converged, hand"
            claims.judge(line, "worse", f"{times:.0f} times", "before", times, "≥ {:g} times")
        return claims

    @property
    def tables(self) -> Tables:
        """The numbers."""
        frames, points = [], []
        for name, run in self.runs.items():
            count, number = run.own.shape[:2]
            frame = {"run": name, "frame": np.arange(count), "time_s": np.arange(count) * self.motion.step_s}
            postures = joint_columns(self.joints, "demonstrator", np.degrees(run.theta_demo))
            postures |= joint_columns(self.joints, "learner", np.degrees(run.theta))
            errors = {"joint_deg": run.joint_deg, "hand_mm": 1e3 * run.hand_m}
            images = {"image_px": run.image_px, "target_px": run.target_px}
            frames.append({**frame, **postures, **errors, **images})
            for k, view in enumerate(("own_left", "own_right")):
                row = {"run": name, "frame": np.repeat(np.arange(count), number), "view": view}
                row |= {"point": np.tile(np.arange(number), count), "followed": np.tile(run.followed, count)}
                for what in ("own", "target", "desired"):
                    xy = getattr(run, what)[:, :, 2 * k : 2 * k + 2].reshape(-1, 2)
                    row |= {f"{what}_x_px": xy[:, 0], f"{what}_y_px": xy[:, 1]}
                points.append(row)
        return {"frames": stacked(frames), "points": stacked(points)}


def run(
    settings: Settings,
    progress: Progress = no_progress,
    motion: str | Motion = "sinusoid",
    max_motions: int = MAX_MOTIONS,
) -> Fig10:
    """Converge, and imitate a motion with each frozen transfer of RUNS.

    motion: a name of MOTIONS, or a motion of this scene. Raises ValueError if too few points are seen to fit a
    transfer.
    """
    session = Session(settings)
    first = session.snapshot
    each = lambda now: progress(CONVERGENCE_SHARE * now.motion / max_motions, None)
    last = session.run(max_motions, patience=1, each=each).last
    there = session.observe(last.theta_demo, last)
    recorded = not isinstance(motion, str)
    played = MOTIONS[motion](session.world, last.theta_demo) if isinstance(motion, str) else motion
    hand, everything = hand_points(session), np.ones(len(last.views.own), bool)
    asked = {CONVERGED: (last, hand), BODY: (last, everything), BEFORE: (first, hand), SAME: (there, hand)}
    if last.transfer is None or any(moment.transfer is None for moment, __ in asked.values()):
        raise ValueError("too few points are seen in all four images to fit a transfer")
    scene = session.scene
    made = (session.settings, scene.moving_joints, scene.head.image, played, recorded, last.motion, last.status)
    found = Fig10(*made, last.transfer, {})
    for k, (name, (moment, followed)) in enumerate(asked.items()):
        low, high = CONVERGENCE_SHARE + (1 - CONVERGENCE_SHARE) * np.array([k, k + 1]) / len(asked)
        assert moment.transfer is not None  # checked above
        part = lambda done, low=low, high=high: progress(low + done * (high - low), None)
        run = follow(session, moment.transfer, played, followed, part)
        found = replace(found, runs={**found.runs, name: run})
        progress(float(high), found)
    return found


def imitation(found: Fig10) -> Imitation:
    """Return the imitation with the converged transfer, to be played back."""
    run = found.runs[CONVERGED]
    made = found.settings, found.converged, found.motion.step_s
    return Imitation(f"Fig. 10: {found.motion.name}", *made, run.theta_demo, run.theta)


def draw(scene: Scene, found: Fig10 | None = None) -> str:
    """Draw a whole or partial result: paths in the learner's views beside the true ones, and errors over time."""
    runs = found.runs if found else {}
    parts = [_panels(runs), _errors(found), _legend()]
    if found is None:
        return figure(None, "".join(parts) + sentence(SENTENCE, 212, 66))
    return figure(found.settings, "".join(parts), found.motion.name)


def _panels(runs: dict[str, Trajectory]) -> str:
    parts = []
    for name, lefts in PANELS:
        parts.append(svg.text(lefts[0], PANEL_TOP - 6, TITLES[name], "vi-b"))
        drawn = _pair(runs[name]) if name in runs else ("", "")
        parts += [_panel(left, view, inside) for left, view, inside in zip(lefts, "LR", drawn)]
    note = svg.text(PANELS_WIDTH, PANEL_TOP - 6, "dashed = true", "vi-of-demo vi-end")
    return "".join(parts) + note


def _panel(left: float, name: str, inside: str) -> str:
    size = f'width="{PANEL}" height="{PANEL_BOTTOM - PANEL_TOP}"'
    return (
        f'<svg x="{left}" y="{PANEL_TOP}" {size}><rect class="vi-plane" x=".5" y=".5" width="{PANEL - 1}"'
        f' height="{PANEL_BOTTOM - PANEL_TOP - 1}" rx="4"/>{inside}{svg.text(6, 15, name, "vi-name vi-halo")}</svg>'
    )


def _pair(run: Trajectory) -> list[str]:
    """Draw L and R to one scale, with a scale bar."""
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
    """Draw each followed point: the learner's path solid, the true one dashed, and the ends of both."""
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
    """Followed points in [L] or [R], (T, n, 2) px."""
    return images[:, run.followed, 2 * k : 2 * k + 2]


def _errors(found: Fig10 | None) -> str:
    """Plot the largest joint error and the distance of the hands over time, for all runs."""
    runs = found.runs if found else {}
    seconds, step_s = (found.motion.seconds, found.motion.step_s) if found else (6.0, 0.0)
    plots = (
        ("Joints off by", "°", 34, 200, DEGREES, {name: run.joint_deg for name, run in runs.items()}),
        ("Hand off by", "mm", 256, 422, MILLIMETRES, {name: 1e3 * run.hand_m for name, run in runs.items()}),
    )
    parts = []
    for title, unit, left, right, least, values in plots:
        values = {name: np.maximum(errors, MIN_ERROR) for name, errors in values.items()}
        y = decades(np.concatenate([*values.values(), np.empty(0)]), *least)
        plot = Axes(left, PLOT_TOP, right, PLOT_BOTTOM, (0.0, max(seconds, 1e-3)), y, up=log10)
        ticks = [(time, f"{time:g}") for time in (0, float(f"{seconds / 2:.1g}"))]
        parts.append(plot.frame(title, f"{unit}, log", ticks, decade_ticks(*y, 3)))
        parts.append(svg.text(right, PLOT_BOTTOM + 13, f"{seconds:.3g} s", "vi-2nd vi-end"))
        for name, errors in reversed(values.items()):
            kept = svg.thinned(len(errors), VERTICES)
            time = step_s * np.array(kept)
            parts.append(plot.line(time, errors[kept], style_of(name, RUNS).line))
    return "".join(parts)


def _legend() -> str:
    parts = []
    for k, name in enumerate(RUNS):
        x = (0, 106, 202, 296)[k % 4]
        parts.append(style_of(name, RUNS).sample(x, 206) + svg.text(x + 27, 210, NAMES[name], "vi-2nd"))
    return "".join(parts)
