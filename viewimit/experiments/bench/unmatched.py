"""Points without names: how often the learner finds which of the demonstrator's points is which, and what that costs.

Each run is made twice from the same draw: with the demonstrator's points in an unknown order, and with their names. A
name counts as right, too, if it is of a point within a pixel in both images: noise of a pixel mixes those up.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product
from pathlib import Path
from typing import Annotated, Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from ...loop.session import Session
from ...loop.settings import Setting, Settings
from ...loop.simulated_robot import demo_order
from ...loop.snapshot import Snapshot
from ...servo.status import ServoStatus
from ...simulation.eyes import ProjectedEyes, SimulatedEyes
from ...simulation.robot import Angles
from ...simulation.scene import Scene, load_scene
from ..experiment import write_csv
from .benchmark import (
    PATIENCE,
    WITHIN_DEG,
    CaseOptions,
    Context,
    MaxMotions,
    RunOptions,
    Share,
    as_json,
    error_deg,
    expected_deg,
    is_false,
    option,
    run_cases,
    table,
)
from .draws import draw_marked_arm, draw_postures, draw_scene, resize
from .scenes import scene_file

SAME_PX = 1.0  # distance of two points in both images, up to which their names mean the same
ARRIVED_DEG = min(WITHIN_DEG)
SCENES = "panda", "iiwa", "panda-toed", "panda-verged", "panda-facing"
COUNTS, NOISES_PX = (10, 16, 20), (0.0, 0.1, 0.25)


@dataclass(frozen=True)
class Case:
    """A condition under which runs are made. Counts and noises take turns from run to run."""

    name: str
    points: Sequence[int] = (16,)
    noises_px: Sequence[float] = NOISES_PX
    scene: str = "panda"
    missing: int = 0  # points of the demonstrator that are hidden
    extra: int = 0  # points seen beside it that are not the body's
    any_head: bool = False  # in a new random scene for each run
    symmetric: bool = False  # markers on both sides of an arm's plane


CASES = (
    *(Case(f"{points} points, {noise:g} px", (points,), (noise,)) for points, noise in product(COUNTS, NOISES_PX)),
    Case("one missing", COUNTS, missing=1),
    Case("one extra", COUNTS, extra=1),
    Case("one missing and one extra", COUNTS, missing=1, extra=1),
    Case("two missing", COUNTS, missing=2),
    *(Case(scene, (10,) if scene == "iiwa" else (16,), scene=scene) for scene in SCENES[1:]),
    *(Case(f"any head, {noise:g} px", noises_px=(noise,), any_head=True) for noise in (0.0, 0.25)),
    *(Case(f"symmetric markers, {noise:g} px", noises_px=(noise,), symmetric=True) for noise in (0.0, 0.1)),
)


@dataclass(frozen=True)
class Row:
    """One run, as the CSV has it; `known_` of the run with names."""

    case: str
    run: int
    points: int
    noise_px: float
    nameable: int  # points with a partner
    wrong: int  # wrong names, and partners that were not found
    uncertain: int  # names that the learner calls uncertain
    two_answers: bool  # whether the learner says that there are
    naming_motions: int  # made because no naming explained the images
    E_over_noise: float  # E of the naming over the E that noise explains, NaN without a naming
    status: ServoStatus
    motions: int
    error_deg: float
    expected_deg: float
    known_status: ServoStatus
    known_motions: int
    known_error_deg: float
    known_expected_deg: float

    @property
    def named(self) -> bool:
        """Whether all names are right."""
        return self.wrong == 0

    @property
    def acknowledged(self) -> bool:
        """Whether all names are right, or the learner says that they may not be."""
        return self.named or self.uncertain > 0 or self.two_answers or self.wrong == self.nameable

    @property
    def falsely(self) -> bool:
        """Whether the run ends with a false claim."""
        return self.status.is_claim and is_false(self.error_deg, self.expected_deg)


@dataclass(frozen=True)
class Outcome:
    """The runs of one case."""

    case: str
    runs: int
    named: Share  # all names right
    acknowledged: Share  # or a wrong name called uncertain, two answers reported, or no naming accepted
    arrived: Share  # within ARRIVED_DEG
    known_arrived: Share  # the same with names
    motions_median: float
    motions_95: float
    known_motions_median: float
    known_motions_95: float
    more_motions: Share  # runs that moved because no naming explained the images
    claimed: Share
    known_claimed: Share
    falsely: Share
    two_answers: Share


@dataclass(frozen=True, kw_only=True)
class UnmatchedBenchmark(RunOptions, CaseOptions):
    """Points without names: how often they are found, and whether runs end as with names."""

    max_motions: MaxMotions = 200
    csv: Annotated[Path | None, Setting(description="file that keeps every run, a row each", unit="file")] = None
    cases = CASES

    def run(self, context: Context) -> tuple[Any, str]:
        """See `Benchmark.run`."""
        rows = run(self.chosen_cases(), self.runs, self.seed, self.max_motions, context)
        if self.csv:
            with option("--csv"):
                every = [row for of_case in rows for row in of_case]
                write_csv(
                    self.csv, {name: np.array([getattr(row, name) for row in every]) for name in Row.__annotations__}
                )
        found = [outcome(of_case) for of_case in rows]
        heading = f"{self.runs} random runs a case, each without and with names, seed {self.seed}"
        return as_json(found), f"{heading}\n{unmatched_table(found)}"


def run(
    cases: Sequence[Case] = CASES,
    runs: int = 200,
    seed: int = 0,
    max_motions: int = 200,
    context: Context | None = None,
) -> list[list[Row]]:
    """Run every case from the same draws. See also `run_cases`."""
    tasks = [[(case, k, [seed, k], max_motions) for k in range(runs)] for case in cases]
    return run_cases(run_once, tasks, context, "unmatched")


def run_once(case: Case, number: int, seed: list[int], max_motions: int) -> Row:
    """Run once without names, and once with them."""
    rng = np.random.default_rng(seed)
    cells = list(product(case.points, case.noises_px))
    points, noise_px = cells[number % len(cells)]
    eyes = partial(OtherPoints.open, missing=case.missing, extra=case.extra, seed=seed)
    if not case.any_head:
        fields: dict[str, Any] = {"scene": case.scene, "points": points}
        if case.symmetric:
            arm = draw_marked_arm(rng, symmetric=True)
            body = [(int(link), *place) for link, place in zip(arm.body.link, arm.body.local.tolist())]
            fields = {"scene": arm.scene, "body_points": tuple(body)}
        return _row(case, number, rng, noise_px, max_motions, eyes, fields, load_scene(fields["scene"]))
    drawn = draw_scene(rng, any_head=True)
    eyes = partial(eyes, size=drawn.size)
    with scene_file(drawn) as path:
        fields = {"scene": path, "points": drawn.points}
        return _row(case, number, rng, noise_px, max_motions, eyes, fields, drawn.scene)


def _row(
    case: Case,
    number: int,
    rng: np.random.Generator,
    noise_px: float,
    max_motions: int,
    eyes: Any,
    fields: dict[str, Any],
    scene: Scene,
) -> Row:
    fields |= draw_postures(scene, rng)
    settings = Settings(noise_px=noise_px, seed=int(rng.integers(2**32)), **fields)
    session = Session(msgspec.structs.replace(settings, matched=False), open_eyes=eyes)
    last = session.run(max_motions, PATIENCE).last
    known = Session(settings, open_eyes=eyes).run(max_motions, PATIENCE).last
    naming, state = last.naming, last.servo_state
    nameable, wrong = judge(session, last)
    return Row(
        case=case.name,
        run=number,
        points=len(last.views.own),
        noise_px=noise_px,
        nameable=nameable,
        wrong=wrong,
        uncertain=0 if naming is None else int((~naming.certain & (naming.names >= 0)).sum()),
        two_answers=naming is not None and naming.is_ambiguous,
        naming_motions=state.n_naming_motions,
        E_over_noise=np.nan if naming is None else naming.E / naming.E_noise,
        status=last.status,
        motions=last.motion,
        error_deg=error_deg(last),
        expected_deg=expected_deg(last),
        known_status=known.status,
        known_motions=known.motion,
        known_error_deg=error_deg(known),
        known_expected_deg=expected_deg(known),
    )


def judge(session: Session, last: Snapshot) -> tuple[int, int]:
    """Count the points with a partner, and the wrong names: other points' names, and partners that were not found."""
    images, visible = session.eyes.demo_images(last.theta_demo)
    own_seen = np.asarray(last.views.visible[:, 2:].all(-1))
    order = demo_order(last.settings, len(images))
    partner = np.where(visible.all(-1) & own_seen, np.argsort(order), -1)
    nameable = int((partner >= 0).sum())
    if last.naming is None or not last.naming.accepted:
        return nameable, nameable
    names = last.naming.names
    wrong = names != partner
    for point in np.flatnonzero(wrong & (partner >= 0) & (names >= 0)):
        distance = (images[order[names[point]]] - images[point]).reshape(2, 2)
        wrong[point] = np.linalg.norm(distance, axis=1).max() > SAME_PX
    return nameable, int(wrong[: len(own_seen)].sum())


class OtherPoints(ProjectedEyes):
    """Projected points, of which some of the demonstrator's are hidden, and others are seen that no body has.

    Parameters
    ----------
    scene, points
        As of `ProjectedEyes`.
    missing : int
        Points of the demonstrator that are hidden.
    extra : int
        Points beside it, anywhere in the box around its points. They come after all others, and the learner has none.
    seed : sequence of int
        Of both.
    """

    def __init__(self, scene: Scene, points: int, missing: int = 0, extra: int = 0, seed: Sequence[int] = ()):
        super().__init__(scene, points)
        rng = np.random.default_rng([*seed, 1])
        self._missing = rng.permutation(len(self.world.body))[:missing]
        self._shares: NDArray[np.float64] = rng.random((extra, 3))

    @classmethod
    def open(cls, sensor: str, scene: Scene, points: int, size: float = 1.0, **others: Any) -> SimulatedEyes:
        """Open these eyes for a session, with a learner of this size."""
        eyes = cls(scene, points, **others)
        resize(eyes.world, size)
        return eyes

    def demo_images(self, theta: Angles) -> tuple[NDArray, NDArray]:
        points, visible = super().demo_images(theta)
        visible = visible.copy()
        visible[self._missing] = False
        body = self.world.points_world(theta, self.world.T_world_demo)
        low, high = body.min(0), body.max(0)
        images, seen = self.world.demo_pair.project(low + self._shares * (high - low))
        return np.concatenate([points, np.concatenate(list(images), 1)]), np.concatenate([visible, seen.T])

    def own_images(self, theta: Angles) -> tuple[NDArray, NDArray]:
        points, visible = super().own_images(theta)
        extra = len(self._shares)
        return np.concatenate([points, np.zeros((extra, 4))]), np.concatenate([visible, np.zeros((extra, 2), bool)])


def outcome(rows: Sequence[Row]) -> Outcome:
    """Count the runs of one case."""
    motions, known = (np.array([getattr(row, name) for row in rows]) for name in ("motions", "known_motions"))
    return Outcome(
        case=rows[0].case,
        runs=len(rows),
        named=Share.of(row.named for row in rows),
        acknowledged=Share.of(row.acknowledged for row in rows),
        arrived=Share.of(row.error_deg <= ARRIVED_DEG for row in rows),
        known_arrived=Share.of(row.known_error_deg <= ARRIVED_DEG for row in rows),
        motions_median=float(np.median(motions)),
        motions_95=float(np.percentile(motions, 95)),
        known_motions_median=float(np.median(known)),
        known_motions_95=float(np.percentile(known, 95)),
        more_motions=Share.of(row.naming_motions > 0 for row in rows),
        claimed=Share.of(row.status.is_claim for row in rows),
        known_claimed=Share.of(row.known_status.is_claim for row in rows),
        falsely=Share.of(row.falsely for row in rows),
        two_answers=Share.of(row.two_answers for row in rows),
    )


def unmatched_table(outcomes: Sequence[Outcome]) -> str:
    """Lay out the outcomes for people, a row for each case."""
    columns = [
        *(("all named", 18), ("or says so", 18), (f"ended ≤{ARRIVED_DEG:g}°", 18), ("with names", 18)),
        *(("motions", 9), ("95 %", 6), ("with names", 12), ("95 %", 6), ("more for names", 18)),
        *(("claimed", 18), ("with names", 18), ("falsely", 18), ("two answers", 18)),
    ]
    rows = []
    for o in outcomes:
        ended = o.named.with_tenths, o.acknowledged.with_tenths, o.arrived.with_tenths, o.known_arrived.with_tenths
        motions = (f"{m:.0f}" for m in (o.motions_median, o.motions_95, o.known_motions_median, o.known_motions_95))
        claims = o.claimed, o.known_claimed, o.falsely.with_tenths, o.two_answers
        rows.append((o.case, (*ended, *motions, o.more_motions, *claims)))
    return table(columns, rows, names=28)
