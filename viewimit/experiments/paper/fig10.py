"""Fig. 10: the transfer found at convergence is frozen and carries the demonstrator's motion over.

Overlap in the image alone proves nothing: the joints' and the hand's distance from the demonstrator's stand beside it,
and three controls: all points followed instead of the hand's, a transfer fitted before convergence, and one fitted in
the demonstrator's own posture, which no learner knows.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...analysis.trajectory import MOTIONS, Imitation, Motion, Trajectory, follow, hand_points
from ...estimation.transfers import FittedTransfer
from ...loop.session import Session
from ...loop.settings import Settings
from ...servo.status import ServoStatus
from ..experiment import Tables, joint_columns, stacked
from .claims import Claims

CONVERGED, BODY, BEFORE, SAME = "converged", "all points", "before", "same posture"
RUNS = {
    CONVERGED: "the hand's points, transfer as converged",
    BODY: "all points, transfer as converged",
    BEFORE: "the hand's points, transfer fitted before convergence",
    SAME: "the hand's points, transfer fitted in the demonstrator's own posture",
}
MOST_MOTIONS = 3_000  # until the servo must rest
SEEN_SHARE = 0.3  # of the progress bar for the convergence


@dataclass(frozen=True)
class Fig10:
    """motion: the demonstrator's, made up or recorded; motions, status: of the convergence before;
    fitted_deg: postures in which the frozen transfers were fitted; converged: the one that was fitted at the end of the
    convergence; runs: by the names of RUNS."""

    settings: Settings
    joints: tuple[int, ...]
    image: tuple[int, int]
    motion: Motion
    recorded: bool
    motions: int
    status: ServoStatus
    fitted_deg: dict[str, NDArray]
    converged: FittedTransfer
    runs: dict[str, Trajectory]

    @property
    def claims(self) -> Claims:
        return _claims(self)

    @property
    def tables(self) -> Tables:
        return _tables(self)


def run(
    settings: Settings,
    tell: Callable[[float, Fig10 | None], None] = lambda share, partial: None,
    motion: str | Motion = "sinusoid",
    max_motions: int = MOST_MOTIONS,
) -> Fig10:
    """motion: a name of MOTIONS or a motion of this scene. tell(share done, what is there so far).

    Raises ValueError if too few points are seen to fit a transfer.
    """
    session = Session(settings)
    first = session.snapshot
    last = session.run(max_motions, patience=1, each=lambda now: tell(SEEN_SHARE * now.motion / max_motions, None)).last
    there = session.observe(last.theta_demo, last)
    recorded = not isinstance(motion, str)
    played = MOTIONS[motion](session.world, last.theta_demo) if isinstance(motion, str) else motion
    hand, everything = hand_points(session), np.ones(len(last.views.own), bool)
    asked = {CONVERGED: (last, hand), BODY: (last, everything), BEFORE: (first, hand), SAME: (there, hand)}
    if last.transfer is None or any(moment.transfer is None for moment, _ in asked.values()):
        raise ValueError("too few points are seen in all four images to fit a transfer")
    fitted = {name: np.degrees(moment.theta) for name, (moment, _) in asked.items()}
    scene = session.scene
    made = (session.settings, scene.moving_joints, scene.head.image, played, recorded, last.motion, last.status)
    found = Fig10(*made, fitted, last.transfer, {})
    for k, (name, (moment, wanted)) in enumerate(asked.items()):
        share = SEEN_SHARE + (1 - SEEN_SHARE) * np.array([k, k + 1]) / len(asked)
        assert moment.transfer is not None  # checked above
        followed = follow(session, moment.transfer, played, wanted, _within(tell, *share))
        found = replace(found, runs={**found.runs, name: followed})
        tell(float(share[1]), found)
    return found


def imitation(found: Fig10) -> Imitation:
    """By the transfer of the convergence."""
    run = found.runs[CONVERGED]
    made = found.settings, found.converged, found.motion.step_s
    return Imitation(f"Fig. 10: {found.motion.name}", *made, run.theta_demo, run.theta)


def _within(tell: Callable[[float, None], None], low: float, high: float) -> Callable[[float], None]:
    """A part's progress as that of the whole."""
    return lambda share: tell(low + share * (high - low), None)


def _claims(found: Fig10) -> Claims:
    claims = Claims(found.settings, "a recorded motion may be as rough as it likes" if found.recorded else "")
    for name, followed in found.runs.items():
        for what, paper, unit, values in (
            ("image", "almost overlap", " px", followed.image_px),
            ("joints", "–", "°", followed.joint_deg),
            ("hand", "–", " mm", 1e3 * followed.hand_m),
        ):
            median = float(np.median(values))
            here, line = f"median {median:.3g}{unit}, most {values.max():.3g}{unit}", f"Fig. 10: {name}, {what}"
            if name == CONVERGED:
                claims.judge(line, paper, here, what, median, f"median ≤ {{:g}}{unit}")
            else:
                claims.add(line, "–", here)
    if BEFORE in found.runs:
        times = float(np.median(found.runs[BEFORE].hand_m) / np.median(found.runs[CONVERGED].hand_m))
        line = "Fig. 10: before against converged, hand"
        claims.judge(line, "worse", f"{times:.0f} times", "before", times, "≥ {:g} times")
    return claims


def _tables(found: Fig10) -> Tables:
    frames, points = [], []
    for name, run in found.runs.items():
        count, number = run.own.shape[:2]
        frame = np.arange(count)
        postures = joint_columns(found.joints, "demonstrator", np.degrees(run.theta_demo))
        postures |= joint_columns(found.joints, "learner", np.degrees(run.theta))
        errors = {"joint_deg": run.joint_deg, "hand_mm": 1e3 * run.hand_m}
        images = {"image_px": run.image_px, "target_px": run.target_px}
        frames.append(
            {"run": name, "frame": frame, "time_s": frame * found.motion.step_s, **postures, **errors, **images}
        )
        for k, view in enumerate(("own_left", "own_right")):
            row = {
                "run": name,
                "frame": np.repeat(frame, number),
                "view": view,
                "point": np.tile(np.arange(number), count),
            }
            row["followed"] = np.tile(run.followed, count)
            for what in ("own", "target", "desired"):
                xy = getattr(run, what)[:, :, 2 * k : 2 * k + 2].reshape(-1, 2)
                row |= {f"{what}_x_px": xy[:, 0], f"{what}_y_px": xy[:, 1]}
            points.append(row)
    return {"frames": stacked(frames), "points": stacked(points)}
