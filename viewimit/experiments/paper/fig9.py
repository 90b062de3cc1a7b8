"""Fig. 9: posture imitation by the paper's law with its own and with retuned constants, beside another servo."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import msgspec
import numpy as np
from numpy.typing import NDArray

from ...loop.session import Session
from ...loop.settings import Settings, given
from ...loop.snapshot import Snapshot
from ...servo.status import ServoStatus
from ..experiment import Tables, joint_columns, stacked
from .claims import TOLERANCES, Claims

PAPERS_LAWS, BESIDE = ("gradient", "gradient-retuned"), "broyden"
MOTIONS = 3_000
STARTS = (2, 3)  # a joint of two, spread evenly over its range, besides the scene's own
OFFSET_DEG = 30.0  # of each start from the demonstrator if other than two joints move
PICTURE_LAWS, PICTURE_MOTIONS, PICTURE_STARTS = (*PAPERS_LAWS, BESIDE, "trust-region"), 300, (1, 2)
WITHIN_DEG = (3.0, 1.0)
MARGIN = 1 / 6  # of a joint's range that is left free at both ends


@dataclass(frozen=True)
class Run:
    """One run. theta_deg: (T, m), E: (T,) px²; probe: (T,) bool; status: as it ended."""

    law: str
    start_deg: tuple[float, ...]
    demonstrator_deg: tuple[float, ...]
    theta_deg: NDArray
    E: NDArray
    probe: NDArray
    status: ServoStatus

    @property
    def error_deg(self) -> NDArray:
        """(T,) largest joint error against the demonstrator"""
        return np.abs(self.theta_deg - self.demonstrator_deg).max(-1)

    def motions_until(self, within_deg: float) -> int | None:
        """After how many motions it first was that near; None if never."""
        near = np.flatnonzero(self.error_deg <= within_deg)
        return int(near[0]) if len(near) else None


@dataclass(frozen=True)
class Fig9:
    """runs: of each law from each start, the scene's own start first. E_demo: px², in the demonstrator's posture."""

    settings: Settings
    joints: tuple[int, ...]
    starts_deg: tuple[tuple[float, ...], ...]
    E_demo: float
    runs: tuple[Run, ...]

    @property
    def near_deg(self) -> float:
        """Within which of the demonstrator a run counts as arrived."""
        return Claims(self.settings).limit("near") or TOLERANCES["near"].value

    @property
    def laws(self) -> tuple[str, ...]:
        return laws_of(self.settings)

    def of(self, law: str) -> list[Run]:
        return [run for run in self.runs if run.law == law]

    @property
    def claims(self) -> Claims:
        return _claims(self)

    @property
    def tables(self) -> Tables:
        return _tables(self)


def laws_of(settings: Settings) -> tuple[str, ...]:
    """The paper's two, and the settings' own servo if it is another."""
    return *PAPERS_LAWS, BESIDE if settings.servo in PAPERS_LAWS else settings.servo


def run(
    settings: Settings,
    tell: Callable[[float, Fig9 | None], None] = lambda share, partial: None,
    starts: tuple[int, ...] = STARTS,
    max_motions: int = MOTIONS,
    laws: tuple[str, ...] | None = None,
) -> Fig9:
    """starts: how many a joint of two, besides the settings' own; as many in all, drawn about the demonstrator by the
    settings' seed, if other than two joints move. tell(share done, what is there so far)."""
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

            def tell_now_and_then(moment: Snapshot, done: int = done) -> None:
                if moment.motion % 100 == 0:
                    tell((done + moment.motion / max_motions) / total, None)

            session.run(max_motions, patience=1, each=tell_now_and_then)
            found = replace(found, runs=(*found.runs, _run(session)))
            tell((done + 1) / total, found)
    return found


def on_pictures(settings: Settings, tell: Callable[[float, Fig9 | None], None] = lambda share, partial: None) -> Fig9:
    """Fewer starts and motions: two pictures take a tenth of a second. The servos that need few motions run too."""
    return run(settings, tell, PICTURE_STARTS, PICTURE_MOTIONS, PICTURE_LAWS)


def _spread(session: Session, counts: tuple[int, ...]) -> list[tuple[float, ...]]:
    scene = session.scene
    margin = MARGIN * (np.degrees(scene.upper) - np.degrees(scene.lower))
    spread = [np.linspace(low + free, high - free, n) for (low, high), free, n in zip(scene.range_deg, margin, counts)]
    return [tuple(row) for row in np.stack(np.meshgrid(*spread, indexing="ij"), -1).reshape(-1, len(spread)).tolist()]


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


SUBJECTS = {"gradient": "the law as printed", "gradient-retuned": "the law retuned"}


def _claims(found: Fig9) -> Claims:
    """A law that does not come near the demonstrator is not asked for the E at which it gave up."""
    claims = Claims(found.settings)
    near = found.near_deg
    for law in dict.fromkeys(run.law for run in found.runs):
        runs, subject = found.of(law), SUBJECTS.get(law, law)
        counts = [run.motions_until(near) for run in runs]
        reached = [count for count in counts if count is not None]
        motions = f", median {np.median(reached):.0f} motions" if reached else ""
        here, share = f"{len(reached)} of {len(runs)} starts{motions}", len(reached) / len(runs)
        name, form = f"Fig. 9: {law}, came within {near:g}°", "≥ {:.0%} of starts"
        claims.judge(name, "converges", here, "starts", share, form, subject)
        stayed = sum(run.error_deg[-1] <= near for run in runs)
        claims.add(f"Fig. 9: {law}, ended within {near:g}°", "converges", f"{stayed} of {len(runs)} starts")
        name, least = f"Fig. 9: {law}, smallest E", float(runs[0].E.min())
        if reached:
            most = found.E_demo + TOLERANCES["E at rest"].value
            form = f"≤ {most:.3g} px²"
            claims.judge(name, "0", f"{least:.3g} px²", "E at rest", least - found.E_demo, form, f"E of {subject}")
        else:
            claims.add(name, "0", f"{least:.3g} px²")
    return claims


def _tables(found: Fig9) -> Tables:
    motions, arrivals = [], []
    for k, run in enumerate(found.runs):
        theta = joint_columns(found.joints, "theta", run.theta_deg)
        count = np.arange(len(run.E))
        motions.append({"run": k, "law": run.law, "motion": count, **theta, "E_px2": run.E, "probe": run.probe})
        start = joint_columns(found.joints, "start", np.array([run.start_deg]))
        until = {f"motions_to_{near:g}_deg": np.array([_or_nan(run.motions_until(near))]) for near in WITHIN_DEG}
        ended = {"motions": len(run.E) - 1, "error_deg": run.error_deg[-1], "status": run.status}
        arrivals.append({"run": k, "law": run.law, **start, **until, **ended})
    return {"motions": stacked(motions), "arrivals": stacked(arrivals)}


def _or_nan(count: int | None) -> float:
    return np.nan if count is None else float(count)
