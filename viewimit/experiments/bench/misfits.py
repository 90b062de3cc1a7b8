"""Misfits: a demonstrator or an arm that is not as the method assumes. Does the learner say so, and say why?

Each run draws its own misfit. The learner sees 16 points in 25 frames with 0.25 px of noise, so 0.05 px in their mean.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from ...loop.session import Session
from ...loop.settings import Setting, Settings
from ...loop.simulated_robot import SimulatedRobot
from ...servo import MisfitKind
from ...simulation.arms import MasslessArm
from ...simulation.camera import Cameras, StereoHead
from ...simulation.disturbances import ActuatorSettings
from ...simulation.eyes import ProjectedEyes, SimulatedEyes
from ...simulation.robot import Angles, BodyPoints, Robot
from ...simulation.scene import Scene
from ...simulation.world import World
from ..experiment import write_csv
from .benchmark import (
    PATIENCE,
    CaseOptions,
    Context,
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
from .bound import bound
from .calibration import N_SIGMA_COVERED
from .draws import draw_postures

NOISE: dict[str, Any] = dict(noise_px=0.25, frames=25, points=16)
MAX_MOTIONS = 80
MEDIAN_OF_TWO = 1.0518  # median of the larger of two |x|, x standard normal: Φ(x) = (1 + √½) / 2
POINT_M, LINK_POINTS_M = (0.008, 0.020), 0.010  # displacement of one point; standard deviation of each of a link's
MIXED_UP = 3, 6  # points, from and below
FOCAL, BASELINE, CENTRE_PX = (0.85, 1.15), (0.8, 1.2), 30.0  # of another head, relative to the own one
LENS_K1 = 0.03, 0.06  # of both cameras, negative
SHORT = 0.1, 0.3  # share of a motion by which an arm stops short
SEVEN, SEVEN_OFFSET_DEG = tuple(range(1, 8)), 30.0
SEVERAL = 5  # postures of a demonstrator

Rng = np.random.Generator
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Case:
    """A misfit."""

    name: str
    word: MisfitKind | None  # that is right; None for none
    eyes: Callable[[Rng, Scene, int], SimulatedEyes]
    joints: tuple[int, ...] | None = None  # that move; None: those of the scene
    offset_deg: float | None = None  # as of `draw_postures`
    has_other_links: bool = False  # whether the bound of another body holds
    postures: int = 1  # of the demonstrator, one after the other; the last one counts
    stops_short: bool = False  # whether the arm does


class OtherDemonstrator(ProjectedEyes):
    """Eyes that see another demonstrator than the scene's: of another world, mirrored, or with its points mixed up."""

    def __init__(
        self,
        scene: Scene,
        points: int,
        robot: Robot | None = None,
        body: BodyPoints | None = None,
        cameras: Cameras | None = None,
        mirrored: bool = False,
        order: NDArray[np.int_] | None = None,
    ):
        super().__init__(scene, points)
        self.other = World(scene, points, robot, body)
        self._cameras, self._mirrored, self._order = cameras or self.other.demo_pair, mirrored, order

    def demo_images(self, theta: Angles) -> tuple[NDArray, NDArray]:
        T = self.other.T_world_demo
        points = self.other.points_world(theta, T)
        if self._mirrored:
            points = (points - T[:3, 3]) @ T[:3, :3] * (1, -1, 1) @ T[:3, :3].T + T[:3, 3]
        images, visible = self._cameras.project(points)
        found = np.concatenate(list(images), 1), visible.T
        return found if self._order is None else (found[0][self._order], found[1][self._order])


class StopsShort(MasslessArm):
    """An arm that stops short of every commanded posture, by a share of the motion."""

    def __init__(self, scene: Scene, share: float):
        super().__init__(scene)
        self._share = share

    def drive(self, settings: ActuatorSettings, theta: Floats, sent: Floats, commanded: Floats) -> Floats:
        return np.asarray(theta + (1 - self._share) * (commanded - theta))


def stretched(scene: Scene, robot: Robot, stretch: Floats) -> Robot:
    """Return a robot whose moving joints are attached farther out, by (m,) shares; points stay where they are."""
    chain, frames = robot.with_fixed_joints(np.radians(scene.posture_deg), scene.moving)
    joints = list(robot.joints)
    for joint, kept, share in zip(scene.moving, chain.joints, stretch):
        T = kept.T_parent_joint.copy()
        T[:3, 3] *= 1 + share
        joints[joint] = replace(joints[joint], T_parent_joint=np.linalg.inv(frames.T_chain_link[joint]) @ T)
    return replace(robot, joints=tuple(joints))


def _every_link(share: float, rng: Rng, scene: Scene, points: int) -> SimulatedEyes:
    """Each joint, moving or not, is attached farther or nearer by a share of its own."""
    robot, joints = World(scene, points).robot, []
    for joint in robot.joints:
        T = joint.T_parent_joint.copy()
        T[:3, 3] *= 1 + rng.uniform(-share, share)
        joints.append(replace(joint, T_parent_joint=T))
    return OtherDemonstrator(scene, points, replace(robot, joints=tuple(joints)))


def _clean(rng: Rng, scene: Scene, points: int) -> SimulatedEyes:
    return ProjectedEyes(scene, points)


def _moving_joints(share: float, rng: Rng, scene: Scene, points: int) -> SimulatedEyes:
    robot = World(scene, points).robot
    stretch = rng.uniform(-share, share, len(scene.moving))
    return OtherDemonstrator(scene, points, stretched(scene, robot, stretch))


def _moved(body: BodyPoints, index: NDArray, offsets: Floats) -> BodyPoints:
    local = body.local.copy()
    local[index] += offsets
    return BodyPoints(body.link, local)


def _point(rng: Rng, scene: Scene, points: int) -> SimulatedEyes:
    body, offset = World(scene, points).body, rng.normal(size=3)
    offset *= rng.uniform(*POINT_M) / np.linalg.norm(offset)
    return OtherDemonstrator(scene, points, body=_moved(body, rng.integers(len(body), size=1), offset))


def _link_points(rng: Rng, scene: Scene, points: int) -> SimulatedEyes:
    body = World(scene, points).body
    rigid = np.searchsorted(np.array(scene.moving) + 1, body.link, side="right")  # groups of links that move as one
    index = np.flatnonzero(rigid == rng.integers(len(scene.moving) + 1))
    return OtherDemonstrator(scene, points, body=_moved(body, index, LINK_POINTS_M * rng.normal(size=(len(index), 3))))


def _mixed_up(rng: Rng, scene: Scene, points: int) -> SimulatedEyes:
    order = np.arange(len(World(scene, points).body))
    some = rng.permutation(len(order))[: rng.integers(*MIXED_UP)]
    order[some] = order[np.roll(some, 1)]
    return OtherDemonstrator(scene, points, order=order)


def _other_head(rng: Rng, scene: Scene, points: int) -> SimulatedEyes:
    head, zoom, wider = scene.stereo_head(), rng.uniform(*FOCAL), rng.uniform(*BASELINE)
    shift = rng.uniform(-CENTRE_PX, CENTRE_PX)
    left, right = (
        replace(
            lens, focal=(zoom * lens.focal[0], zoom * lens.focal[1]), centre=(lens.centre[0] + shift, lens.centre[1])
        )
        for lens in (head.left, head.right)
    )
    other = StereoHead(
        head.position, wider * head.baseline_m, head.width, head.height, left, right, head.verged, head.toe_in
    )
    return OtherDemonstrator(scene, points, cameras=Cameras(other.gaze(scene.head.gaze_demonstrator)))


def _mirrored(rng: Rng, scene: Scene, points: int) -> SimulatedEyes:
    return OtherDemonstrator(scene, points, mirrored=True)


def _lens(rng: Rng, scene: Scene, points: int) -> SimulatedEyes:
    bend = (-rng.uniform(*LENS_K1), 0.0)
    left, right = (msgspec.structs.replace(eye, distortion=bend) for eye in (scene.head.left, scene.head.right))
    head = msgspec.structs.replace(scene.head, left=left, right=right)
    return ProjectedEyes(msgspec.structs.replace(scene, head=head), points)


def _links_cases(also: str, postures: int) -> tuple[Case, ...]:
    """Cases of moving joints attached farther or nearer, with `also` after their names; all else stays in place."""
    word, few, more = MisfitKind.ANOTHER_BODY, partial(_moving_joints, 0.05), partial(_moving_joints, 0.1)
    return (
        Case(f"moving joints ±5%{also}", word, few, has_other_links=True, postures=postures),
        Case(f"moving joints ±10%{also}", word, more, has_other_links=True, postures=postures),
        Case(f"moving joints ±5%, seven joints{also}", word, few, SEVEN, SEVEN_OFFSET_DEG, True, postures),
    )


CASES = (
    Case("none", None, _clean),
    *_links_cases("", 1),
    *_links_cases(", five postures", SEVERAL),
    *(Case(f"every link ±{share:.0%}", MisfitKind.ANOTHER_BODY, partial(_every_link, share)) for share in (0.05, 0.1)),
    Case("one point elsewhere", MisfitKind.POINT, _point),
    Case("points of one link elsewhere", MisfitKind.LINK_POINTS, _link_points),
    Case("three to five points mixed up", MisfitKind.MIXED_UP, _mixed_up),
    Case("two heads", MisfitKind.TWO_HEADS, _other_head),
    Case("mirrored", MisfitKind.MIRRORED, _mirrored),
    Case("a lens bends the images", MisfitKind.LENS, _lens),
    Case("arm stops short", MisfitKind.ARM, _clean, stops_short=True),
)


@dataclass(frozen=True)
class Row:
    """One run."""

    case: str
    word: str  # of the learner; "" for none
    right: bool  # whether it is the right one
    claimed: bool
    error_deg: float  # of the worst joint
    expected_deg: float  # by the learner
    bound_deg: float  # Cramér-Rao bound of the worst joint for another body; NaN in other cases
    motions: int  # to imitate the last posture

    @property
    def noticed(self) -> bool:
        """Whether the learner takes the demonstrator for another body, or claims nothing."""
        return bool(self.word) or not self.claimed

    @property
    def false(self) -> bool:
        """Whether it is a false claim."""
        return self.claimed and is_false(self.error_deg, self.expected_deg)


@dataclass(frozen=True)
class Outcome:
    """The runs of one case. Shares of an empty set are None."""

    case: str
    noticed: Share  # of all runs
    right: Share | None  # of those that are noticed
    words: dict[str, int]  # how often each was said
    claimed: Share
    false: Share  # claims by `is_false`, of all runs
    covered: Share | None  # within N_SIGMA_COVERED expected errors, of claims
    error_deg: float  # median
    over_bound: float | None  # median error over the median of an estimate with the bound's standard deviation
    motions: float  # median


@dataclass(frozen=True, kw_only=True)
class MisfitsBenchmark(RunOptions, CaseOptions):
    """Misfits: whether the learner notices that a body, a head or an arm is not as assumed, and names the reason."""

    csv: Annotated[Path | None, Setting(description="file that keeps every run, a row each", unit="file")] = None
    cases = CASES

    def run(self, context: Context) -> tuple[Any, str]:
        """See `Benchmark.run`."""
        cases = self.chosen_cases()
        rows = run(cases, self.runs, self.seed, context)
        if self.csv:
            every = [row for of_case in rows for row in of_case]
            with option("--csv"):
                columns = {name: np.array([getattr(row, name) for row in every]) for name in Row.__annotations__}
                write_csv(self.csv, columns)
        found = [outcome(case, of_case) for case, of_case in zip(cases, rows)]
        heading = f"{self.runs} random runs a case in {Settings().scene}, seed {self.seed}"
        return as_json(found), f"{heading}\n{misfits_table(found)}"


def run(cases: Sequence[Case], runs: int, seed: int, context: Context | None = None) -> list[list[Row]]:
    """Run every case `runs` times."""
    tasks = [[(case.name, [seed, k]) for k in range(runs)] for case in cases]
    return run_cases(run_once, tasks, context, "misfits")


def run_once(name: str, seed: list[int]) -> Row:
    """Run the case of this name once."""
    case, rng = next(case for case in CASES if case.name == name), np.random.default_rng(seed)
    settings = Settings(joints=case.joints, **NOISE)
    scene = Session(settings).scene
    postures: dict[str, Any] = dict(draw_postures(scene, rng, case.offset_deg))
    settings = Settings(joints=case.joints, seed=int(rng.integers(2**32)), **NOISE, **postures)
    session = Session(settings, open_eyes=lambda camera, scene, points: case.eyes(rng, scene, points))
    if case.stops_short and isinstance(session.embodiment, SimulatedRobot):
        session.embodiment.arm = StopsShort(session.scene, float(rng.uniform(*SHORT)))
    last, before = session.run(MAX_MOTIONS, PATIENCE).last, 0
    earlier: list[Floats] = []
    for _ in range(1, case.postures):
        earlier, before = [*earlier, last.theta_demo], last.motion
        demonstrator_deg = draw_postures(scene, rng, case.offset_deg)["demonstrator_deg"]
        session.pose(np.radians(demonstrator_deg))
        last = session.run(before + MAX_MOTIONS, PATIENCE).last
    least = np.nan
    if case.has_other_links:
        noise_px = session.settings.noise_px / np.sqrt(session.settings.frames)
        visited = [moment.theta for moment in session.history]
        of_joints = bound(session.world, last.theta_demo, noise_px, visited, another_body=True, earlier=earlier)
        least = float(np.degrees(of_joints.max()))
    word = None if last.misfit is None else last.misfit.kind
    said = "" if word is None else str(word)
    return Row(
        name,
        said,
        word == case.word,
        last.status.is_claim,
        error_deg(last),
        expected_deg(last),
        least,
        last.motion - before,
    )


def outcome(case: Case, rows: Sequence[Row]) -> Outcome:
    """Count the runs of one case."""
    noticed, claims = [row for row in rows if row.noticed], [row for row in rows if row.claimed]
    share = lambda happened: Share.of(happened) if happened else None
    over = [row.error_deg / row.bound_deg for row in rows if np.isfinite(row.bound_deg)]
    return Outcome(
        case.name,
        Share.of(row.noticed for row in rows),
        share([row.right for row in noticed]),
        dict(Counter(row.word for row in rows if row.word)),
        Share.of(row.claimed for row in rows),
        Share.of(row.false for row in rows),
        share([row.error_deg <= N_SIGMA_COVERED * row.expected_deg for row in claims]),
        float(np.median([row.error_deg for row in rows])),
        float(np.median(over)) / MEDIAN_OF_TWO if over else None,
        float(np.median([row.motions for row in rows])),
    )


def misfits_table(outcomes: Sequence[Outcome]) -> str:
    """Lay out the outcomes for people, a row for each case."""
    columns = [
        *(("noticed", 18), ("word right", 18), ("claimed", 18), ("false", 16), ("within 2 exp.", 18), ("error", 8)),
        *(("/ bound", 9), ("motions", 9)),
    ]
    rows = [
        (
            o.case,
            (
                *(o.noticed, o.right, o.claimed, o.false, o.covered, f"{o.error_deg:.2f}°"),
                *(None if o.over_bound is None else f"{o.over_bound:.2f}", f"{o.motions:.0f}"),
            ),
        )
        for o in outcomes
    ]
    return table(columns, rows)
