"""What claims are worth: over bodies that tell their joints well, barely and not at all, with and without noise.

A body is points drawn anew for each run, on the surface of the robot's links as they are shown. Where surfaces hide
points, those are seen whose normal faces the camera. Markers on both sides of an arm's plane make two postures mirror
images of each other; the same arms with markers between the sides tell how often one arrives without that.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from ...loop.session import Session
from ...loop.settings import Settings
from ...servo.status import ServoStatus
from ...simulation.eyes import ProjectedEyes
from ...simulation.scene import Scene, load_scene
from ..executors.study import Study, each
from . import distances, symmetric
from .bound import bound
from .success import Share
from .surface import SurfaceEyes, surface_points
from .symmetric import MarkedArm

FALSE_DEG, TIMES, COVERED = 1.0, 3.0, 2.0  # off; times the expected error beyond which a claim is false; of coverage
NEAR_DEG = 0.5
LOOKS = 9  # postures a joint, evenly over its range
MOST_MOTIONS, PATIENCE = 300, 5
RIGID = ((4, 5, 6, 7), (2, 3, 4, 5, 6, 7), (0, 1, 2, 3))  # links: forearm and hand, all that moves, all but those
TRIES = 200  # bodies, for one with enough points in sight at both ends


@dataclass(frozen=True)
class Case:
    """points: how many are drawn on the surface, None for the scene's layout; links: sets of links, one of which has
    all the points of a run; hidden: the cosine between its normal and the way to a camera up to
    which a point is hidden, None: all are seen; noise_px and frames as in `Settings`; symmetric: of markers as
    `symmetric.draw` places them on arms of its own, None: points as above; distant: whether each run is in a scene of
    `distances.draw`."""

    name: str
    points: int | None = None
    links: tuple[tuple[int, ...], ...] = ()
    hidden: float | None = None
    noise_px: float = 0.0
    frames: int = 1
    symmetric: bool | None = None
    distant: bool = False


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
    """Of one run: error: of the worst joint at the end, expected: what the learner says of that, degrees, inf or NaN
    if it cannot; ended: whether it came to rest; bound: the Cramér-Rao bound of the worst joint, degrees, of what the
    demonstrator shows, of points that the learner sees of itself anywhere in its range, own images granted without
    noise; inf if that tells some joint nothing."""

    status: ServoStatus
    motions: int
    ended: bool
    error: float
    expected: float
    bound: float = 0.0

    @property
    def tellable(self) -> bool:
        """Whether every joint is told, be it by next to nothing."""
        return bool(np.isfinite(self.bound))

    @property
    def claimed(self) -> bool:
        return self.status.is_claim

    def within(self, times: float) -> bool:
        return self.error <= times * self.expected

    @property
    def false(self) -> bool:
        return self.claimed and self.error > FALSE_DEG and not self.within(TIMES)


@dataclass(frozen=True)
class Outcome:
    """Of a case. tellable: of all runs; within: NEAR_DEG of the demonstrator, of all runs, and of those that are
    `tellable`, None if there are none; claimed, unobservable: shares of all runs; beyond: claims more than
    FALSE_DEG off, falsely: those of them beyond TIMES the expected error as well; covered: claims within COVERED times
    it; unended: runs without an end; stalled: of all runs; claimed_within_bound: of the runs whose `Ending.bound` is
    FALSE_DEG at most, None if there are none. rms_deg, expected_deg: of claims; bound_deg_median: of all runs, inf if
    half of them have joints that nothing tells."""

    case: str
    tellable: Share
    within: Share
    within_tellable: Share | None
    claimed: Share
    unobservable: Share
    beyond: Share | None
    falsely: Share | None
    covered: Share | None
    unended: Share
    motions_median: float
    motions_95: float
    rms_deg: float | None
    expected_deg: float | None
    stalled: Share
    claimed_within_bound: Share | None
    bound_deg_median: float


def run(
    cases: Sequence[Case] = CASES,
    runs: int = 200,
    seed: int = 0,
    workers: int | Study | None = None,
    tell: Callable[[float], None] = lambda share: None,
    rehearsed: int = 0,
) -> list[Outcome]:
    """Every case from the same starts to the same demonstrators. rehearsed: postures in which the learner has watched
    itself before; tell(share done)."""
    tasks = [(case, [seed, k], rehearsed) for case in cases for k in range(runs)]
    found = []
    for ending in each(run_once, tasks, workers):
        found.append(ending)
        tell(len(found) / len(tasks))
    return [outcome(case.name, found[k * runs : (k + 1) * runs]) for k, case in enumerate(cases)]


def run_once(case: Case, seed: list[int], rehearsed: int = 0) -> Ending:
    """With the default transfer and servo."""
    rng = np.random.default_rng(seed)
    marked = None if case.symmetric is None else symmetric.draw(rng, case.symmetric)
    scene = distances.draw(rng) if case.distant else Settings().scene if marked is None else marked.scene
    low, high = np.transpose(load_scene(scene).range_deg)
    demo, start = map(tuple, rng.uniform(low, high, (2, len(low))).tolist())
    fields = {"noise_px": case.noise_px, "frames": case.frames, "seed": int(rng.integers(2**32))}
    if case.distant:
        fields["points"] = distances.POINTS
    settings = Settings.best(scene=scene, demonstrator_deg=demo, start_deg=start, **fields)
    for _ in range(TRIES):
        session = Session(settings, lambda camera, scene, points: _eyes(case, marked, scene, points, rng))
        if session.snapshot.transfer is not None:
            break
    if rehearsed:
        session.calibrate(rehearsed, seed[-1])
        session.reset()
    last = session.run(MOST_MOTIONS, PATIENCE).last
    error = np.degrees(np.abs(last.theta - last.theta_demo).max())
    expected = np.nan if last.expected_error is None else np.degrees(last.expected_error)
    ended = last.motion < MOST_MOTIONS
    return Ending(last.status, last.motion, ended, float(error), float(expected), _bound_deg(session))


def _bound_deg(session: Session) -> float:
    """As `Ending.bound`."""
    last, eyes, scene = session.snapshot, session.eyes, session.scene
    _, shown = eyes.demo_images(last.theta_demo)
    known = np.logical_not(shown.any(1))
    for theta in product(*np.linspace(scene.lower, scene.upper, LOOKS).T):
        if known.all():
            break
        known = known | eyes.own_images(theta)[1].all(-1)
    noise_px = session.settings.noise_px / np.sqrt(session.settings.frames)
    of_a_pixel = bound(session.world, last.theta_demo, 1.0, seen=shown & known[:, None]).max()
    return float(np.degrees(of_a_pixel * noise_px)) if np.isfinite(of_a_pixel) else np.inf


def outcome(name: str, found: Sequence[Ending]) -> Outcome:
    claims = [ending for ending in found if ending.claimed]
    of_claims = lambda said: Share.of(map(said, claims)) if claims else None
    near = lambda endings: Share.of(ending.error <= NEAR_DEG for ending in endings)
    tellable = [ending for ending in found if ending.tellable]
    within_bound = [ending.claimed for ending in found if ending.bound <= FALSE_DEG]
    rms = lambda of: float(np.sqrt(np.mean([of(ending) ** 2 for ending in claims]))) if claims else None
    motions = [ending.motions for ending in found]
    return Outcome(
        name,
        tellable=Share.of(ending.tellable for ending in found),
        within=near(found),
        within_tellable=near(tellable) if tellable else None,
        claimed=Share.of(ending.claimed for ending in found),
        unobservable=Share.of(ending.status == ServoStatus.UNOBSERVABLE for ending in found),
        beyond=of_claims(lambda ending: ending.error > FALSE_DEG),
        falsely=of_claims(lambda ending: ending.false),
        covered=of_claims(lambda ending: ending.within(COVERED)),
        unended=Share.of(not ending.ended for ending in found),
        motions_median=float(np.median(motions)),
        motions_95=float(np.percentile(motions, 95)),
        rms_deg=rms(lambda ending: ending.error),
        expected_deg=rms(lambda ending: ending.expected),
        stalled=Share.of(ending.status == ServoStatus.NO_PROGRESS for ending in found),
        claimed_within_bound=Share.of(within_bound) if within_bound else None,
        bound_deg_median=float(np.median([ending.bound for ending in found])),
    )


def _eyes(case: Case, marked: MarkedArm | None, scene: Scene, points: int, rng: np.random.Generator) -> ProjectedEyes:
    if marked is not None:
        return SurfaceEyes(scene, marked.body, None)
    if case.points is None:
        return ProjectedEyes(scene, points)
    links = case.links[rng.integers(len(case.links))] if case.links else tuple(range(len(scene.posture_deg) + 1))
    body, normals = surface_points(scene.robot, links, case.points, rng)
    return SurfaceEyes(scene, body, None if case.hidden is None else normals, case.hidden or 0.0)
