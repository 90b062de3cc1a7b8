"""Whether a method converges with any robot: every URDF of a folder, in the scene that is made for it."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar

import msgspec
import numpy as np

from ...loop.session import Session
from ...loop.settings import Setting, Settings
from ...simulation.scene import Scene, load_scene
from ...simulation.urdf.chain import find_arm
from ...simulation.urdf.reference import parse_reference
from ...simulation.urdf.tree import read_tree
from .benchmark import WITHIN_DEG, Context, MaxMotions, MethodOptions, RunOptions, as_json, error_deg, option

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
