"""Whether a method converges in scenes drawn at random, and with the robots of a folder of URDF files.

Results in random scenes stand beside the Cramér-Rao bound.
"""

import math
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Any, ClassVar

import msgspec
import numpy as np
from numpy.typing import NDArray

from ...loop.session import Session
from ...loop.settings import Setting, Settings
from ...simulation.eyes import ProjectedEyes, SimulatedEyes
from ...simulation.scene import Scene, load_scene
from ...simulation.urdf.chain import find_arm
from ...simulation.urdf.reference import parse_reference
from ...simulation.urdf.tree import read_tree
from .benchmark import (
    FALSE_DEG,
    N_SIGMA,
    PATIENCE,
    WITHIN_DEG,
    CaseOptions,
    Context,
    MaxMotions,
    MethodOptions,
    RunOptions,
    Share,
    as_json,
    error_deg,
    expected_deg,
    option,
    rms,
    run_cases,
    shares_within,
    table,
)
from .bound import bound
from .draws import DrawnScene, draw_scene, resize, write_scene

PAIRS_PER_SCENE = 5  # of start and demonstrator


@dataclass(frozen=True)
class Case:
    """A kind of scenes."""

    name: str
    any_head: bool
    changes: dict[str, Any]  # of the settings


NOISY = {"noise_px": 0.25, "frames": 25}
CASES = (
    Case("parallel, equal cameras", False, {}),
    Case("any head, not rectified", True, {"rectify": "off"}),
    Case("any head, rectified", True, {}),
    Case("any head, not rectified, 0.25 px, 25 frames", True, {"rectify": "off", **NOISY}),
    Case("any head, rectified, 0.25 px, 25 frames", True, NOISY),
)


@dataclass(frozen=True)
class Outcome:
    """The runs of one case.

    `at_most` are the shares that an unbiased estimator with normal errors would reach at the bound, from the worst
    joint alone.
    """

    row: str  # name of the case
    runs: int
    ended: dict[float, Share]  # by degrees of the largest joint error
    motions_median: float
    motions_95: float
    motions_most: int
    claimed: Share
    beyond: Share  # claimed, FALSE_DEG off or more
    falsely: Share  # and more than N_SIGMA times what the learner expects
    rms_deg: float  # of all joints' errors
    bound_deg: float  # Cramér-Rao bound of any method by E, with noise-free own images everywhere
    bound_as_seen_deg: float  # the same with the own images that were seen
    bound_one_head_deg: float  # Cramér-Rao bound with one head, with the own images that were seen
    at_most: dict[float, float]  # by degrees, with the first bound
    at_most_as_seen: dict[float, float]  # with the second bound
    at_most_one_head: dict[float, float]  # with the third bound


@dataclass(frozen=True)
class Run:
    """One run."""

    error: NDArray  # (m,) degrees, of all joints
    bound: NDArray  # (m,) degrees
    bound_as_seen: NDArray  # (m,) degrees
    bound_one_head: NDArray  # (m,) degrees
    motions: int
    claimed: bool
    expected: float  # degrees, of the worst joint, inf if the learner says nothing


@dataclass(frozen=True, kw_only=True)
class ScenesBenchmark(RunOptions, MethodOptions, CaseOptions):
    """Random scenes, with parallel cameras and with any head, beside the Cramér-Rao bound."""

    max_motions: MaxMotions = 500
    cases = CASES

    def run(self, context: Context) -> tuple[Any, str]:
        """See `Benchmark.run`."""
        count, cases = math.ceil(self.runs / PAIRS_PER_SCENE), self.chosen_cases()
        settings, pairs = self.method(), PAIRS_PER_SCENE
        found = run(settings, count, pairs, self.seed, self.max_motions, cases, context)
        heading = f"{count} random scenes, {pairs} random starts and demonstrators in each, seed {self.seed}"
        return {"pairs": heading, "rows": as_json(found)}, f"{heading}\n{scenes_table(found)}"


def run(
    settings: Settings,
    scenes: int,
    pairs: int,
    seed: int,
    max_motions: int,
    cases: Sequence[Case] = CASES,
    context: Context | None = None,
) -> list[Outcome]:
    """Run the settings' method in `scenes` scenes for each case, from `pairs` starts in each. See also `run_cases`."""
    tasks = []
    for case in cases:
        changed = msgspec.structs.replace(settings, **case.changes)
        tasks.append([(changed, case.any_head, [seed, k], pairs, max_motions) for k in range(scenes)])
    found = run_cases(run_scene, tasks, context, "scenes")
    return [outcome(case.name, sum(of_case, [])) for case, of_case in zip(cases, found)]


def run_scene(settings: Settings, any_head: bool, seed: list[int], pairs: int, max_motions: int) -> list[Run]:
    """Draw a scene, and run from `pairs` starts to demonstrators in it."""
    rng, runs = np.random.default_rng(seed), []
    drawn = draw_scene(rng, any_head)
    low, high = np.transpose(drawn.scene.range_deg)
    with scene_file(drawn) as path:
        for start, demonstrator in rng.uniform(low, high, (pairs, 2, 2)).tolist():
            changed = msgspec.structs.replace(
                settings,
                scene=path,
                points=drawn.points,
                start_deg=tuple(start),
                demonstrator_deg=tuple(demonstrator),
                seed=int(rng.integers(2**32)) if any_head else settings.seed,
            )
            runs.append(run_once(changed, drawn.size, max_motions))
    return runs


@contextmanager
def scene_file(drawn: DrawnScene) -> Iterator[str]:
    """Write the scene to a temporary file, and yield its path."""
    with tempfile.TemporaryDirectory() as folder:
        yield str(write_scene(drawn.scene, Path(folder), "drawn"))


def run_once(settings: Settings, size: float, max_motions: int) -> Run:
    """Run once, with a learner of this size, and compute all bounds."""
    session = Session(settings, open_eyes=partial(open_resized, size=size))
    last = session.run(max_motions, PATIENCE).last
    bound_of = partial(bound, session.world, last.theta_demo, session.observer.image_noise_std(settings))
    granted = bound_of()
    visited = [moment.theta for moment in session.history]
    as_seen, one_head = (bound_of(visited), bound_of(visited, one_head=True)) if settings.noise_px else [granted] * 2
    error = np.degrees(np.abs(last.theta - last.theta_demo))
    claimed = last.status.is_claim
    in_degrees = map(np.degrees, (granted, as_seen, one_head))
    return Run(error, *in_degrees, last.motion, claimed, expected_deg(last, np.inf))


def open_resized(camera: str, scene: Scene, points: int, size: float) -> SimulatedEyes:
    """Open eyes that see a learner of this size."""
    eyes = ProjectedEyes(scene, points)
    resize(eyes.world, size)
    return eyes


def outcome(name: str, runs: Sequence[Run]) -> Outcome:
    """Count the runs of one case."""
    error, granted, as_seen, one_head, motions, claimed, expected = (
        np.array([getattr(run, field) for run in runs])
        for field in ("error", "bound", "bound_as_seen", "bound_one_head", "motions", "claimed", "expected")
    )
    largest = error.max(1)
    beyond = claimed & (largest > FALSE_DEG)
    return Outcome(
        name,
        len(runs),
        shares_within(largest),
        float(np.median(motions)),
        float(np.percentile(motions, 95)),
        int(motions.max()),
        Share.of(claimed),
        Share.of(beyond),
        Share.of(beyond & (largest > N_SIGMA * expected)),
        rms_deg=rms(error),
        bound_deg=rms(granted),
        bound_as_seen_deg=rms(as_seen),
        bound_one_head_deg=rms(one_head),
        at_most=_at_most(granted.max(1)),
        at_most_as_seen=_at_most(as_seen.max(1)),
        at_most_one_head=_at_most(one_head.max(1)),
    )


def _at_most(worst: NDArray) -> dict[float, float]:
    within = lambda near, std: math.erf(near / (math.sqrt(2) * std)) if std > 0 else 1.0  # of a normal error
    return {near: float(np.mean([within(near, std) for std in worst])) for near in WITHIN_DEG}


def scenes_table(outcomes: Sequence[Outcome]) -> str:
    """Lay out the outcomes for people, a row for each case."""
    columns = [
        *((f"ended ≤{near:g}°", 18) for near in WITHIN_DEG),
        *(("motions", 9), ("95 %", 7), ("most", 7), ("claimed", 18)),
        *((f"off >{FALSE_DEG:g}°", 20), (f"and >{N_SIGMA:g} exp.", 20), ("rms", 10), ("bound by E", 12)),
        *((f"at best ≤{min(WITHIN_DEG):g}°", 16), ("as seen", 10), ("at best", 10), ("one head", 10), ("at best", 10)),
    ]
    rows = []
    for o in outcomes:
        motions = f"{o.motions_median:.0f}", f"{o.motions_95:.0f}", o.motions_most
        cells = *o.ended.values(), *motions, o.claimed, o.beyond.with_tenths, o.falsely.with_tenths, f"{o.rms_deg:.3f}°"
        by_E, seen = (o.bound_deg, o.at_most), (o.bound_as_seen_deg, o.at_most_as_seen)
        for bound_deg, at_most in (by_E, seen, (o.bound_one_head_deg, o.at_most_one_head)):
            cells = *cells, f"{bound_deg:.3f}°", f"{100 * min(at_most.items())[1]:.0f} %"
        rows.append((o.row, cells))
    return table(columns, rows)


NEAR_DEG = min(WITHIN_DEG)


@dataclass(frozen=True)
class Found:
    """The runs of one URDF."""

    file: str
    refused: str | None = None  # why no scene can be made
    chain: tuple[str, str] = ("", "")  # first and last link
    count: int = 0  # joints of the arm
    joints: tuple[str, ...] = ()  # names of those that move
    runs: int = 0
    arrived: int = 0  # runs that ended within NEAR_DEG
    claimed: int = 0
    error_deg: float = np.nan  # the largest joint error of all runs
    motions: float = np.nan  # median

    @property
    def all_arrived(self) -> bool:
        return self.refused is None and self.arrived == self.runs

    def __str__(self) -> str:
        """A line for people."""
        if self.refused is not None:
            return f"refused  {self.file}: {self.refused}"
        verdict = "arrived" if self.all_arrived else "MISSED"
        return (
            f"{verdict:<8} {self.file}: {self.chain[0]} to {self.chain[1]}, {', '.join(self.joints)} of {self.count}; "
            f"{self.arrived} of {self.runs} within {NEAR_DEG:g}°, {self.claimed} claimed, "
            f"at most {self.error_deg:.3g}° off, median {self.motions:g} motions"
        )


@dataclass(frozen=True, kw_only=True)
class RobotsBenchmark(RunOptions, MethodOptions):
    """Every URDF of a folder, in the scene made for it."""

    path: Annotated[Path, Setting(description="folder of URDF files", unit="folder")]
    max_motions: MaxMotions = 500
    distributed: ClassVar[bool] = False

    def run(self, context: Context) -> tuple[Any, str]:
        """See `Benchmark.run`."""
        with option("FOLDER"):
            paths = urdf_files(self.path)
        settings = msgspec.structs.replace(self.method(), frames=Settings().frames)
        found = []
        for path in paths:
            found.append(run_robot(settings, path, self.runs, self.seed, self.max_motions))
            context.show(str(found[-1]))
        usable = [one for one in found if one.refused is None]
        arrived = sum(one.all_arrived for one in usable)
        summary = (
            f"{arrived} of {len(usable)} robots within {NEAR_DEG:g}° in all of {self.runs} runs each, seed "
            f"{self.seed}; {len(found) - len(usable)} refused"
        )
        return {"arrived": arrived, "usable": len(usable), "robots": as_json(found)}, summary


def urdf_files(folder: Path) -> list[Path]:
    """List the URDF files below a folder, in order. Raises ValueError if there is none."""
    if folder.suffix.lower() == ".urdf":
        return [folder]
    found = sorted(path for path in folder.rglob("*") if path.suffix.lower() == ".urdf" and path.is_file())
    if not found:
        raise ValueError(f"{folder}: no .urdf file there")
    return found


def run_robot(settings: Settings, path: Path, runs: int, seed: int, max_motions: int) -> Found:
    """Run from the scene's own start to its demonstrator, and from runs - 1 random pairs over its ranges."""
    try:
        scene = load_scene(path)
        arm = find_arm(read_tree(parse_reference(path).path))
    except ValueError as error:
        return Found(str(path), str(error).removeprefix(f"{path}: "))
    errors, motions, claimed = [], [], 0
    fields = {"scene": str(path), "points": scene.layout_near(settings.points)}
    for start, demonstrator in _pairs(scene, runs, seed):
        session = Session(msgspec.structs.replace(settings, start_deg=start, demonstrator_deg=demonstrator, **fields))
        last = session.run(max_motions).last
        errors.append(error_deg(last))
        motions.append(last.motion)
        claimed += last.status.is_claim
    robot = session.world.robot
    return Found(
        str(path),
        None,
        (arm.base, arm.tip),
        len(robot.joints),
        tuple(robot.joints[joint - 1].name for joint in scene.moving_joints),
        runs,
        sum(error <= NEAR_DEG for error in errors),
        claimed,
        max(errors),
        float(np.median(motions)),
    )


def _pairs(scene: Scene, runs: int, seed: int) -> Iterator[tuple[tuple[float, ...], tuple[float, ...]]]:
    """Starts and demonstrators, degrees."""
    yield scene.start_deg, tuple(np.array(scene.posture_deg)[scene.moving].tolist())
    low, high = np.transpose(scene.range_deg)
    for start, demonstrator in np.random.default_rng(seed).uniform(low, high, (runs - 1, 2, len(low))):
        yield tuple(start.tolist()), tuple(demonstrator.tolist())
