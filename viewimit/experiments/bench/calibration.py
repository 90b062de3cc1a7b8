"""Calibration of claims: whether errors are as small as the learner says.

Each run draws a new body of points on the surface of the robot's links. Where surfaces hide points, those are seen
whose normal faces the camera. Markers on both sides of an arm's plane make two postures mirror images of each other;
markers between the sides, on the same arms, show how often a run converges without that.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from ...loop.session import Session
from ...loop.settings import Settings
from ...servo.status import ServoStatus
from ...simulation.eyes import ProjectedEyes
from ...simulation.scene import Scene, load_scene
from .benchmark import (
    FALSE_DEG,
    N_SIGMA,
    CaseOptions,
    Context,
    Rehearsed,
    RunOptions,
    Share,
    as_json,
    error_deg,
    expected_deg,
    is_false,
    rms,
    run_cases,
    table,
)
from .bound import bound
from .draws import (
    DISTANT_POINTS,
    MAX_BODIES,
    MarkedArm,
    SurfaceEyes,
    draw_distant_scene,
    draw_marked_arm,
    draw_postures,
    surface_points,
)

N_SIGMA_COVERED = 2.0  # standard errors within which a claim is covered
NEAR_DEG = 0.5
GRID_PER_JOINT = 9  # postures in which a learner may see a point of its own, evenly over the range
MAX_MOTIONS, PATIENCE = 300, 5
RIGID = ((4, 5, 6, 7), (2, 3, 4, 5, 6, 7), (0, 1, 2, 3))  # links: forearm and hand, all moving links, the others


@dataclass(frozen=True)
class Case:
    """A family of bodies, and the noise of the images."""

    name: str
    points: int | None = None  # drawn on the surface; None: the scene's layout
    links: tuple[tuple[int, ...], ...] = ()  # sets of links, one of which has all the points of a run
    hidden: float | None = None  # as in `SurfaceEyes`; None: all points are seen
    noise_px: float = 0.0
    frames: int = 1
    symmetric: bool | None = None  # markers as of `draw_marked_arm`; None: points as above
    distant: bool = False  # whether each run has a scene of `draw_distant_scene`


CASES = (
    Case("default scene"),
    Case("16 points on rigid groups of links", 16, RIGID),
    Case("20 points, hidden by surfaces", 20, hidden=0.0),
    Case("40 points, hidden by surfaces", 40, hidden=0.0),
    Case("20 points, hidden beyond the rim", 20, hidden=-0.3),
    Case("5 points", 5),
    *(
        Case(f"noise {noise} px, {frames} frame{'s' if frames > 1 else ''}", noise_px=noise, frames=frames)
        for frames in (25, 1)
        for noise in (0.1, 0.25, 0.5, 1.0)
    ),
    *(
        Case(f"markers {where}, {noise} px", noise_px=noise, frames=25, symmetric=symmetric)
        for where, symmetric in (("on both sides", True), ("between the sides", False))
        for noise in (0.0, 0.05, 0.25)
    ),
    Case("demonstrator at 0.6 to 6 m, baseline 5 to 60 cm, 0.25 px", noise_px=0.25, frames=25, distant=True),
)


@dataclass(frozen=True)
class Ending:
    """The end of one run."""

    status: ServoStatus
    motions: int
    ended: bool  # whether it came to rest
    error: float  # of the worst joint, degrees
    expected: float  # what the learner says of it, inf or NaN if it cannot
    bound: float = 0.0  # Cramér-Rao bound of the worst joint, degrees; inf if a joint is unobservable

    @property
    def observable(self) -> bool:
        """Whether every joint is observable."""
        return bool(np.isfinite(self.bound))

    @property
    def claimed(self) -> bool:
        return self.status.is_claim

    def within(self, n_sigma: float) -> bool:
        """Return whether the error is at most `n_sigma` times the expected one."""
        return self.error <= n_sigma * self.expected

    @property
    def false(self) -> bool:
        return self.claimed and is_false(self.error, self.expected)


@dataclass(frozen=True)
class Outcome:
    """The runs of one case. Shares of an empty set are None."""

    case: str
    observable: Share  # of all runs
    within: Share  # NEAR_DEG of the demonstrator, of all runs
    within_observable: Share | None  # the same, of observable runs
    claimed: Share  # of all runs
    unobservable: Share  # runs that report an unobservable joint, of all
    beyond: Share | None  # FALSE_DEG off, of claims
    falsely: Share | None  # beyond, and off by more than N_SIGMA expected errors, of claims
    covered: Share | None  # within N_SIGMA_COVERED expected errors, of claims
    unended: Share  # of all runs
    motions_median: float
    motions_95: float
    rms_deg: float | None  # of claims
    expected_deg: float | None  # of claims
    no_progress: Share  # of all runs
    claimed_within_bound: Share | None  # of runs whose bound is FALSE_DEG at most
    bound_deg_median: float  # of all runs, inf if half of them have unobservable joints


@dataclass(frozen=True, kw_only=True)
class CalibrationBenchmark(RunOptions, CaseOptions):
    """Calibration of claims: how often runs claim to have converged, how often that is true, and what they expect."""

    rehearsed: Rehearsed = 0
    cases = CASES

    def run(self, context: Context) -> tuple[Any, str]:
        """See `Benchmark.run`."""
        best, cases = Settings(), self.chosen_cases()
        found = run(cases, self.runs, self.seed, context, self.rehearsed)
        method = f"{best.transfer} and {best.servo} in {best.scene}"
        heading = f"{self.runs} random runs a case of {method}, seed {self.seed}"
        if self.rehearsed:
            heading += f", {self.rehearsed} postures rehearsed"
        return as_json(found), f"{heading}\n{calibration_table(found)}"


def run(
    cases: Sequence[Case] = CASES, runs: int = 200, seed: int = 0, context: Context | None = None, rehearsed: int = 0
) -> list[Outcome]:
    """Run every case from the same starts to the same demonstrators.

    rehearsed: postures in which the learner calibrates itself first. See also `run_cases`.
    """
    tasks = [[(case, [seed, k], rehearsed) for k in range(runs)] for case in cases]
    found = run_cases(run_once, tasks, context, "calibration")
    return [outcome(case.name, of_case) for case, of_case in zip(cases, found)]


def run_once(case: Case, seed: list[int], rehearsed: int = 0) -> Ending:
    """Run once, with the default transfer and servo."""
    rng = np.random.default_rng(seed)
    marked = None if case.symmetric is None else draw_marked_arm(rng, case.symmetric)
    scene = draw_distant_scene(rng) if case.distant else Settings().scene if marked is None else marked.scene
    fields: dict[str, Any] = draw_postures(load_scene(scene), rng)
    fields |= {"noise_px": case.noise_px, "frames": case.frames, "seed": int(rng.integers(2**32))}
    if case.distant:
        fields["points"] = DISTANT_POINTS
    settings = Settings.best(scene=scene, **fields)
    for _ in range(MAX_BODIES):
        session = Session(settings, open_eyes=lambda camera, scene, points: _eyes(case, marked, scene, points, rng))
        if session.snapshot.transfer is not None:
            break
    if rehearsed:
        session.calibrate(rehearsed, seed[-1])
        session.reset()
    last = session.run(MAX_MOTIONS, PATIENCE).last
    ended = last.motion < MAX_MOTIONS
    return Ending(last.status, last.motion, ended, error_deg(last), expected_deg(last), _bound_deg(session))


def _bound_deg(session: Session) -> float:
    """The bound of `Ending`, from points that the learner sees of itself anywhere in its range, without noise."""
    last, eyes, scene = session.snapshot, session.eyes, session.scene
    _, shown = eyes.demo_images(last.theta_demo)
    known = np.logical_not(shown.any(1))
    for theta in product(*np.linspace(scene.lower, scene.upper, GRID_PER_JOINT).T):
        if known.all():
            break
        known = known | eyes.own_images(theta)[1].all(-1)
    noise_px = session.settings.noise_px / np.sqrt(session.settings.frames)
    per_px = bound(session.world, last.theta_demo, 1.0, seen=shown & known[:, None]).max()
    return float(np.degrees(per_px * noise_px)) if np.isfinite(per_px) else np.inf


def _eyes(case: Case, marked: MarkedArm | None, scene: Scene, points: int, rng: np.random.Generator) -> ProjectedEyes:
    if marked is not None:
        return SurfaceEyes(scene, marked.body, None)
    if case.points is None:
        return ProjectedEyes(scene, points)
    links = case.links[rng.integers(len(case.links))] if case.links else tuple(range(len(scene.posture_deg) + 1))
    body, normals = surface_points(scene.robot, links, case.points, rng)
    return SurfaceEyes(scene, body, None if case.hidden is None else normals, case.hidden or 0.0)


def outcome(name: str, found: Sequence[Ending]) -> Outcome:
    """Count the runs of one case."""
    share = lambda of, ends: Share.of(map(of, ends)) if ends else None
    claims = [end for end in found if end.claimed]
    near = lambda end: end.error <= NEAR_DEG
    motions = [end.motions for end in found]
    return Outcome(
        name,
        observable=Share.of(end.observable for end in found),
        within=Share.of(map(near, found)),
        within_observable=share(near, [end for end in found if end.observable]),
        claimed=Share.of(end.claimed for end in found),
        unobservable=Share.of(end.status == ServoStatus.UNOBSERVABLE for end in found),
        beyond=share(lambda end: end.error > FALSE_DEG, claims),
        falsely=share(lambda end: end.false, claims),
        covered=share(lambda end: end.within(N_SIGMA_COVERED), claims),
        unended=Share.of(not end.ended for end in found),
        motions_median=float(np.median(motions)),
        motions_95=float(np.percentile(motions, 95)),
        rms_deg=rms([end.error for end in claims]) if claims else None,
        expected_deg=rms([end.expected for end in claims]) if claims else None,
        no_progress=Share.of(end.status == ServoStatus.NO_PROGRESS for end in found),
        claimed_within_bound=share(lambda end: end.claimed, [end for end in found if end.bound <= FALSE_DEG]),
        bound_deg_median=float(np.median([end.bound for end in found])),
    )


def calibration_table(outcomes: Sequence[Outcome]) -> str:
    """Lay out the outcomes for people, a row for each case: shares of runs, motions, and shares of claims."""
    columns = [
        *((f"≤{NEAR_DEG:g}°", 17), ("observable", 17), ("of these", 17), ("claimed", 17)),
        *((f"if bound ≤{FALSE_DEG:g}°", 17), ("unobservable", 15), ("no progress", 15), ("no end", 15)),
        *(("median", 8), ("95 %", 6), (f"off >{FALSE_DEG:g}°", 20), (f"and >{N_SIGMA:g} exp.", 20)),
        *((f"within {N_SIGMA_COVERED:g} exp.", 20), ("rms", 8), ("exp.", 8)),
    ]
    rows = []
    for o in outcomes:
        of_runs = o.within, o.observable, o.within_observable, o.claimed, o.claimed_within_bound
        of_claims = (share and share.with_tenths for share in (o.beyond, o.falsely, o.covered))
        motions = f"{o.motions_median:.0f}", f"{o.motions_95:.0f}"
        errors = (None if deg is None else f"{deg:.2f}°" for deg in (o.rms_deg, o.expected_deg))
        rows.append((o.case, (*of_runs, o.unobservable, o.no_progress, o.unended, *motions, *of_claims, *errors)))
    return table(columns, rows, max(36, *(len(o.case) for o in outcomes)))
