"""Scenes drawn at random about the shipped ones: robot, head, baseline, bases, yaws and body points.

All of them have parallel optical axes, and hold both arms in all four images over the whole range.
"""

import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from ...settings import Settings
from ...simulation.scene import Scene, load_scene
from ...simulation.world import World
from .. import processes
from . import success

ROBOTS = "panda", "iiwa"
HEAD_M, BASE_M, BASELINE_M, YAW_DEG = 0.25, (0.15, 0.15, 0.045), (0.3, 0.8), 45.0
COUNTS = 8, 10, 16  # points
LOW, MIDDLE = 2, 4  # links from the base: at least SPREAD points below, between and beyond these
SPREAD = 2
LOOKS = 64  # postures in which all must be seen


def draw(rng: np.random.Generator) -> tuple[Scene, int]:
    """A scene, and how many points its new layout has. Of those that hold both arms in view."""
    while True:
        scene, points = _drawn(rng)
        if _all_seen(World(scene, points), rng):
            return scene, points


def write(scene: Scene, folder: Path, name: str) -> Path:
    """As a TOML file that `load_scene` reads."""
    head = {key: value for key, value in msgspec.structs.asdict(scene.head).items() if key != "verged"}
    tables = {
        "head": head,
        "demonstrator": msgspec.structs.asdict(scene.demonstrator),
        "learner": msgspec.structs.asdict(scene.learner),
        "points": scene.points,
    }
    lines = [f'extends = "{scene.robot}"', f'title = "{scene.title}"']
    for table, values in tables.items():
        lines += [f"[{table}]", *(f"{key} = {_toml(value)}" for key, value in values.items())]
    path = folder / f"{name}.toml"
    path.write_text("\n".join(lines) + "\n")
    return path


def run(
    settings: Settings,
    scenes: int,
    pairs: int,
    seed: int,
    max_motions: int,
    workers: int | None = None,
    tell: Callable[[float], None] = lambda share: None,
) -> success.Success:
    """The settings' transfer and servo in that many scenes, from that many starts to demonstrators in each."""
    with tempfile.TemporaryDirectory() as folder:
        tasks = []
        for k in range(scenes):
            rng = np.random.default_rng([seed, k])
            scene, points = draw(rng)
            path = write(scene, Path(folder), f"random-{k}")
            asked = msgspec.structs.replace(settings, scene=str(path), points=points)
            tasks += [_task(asked, pair, max_motions) for pair in _pairs(rng, scene, pairs)]
        runs = []
        for found in processes.each(success.run_pair, tasks, workers):
            runs += found
            tell(len(runs) / len(tasks))
    return success.summary(settings.transfer, settings.servo, max_motions, runs)


def _task(settings: Settings, pair: Sequence[list[float]], max_motions: int) -> tuple[Settings, tuple[str, ...], int]:
    start, demonstrator = map(tuple, pair)
    asked = msgspec.structs.replace(settings, start_deg=start, demonstrator_deg=demonstrator)
    return asked, (settings.servo,), max_motions


def _drawn(rng: np.random.Generator) -> tuple[Scene, int]:
    scene = load_scene(str(rng.choice(ROBOTS)))
    known = list(dict.fromkeys(point for layout in scene.points.values() for point in layout))
    points = int(rng.choice([count for count in COUNTS if count <= len(known)]))
    shifts = rng.uniform(-1, 1, (2, 3)) * BASE_M
    yaws = rng.uniform(-YAW_DEG, YAW_DEG, 2)
    bases = {}
    for name, shift, yaw in zip(("demonstrator", "learner"), shifts, yaws):
        base = getattr(scene, name)
        bases[name] = msgspec.structs.replace(base, position=_moved(base.position, shift), yaw_deg=float(yaw))
    head = msgspec.structs.replace(
        scene.head,
        position=_moved(scene.head.position, rng.uniform(-HEAD_M, HEAD_M, 3)),
        baseline=float(rng.uniform(*BASELINE_M)),
        gaze_demonstrator=_moved(scene.head.gaze_demonstrator, shifts[0]),
        gaze_learner=_moved(scene.head.gaze_learner, shifts[1]),
    )
    layouts = {**scene.points, str(points): _layout(known, points, rng)}
    return msgspec.structs.replace(scene, title="random", head=head, points=layouts, **bases), points


def _layout(points: list[tuple], count: int, rng: np.random.Generator) -> tuple[tuple, ...]:
    """That many of the shipped layouts' points, some of them low, some in the middle and some far out."""
    while True:
        chosen = tuple(points[k] for k in sorted(rng.permutation(len(points))[:count]))
        link = np.array([point[0] for point in chosen])
        if min((link < LOW).sum(), ((link >= LOW) & (link < MIDDLE)).sum(), (link >= MIDDLE).sum()) >= SPREAD:
            return chosen


def _all_seen(world: World, rng: np.random.Generator) -> bool:
    theta = rng.uniform(world.scene.lower, world.scene.upper, (LOOKS, len(world.scene.lower))).T
    return bool(world.demo_images(theta)[1].all() and world.own_images(theta)[1].all())


def _pairs(rng: np.random.Generator, scene: Scene, count: int) -> list[list[list[float]]]:
    """Starts and demonstrators, count x 2 x 2 degrees."""
    low, high = np.transpose(scene.range_deg)
    return rng.uniform(low, high, (count, 2, 2)).tolist()


def _moved(position: Sequence[float], shift: NDArray) -> tuple[float, ...]:
    return tuple((np.array(position) + shift).tolist())


def _toml(value) -> str:
    """Numbers, and tuples of them."""
    return f"[{', '.join(map(_toml, value))}]" if isinstance(value, tuple) else repr(value)
