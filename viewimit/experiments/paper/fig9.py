"""Fig. 9: posture imitation by the paper's law, with its own and with retuned constants, beside another servo."""

import math
from dataclasses import dataclass, replace
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from ...drawing import svg
from ...drawing.plots import Axes, Style, decade_ticks, decades, figure, log10, sentence, style_of
from ...loop.session import Session
from ...loop.settings import Settings, given
from ...loop.snapshot import Snapshot
from ...servo import SERVOS
from ...servo.status import ServoStatus
from ...simulation.scene import Scene
from ..experiment import Tables, joint_columns, stacked
from .common import TOLERANCES, Claims, Progress, grid_rows, no_progress

PAPERS_LAWS, BESIDE = ("gradient", "gradient-retuned"), "broyden"
MAX_MOTIONS = 3_000
STARTS = (2, 3)  # for each joint of two, evenly over its range, besides the scene's own
OFFSET_DEG = 30.0  # largest distance of each start from the demonstrator unless two joints move
ON_PICTURES: dict[str, Any] = {  # two pictures take a tenth of a second: fewer starts and motions, but one servo more
    "starts": (1, 2), "max_motions": 300, "laws": (*PAPERS_LAWS, BESIDE, "likelihood"),
}  # fmt: skip
WITHIN_DEG = (3.0, 1.0)
MARGIN = 1 / 6  # of a joint's range that is left free at both ends
SUBJECTS = {"gradient": "the law as printed", "gradient-retuned": "the law retuned"}  # of claims

SENTENCE = (
    "Three laws, seven starts each: which\narrive at the demonstrator's posture,\nand after how many motions?"
).split("\n")
LEFT, RIGHT, LEGEND = 36, 276, 288  # px
ANGLES, CONFLICT = (30, 106), (130, 194)  # px from top to bottom
TICKS = [(motions, str(motions)) for motions in (0, 1, 3, 10, 30, 100, 300, 1000, 3000)]
VERTICES, FAINT_VERTICES = 160, 40
E_RANGE = 1.0, 100.0  # px² that the axis shows at least
MIN_E = 1e-3  # px²: smaller values are drawn as this


@dataclass(frozen=True)
class Run:
    """One run of T snapshots."""

    law: str
    start_deg: tuple[float, ...]
    demonstrator_deg: tuple[float, ...]
    theta_deg: NDArray[np.float64]  # (T, m)
    E: NDArray[np.float64]  # (T,) px²
    probe: NDArray[np.bool_]  # (T,) whether the motion before was a probe
    status: ServoStatus  # at the end

    @property
    def error_deg(self) -> NDArray[np.float64]:
        """(T,) largest joint error against the demonstrator."""
        return np.abs(self.theta_deg - self.demonstrator_deg).max(-1)

    def motions_until(self, within_deg: float) -> int | None:
        """Return the number of motions until it first was that near; None if never."""
        near = np.flatnonzero(self.error_deg <= within_deg)
        return int(near[0]) if len(near) else None


@dataclass(frozen=True)
class Fig9:
    """The result so far."""

    settings: Settings
    joints: tuple[int, ...]
    starts_deg: tuple[tuple[float, ...], ...]  # the scene's own first
    E_demo: float  # px², in the demonstrator's posture
    runs: tuple[Run, ...]  # of each law from each start

    @property
    def near_deg(self) -> float:
        """Largest distance from the demonstrator at which a run counts as arrived."""
        return Claims(self.settings).limit("near") or TOLERANCES["near"].value

    @property
    def laws(self) -> tuple[str, ...]:
        return laws_of(self.settings)

    def of(self, law: str) -> list[Run]:
        """Return the runs of a law."""
        return [run for run in self.runs if run.law == law]

    @property
    def claims(self) -> Claims:
        """What the paper says beside the result. A law that never comes near is not judged by its E."""
        claims = Claims(self.settings)
        near = self.near_deg
        for law in dict.fromkeys(run.law for run in self.runs):
            runs, subject = self.of(law), SUBJECTS.get(law, law)
            counts = [run.motions_until(near) for run in runs]
            reached = [count for count in counts if count is not None]
            here, share = f"{len(reached)} of {len(runs)} starts", len(reached) / len(runs)
            here += f", median {np.median(reached):.0f} steps" if reached else ""
            name, form = f"Fig. 9: {law}, came within {near:g}°", "≥ {:.0%} of starts"
            claims.judge(name, "converges", here, "starts", share, form, subject)
            stayed = sum(run.error_deg[-1] <= near for run in runs)
            claims.add(f"Fig. 9: {law}, ended within {near:g}°", "converges", f"{stayed} of {len(runs)} starts")
            name, least = f"Fig. 9: {law}, smallest E", float(runs[0].E.min())
            if reached:
                form, above = f"≤ {self.E_demo + TOLERANCES['E at rest'].value:.3g} px²", least - self.E_demo
                claims.judge(name, "0", f"{least:.3g} px²", "E at rest", above, form, f"E of {subject}")
            else:
                claims.add(name, "0", f"{least:.3g} px²")
        return claims

    @property
    def tables(self) -> Tables:
        """The numbers."""
        motions, arrivals = [], []
        for k, run in enumerate(self.runs):
            theta = joint_columns(self.joints, "theta", run.theta_deg)
            count = np.arange(len(run.E))
            motions.append({"run": k, "law": run.law, "motion": count, **theta, "E_px2": run.E, "probe": run.probe})
            start = joint_columns(self.joints, "start", np.array([run.start_deg]))
            until = {f"motions_to_{near:g}_deg": np.array([run.motions_until(near)], float) for near in WITHIN_DEG}
            ended = {"motions": len(run.E) - 1, "error_deg": run.error_deg[-1], "status": run.status}
            arrivals.append({"run": k, "law": run.law, **start, **until, **ended})
        return {"motions": stacked(motions), "arrivals": stacked(arrivals)}


def laws_of(settings: Settings) -> tuple[str, ...]:
    """Return the paper's two laws, and the settings' own servo or `BESIDE`."""
    return *PAPERS_LAWS, BESIDE if settings.servo in PAPERS_LAWS else settings.servo


def run(
    settings: Settings,
    progress: Progress = no_progress,
    starts: tuple[int, ...] = STARTS,
    max_motions: int = MAX_MOTIONS,
    laws: tuple[str, ...] | None = None,
) -> Fig9:
    """Run every law from every start.

    starts: for each joint of two, besides the settings' own; for other numbers of joints as many in all, drawn about
    the demonstrator with the settings' seed.
    """
    session = Session(settings)
    settings, laws = session.settings, laws or laws_of(settings)
    truth = session.observe(session.snapshot.theta_demo, session.snapshot)
    start_deg = given(settings.start_deg)
    others = _spread(session, starts) if len(starts) == len(start_deg) else _drawn(session, math.prod(starts))
    starts_deg = (start_deg, *others)
    found = Fig9(settings, session.scene.moving_joints, starts_deg, truth.E, ())
    total = len(starts_deg) * len(laws)
    for start in starts_deg:
        for law in laws:
            done = len(found.runs)
            session.begin(msgspec.structs.replace(settings, servo=law, start_deg=start))

            def report(moment: Snapshot, done: int = done) -> None:
                if moment.motion % 100 == 0:
                    progress((done + moment.motion / max_motions) / total, None)

            session.run(max_motions, patience=1, each=report)
            found = replace(found, runs=(*found.runs, _run(session)))
            progress((done + 1) / total, found)
    return found


def _spread(session: Session, counts: tuple[int, ...]) -> list[tuple[float, ...]]:
    scene = session.scene
    margin = MARGIN * (np.degrees(scene.upper) - np.degrees(scene.lower))
    spread = [np.linspace(low + free, high - free, n) for (low, high), free, n in zip(scene.range_deg, margin, counts)]
    return [tuple(row) for row in grid_rows(*spread).tolist()]


def _drawn(session: Session, count: int) -> list[tuple[float, ...]]:
    low, high = np.transpose(session.scene.range_deg)
    demo = np.array(session.settings.demonstrator_deg)
    offsets = np.random.default_rng(session.settings.seed).uniform(-OFFSET_DEG, OFFSET_DEG, (count, len(demo)))
    return [tuple(row) for row in np.clip(demo + offsets, low, high).tolist()]


def _run(session: Session) -> Run:
    settings, past = session.settings, session.history
    return Run(
        settings.servo,
        given(settings.start_deg),
        given(settings.demonstrator_deg),
        np.degrees([moment.theta for moment in past]),
        np.array([moment.E for moment in past]),
        np.array([moment.probe for moment in past]),
        past[-1].status,
    )


def draw(scene: Scene, found: Fig9 | None = None) -> str:
    """Draw a whole or partial result: joint angles and E over the motions, on a logarithmic axis."""
    angles, conflict = _plots(scene, found)
    parts = [_frames(scene, angles, conflict, found)]
    if found is None:
        return figure(None, "".join(parts) + sentence(SENTENCE, (LEFT + RIGHT) / 2, 68) + _legend(None))
    parts += [angles.level(angle, "vi-line-demo") for angle in found.settings.demonstrator_deg or ()]
    if found.E_demo > 0:
        parts.append(conflict.level(max(found.E_demo, MIN_E), "vi-line-demo"))
    runs = [(k, run) for law in found.laws for k, run in enumerate(found.of(law))]
    near = found.near_deg
    for k, run in sorted(runs, key=lambda ranked: ranked[0] == 0):  # those from the first start lie over the others
        parts.append(_draw_run(angles, conflict, run, bool(run.error_deg[-1] <= near), faint=k > 0))
    parts.append(_values(conflict, [run for k, run in runs if k == 0]))
    return figure(found.settings, "".join(parts) + _legend(found))


def _plots(scene: Scene, found: Fig9 | None) -> tuple[Axes, Axes]:
    low, high = np.min(scene.range_deg), np.max(scene.range_deg)
    E = np.concatenate([run.E for run in found.runs]) if found and found.runs else np.empty(0)
    if found is not None:
        E = np.maximum(np.append(E, found.E_demo), MIN_E)
    x = (0.0, float(max(MAX_MOTIONS, *(len(run.E) - 1 for run in (found.runs if found else ())), 0)))
    return (
        Axes(LEFT, ANGLES[0], RIGHT, ANGLES[1], x, (float(low), float(high)), np.log1p),
        Axes(LEFT, CONFLICT[0], RIGHT, CONFLICT[1], x, decades(E, *E_RANGE), np.log1p, log10),
    )


def _frames(scene: Scene, angles: Axes, conflict: Axes, found: Fig9 | None) -> str:
    names = [svg.joint_symbol(joint) for joint in scene.moving_joints]
    if found and len(names) <= 3:
        names = [f"{name} {svg.number(angle, 0)}°" for name, angle in zip(names, found.settings.demonstrator_deg or ())]
    low, high = angles.y
    degrees = [(angle, svg.number(angle, 0) + "°") for angle in np.arange(90 * np.ceil(low / 90), high + 1, 90)]
    return (
        angles.frame("Joint angles", f"dashed = demonstrator, {', '.join(names)}", (), degrees)
        + conflict.frame("Conflict E", "px², log; dashed = in its posture", TICKS, decade_ticks(*conflict.y, 3))
        + svg.text(RIGHT + 20, CONFLICT[1] + 13, "steps, log", "vi-2nd")
    )


def _draw_run(angles: Axes, conflict: Axes, run: Run, arrived: bool, faint: bool) -> str:
    style = _style(run.law)
    kept = _thinned(len(run.E), FAINT_VERTICES if faint else VERTICES)
    classes = style.line + (" vi-x-faint" if faint else "")
    lines = [(angles, angle) for angle in run.theta_deg.T] + [(conflict, np.maximum(run.E, MIN_E))]
    drawn = "".join(plot.line(kept, values[kept], classes) for plot, values in lines)
    if not faint:
        ends = np.concatenate([plot.place(kept[-1:], values[-1:]) for plot, values in lines])
        drawn += _ends(style, ends, arrived)
    return drawn


def _style(law: str) -> Style:
    """The servo beside the paper's laws has the plainest line."""
    return style_of(law if law in PAPERS_LAWS else BESIDE, (BESIDE, *PAPERS_LAWS[::-1]))


def _ends(style: Style, places: NDArray, good: bool) -> str:
    """Runs that have not arrived end in crosses."""
    if good:
        return style.marks(places)
    places = places[np.isfinite(places).all(-1)]
    form = "M%.1f %.1fm-3.5-3.5l7 7m0-7l-7 7" * len(places)
    return f'<path class="vi-x-off-mark" d="{form % tuple(places.ravel().tolist())}"/>'


def _values(conflict: Axes, runs: list[Run]) -> str:
    """E where the runs ended, beside the plot."""
    ended = sorted(
        (float(conflict.place(0, max(run.E[-1], MIN_E))[1]), k) for k, run in enumerate(runs) if run.E[-1] > 0
    )
    parts, above = [], -np.inf
    for rank, (y, k) in enumerate(ended):
        above = max(min(y, conflict.bottom - 13 * (len(ended) - 1 - rank)), above + 13)
        style, words = _style(runs[k].law), f"E {svg.short_E(runs[k].E[-1], 10)} px²"
        parts.append(svg.text(LEGEND, above, words, f"vi-x-of-{style.role}"))
    return "".join(parts)


def _legend(found: Fig9 | None) -> str:
    """Each law: its line, the number of starts from which it arrived, and how soon; or how far off it ends."""
    parts = []
    for k, law in enumerate(found.laws if found else (*PAPERS_LAWS, BESIDE)):
        y, runs = ANGLES[0] + 4 + 31 * k, found.of(law) if found else []
        parts.append(_style(law).sample(LEGEND, y))
        parts.append(svg.text(LEGEND + 27, y + 4, SERVOS[law].title, "vi-b"))
        for words, classes in [_outcome(runs, found.near_deg)] if found and runs else []:
            parts.append(svg.text(LEGEND + 27, y + 18, words, classes))
    return "".join(parts)


def _outcome(runs: list[Run], near: float) -> tuple[str, str]:
    counts = [run.motions_until(near) for run in runs]
    reached = [count for count in counts if count is not None]
    if not reached:
        off = np.min([run.error_deg[-1] for run in runs])
        return f"0 of {len(runs)}, best {svg.number(off, 0)}° off", "vi-x-off"
    return f"{len(reached)} of {len(runs)}, median {np.median(reached):.0f}", "vi-2nd"


def _thinned(count: int, limit: int) -> NDArray:
    """Motions evenly spaced on the logarithmic axis."""
    return np.unique(np.expm1(np.linspace(0, np.log1p(count - 1), limit)).round().astype(int))
