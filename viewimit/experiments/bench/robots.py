"""Whether a method arrives with any robot: every URDF of a folder, in the scene that is made for it alone."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np

from ...loop.session import Session
from ...loop.settings import Settings
from ...simulation.scene import Scene, load_scene
from ...simulation.urdf.chain import find_arm
from ...simulation.urdf.reference import parse_reference
from ...simulation.urdf.tree import read_tree
from .success import WITHIN_DEG

ARRIVED_DEG = min(WITHIN_DEG)


@dataclass(frozen=True)
class Found:
    """Of one URDF. refused: why no scene can be made, else None; chain: its first and last link; joints: names of those
    that move; of the runs, how many ended within ARRIVED_DEG and how many claimed to have arrived; the largest joint
    error of any, degrees, and the median of their motions."""

    file: str
    refused: str | None = None
    chain: tuple[str, str] = ("", "")
    count: int = 0
    joints: tuple[str, ...] = ()
    runs: int = 0
    arrived: int = 0
    claimed: int = 0
    error_deg: float = np.nan
    motions: float = np.nan

    @property
    def all_arrived(self) -> bool:
        return self.refused is None and self.arrived == self.runs


def urdfs(folder: Path) -> list[Path]:
    """Below a folder, in order. Raises ValueError if there is none."""
    if folder.suffix.lower() == ".urdf":
        return [folder]
    found = sorted(path for path in folder.rglob("*") if path.suffix.lower() == ".urdf" and path.is_file())
    if not found:
        raise ValueError(f"{folder}: no .urdf file there")
    return found


def run(
    settings: Settings,
    paths: Sequence[Path],
    runs: int,
    seed: int,
    max_motions: int,
    tell: Callable[[float], None] = lambda share: None,
) -> Iterator[Found]:
    """One after the other: the scene's own start and demonstrator, and runs - 1 random ones over its ranges."""
    for k, path in enumerate(paths):
        yield run_one(settings, path, runs, seed, max_motions)
        tell((k + 1) / len(paths))


def run_one(settings: Settings, path: Path, runs: int, seed: int, max_motions: int) -> Found:
    try:
        scene = load_scene(path)
        reference = parse_reference(path)
        arm = find_arm(read_tree(reference.path))
    except ValueError as error:
        return Found(str(path), str(error).removeprefix(f"{path}: "))
    errors, motions, claimed = [], [], 0
    points = scene.layout_near(settings.points)
    for start, demonstrator in _pairs(scene, runs, seed):
        asked = msgspec.structs.replace(
            settings, scene=str(path), points=points, start_deg=start, demonstrator_deg=demonstrator
        )
        session = Session(asked)
        last = session.run(max_motions).last
        errors.append(float(np.degrees(np.max(np.abs(last.theta - last.theta_demo)))))
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
        sum(error <= ARRIVED_DEG for error in errors),
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
