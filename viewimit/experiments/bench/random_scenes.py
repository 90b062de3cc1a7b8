"""Scenes drawn at random about the shipped ones: robot, head, baseline, bases, yaws and body points.

They hold both arms in all four images over the whole range. Heads have two equal, parallel cameras, or any: turned
inwards, with unlike lenses, and a learner of another size.
"""

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from ...session import Session
from ...settings import Settings
from ...simulation.eyes import Eyes, ProjectedEyes
from ...simulation.scene import Eye, Head, Scene, load_scene
from ...simulation.world import World
from .. import processes
from .bound import bound
from .claims import TIMES
from .success import FALSE_DEG, WITHIN_DEG, Share

ROBOTS = "panda", "iiwa"
HEAD_M, BASE_M, BASELINE_M, YAW_DEG = 0.25, (0.15, 0.15, 0.045), (0.3, 0.8), 45.0
COUNTS = 8, 10, 16  # points
LOW, MIDDLE = 2, 4  # links from the base: at least SPREAD points below, between and beyond these
SPREAD = 2
LOOKS = 64  # postures in which all must be seen
ANY_COUNTS, SIZES = (10, 40), (0.8, 1.2)  # of any head's scenes: points, and the learner's size
TOE_IN_DEG, ZOOM, OBLONG, OFFSET_PX = (0.0, 20.0), (0.75, 1.15), (0.9, 1.1), 15.0
PATIENCE = 20  # looks in a row with too few points, after which a learner is given up


@dataclass(frozen=True)
class Drawn:
    """points: of the scene's new layout; size: of the learner, relative to the robot's."""

    scene: Scene
    points: int
    size: float = 1.0


@dataclass(frozen=True)
class Row:
    """any_head: of the scenes; changes: of the settings."""

    name: str
    any_head: bool
    changes: dict


NOISY = {"noise_px": 0.25, "frames": 25}
ROWS = (
    Row("parallel, equal cameras", False, {}),
    Row("any head, not rectified", True, {"rectify": "off"}),
    Row("any head, rectified", True, {}),
    Row("any head, not rectified, 0.25 px, 25 frames", True, {"rectify": "off", **NOISY}),
    Row("any head, rectified, 0.25 px, 25 frames", True, NOISY),
)


@dataclass(frozen=True)
class Outcome:
    """Of a row: shares of runs that ended within so many degrees, largest joint error; rms_deg of all joints' errors,
    beside what the Cramér-Rao bound leaves to them; beyond: claimed, FALSE_DEG off or more; falsely: and more than
    TIMES what the learner itself expects."""

    row: str
    runs: int
    ended: dict[float, Share]
    motions_median: float
    motions_95: float
    claimed: Share
    beyond: Share
    falsely: Share
    rms_deg: float
    bound_deg: float


def draw(rng: np.random.Generator, any_head: bool = False) -> Drawn:
    """Of those that hold both arms in view."""
    while True:
        drawn = _drawn(rng, any_head)
        world = World(drawn.scene, drawn.points)
        resize(world, drawn.size)
        if _all_seen(world, rng):
            return drawn


def resize(world: World, size: float) -> None:
    """Make the learner's arm so many times as large, about its base: its points, not what is drawn of it."""
    world.T_world_own = world.T_world_own @ np.diag([size, size, size, 1.0])


def write(scene: Scene, folder: Path, name: str) -> Path:
    """As a TOML file that `load_scene` reads."""
    head = {key: value for key, value in msgspec.to_builtins(scene.head).items() if value is not None}
    eyes = {f"head.{side}": _said(head.pop(side)) for side in ("left", "right")}
    tables = {
        "head": head,
        **eyes,
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
    rows: Sequence[Row] = ROWS,
    workers: int | None = None,
    tell: Callable[[float], None] = lambda share: None,
) -> list[Outcome]:
    """The settings' transfer and servo in that many scenes a row, from that many starts to demonstrators in each."""
    with tempfile.TemporaryDirectory() as folder:
        kinds = {row.any_head for row in rows}
        drawn = {kind: _tasks(settings, scenes, pairs, seed, kind, Path(folder)) for kind in kinds}
        tasks = [
            (msgspec.structs.replace(asked, **row.changes), size, max_motions)
            for row in rows
            for asked, size in drawn[row.any_head]
        ]
        runs: list[Run] = []
        for found in processes.each(run_once, tasks, workers):
            runs.append(found)
            tell(len(runs) / len(tasks))
    each = scenes * pairs
    return [_outcome(row.name, runs[k * each : (k + 1) * each]) for k, row in enumerate(rows)]


@dataclass(frozen=True)
class Run:
    """error, bound: (m,) degrees, of all joints; motions made; claimed: the servo says that it has converged; expected:
    degrees, what it says of the worst joint's error, inf if nothing."""

    error: NDArray
    bound: NDArray
    motions: int
    claimed: bool
    expected: float


def run_once(settings: Settings, size: float, max_motions: int) -> Run:
    def open_eyes(camera: str, scene: Scene, points: int) -> Eyes:
        eyes = ProjectedEyes(scene, points)
        resize(eyes.world, size)
        return eyes

    session = Session(settings, open_eyes)
    last = session.run(max_motions, PATIENCE)
    left = bound(session.world, last.theta_demo, session.observer.noise_at_rest(settings))
    error = np.degrees(np.abs(last.theta - last.theta_demo))
    expected = np.inf if last.expected_error is None else float(np.degrees(last.expected_error))
    return Run(error, np.degrees(left), last.motion, last.status == "converged", expected)


def _outcome(name: str, runs: Sequence[Run]) -> Outcome:
    error, left, motions, claimed, expected = (
        np.array([getattr(run, field) for run in runs])
        for field in ("error", "bound", "motions", "claimed", "expected")
    )
    largest = error.max(1)
    beyond = claimed & (largest > FALSE_DEG)
    return Outcome(
        name,
        len(runs),
        {near: Share.of(largest <= near) for near in WITHIN_DEG},
        float(np.median(motions)),
        float(np.percentile(motions, 95)),
        Share.of(claimed),
        Share.of(beyond),
        Share.of(beyond & (largest > TIMES * expected)),
        float(np.sqrt((error**2).mean())),
        float(np.sqrt((left**2).mean())),
    )


def _tasks(
    settings: Settings, scenes: int, pairs: int, seed: int, any_head: bool, folder: Path
) -> list[tuple[Settings, float]]:
    """Settings of every run, and the learner's size."""
    tasks = []
    for k in range(scenes):
        rng = np.random.default_rng([seed, k])
        drawn = draw(rng, any_head)
        path = write(drawn.scene, folder, f"{'any' if any_head else 'parallel'}-{k}")
        for start, demonstrator in _pairs(rng, drawn.scene, pairs):
            asked = msgspec.structs.replace(
                settings,
                scene=str(path),
                points=drawn.points,
                start_deg=tuple(start),
                demonstrator_deg=tuple(demonstrator),
                seed=int(rng.integers(2**32)) if any_head else settings.seed,
            )
            tasks.append((asked, drawn.size))
    return tasks


def _drawn(rng: np.random.Generator, any_head: bool) -> Drawn:
    scene = load_scene(str(rng.choice(ROBOTS)))
    known = list(dict.fromkeys(point for layout in scene.points.values() for point in layout))
    if any_head:
        points = int(rng.integers(ANY_COUNTS[0], ANY_COUNTS[1] + 1))
        known = _between(known, rng)
    else:
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
    scene = msgspec.structs.replace(scene, title="random", head=head, points=layouts, **bases)
    if not any_head:
        return Drawn(scene, points)
    return Drawn(msgspec.structs.replace(scene, head=_any_head(head, rng)), points, float(rng.uniform(*SIZES)))


def _any_head(head: Head, rng: np.random.Generator) -> Head:
    """Turned inwards, and with a lens for each camera: another focal length, pixels that are not square, a centre."""
    eyes = {}
    for side in ("left", "right"):
        across = head.focal * float(rng.uniform(*ZOOM))
        focal = across, across * float(rng.uniform(*OBLONG))
        x, y = _moved(head.centre, rng.uniform(-OFFSET_PX, OFFSET_PX, 2))
        eyes[side] = Eye(focal, (x, y))
    return msgspec.structs.replace(head, toe_in_deg=float(rng.uniform(*TOE_IN_DEG)), **eyes)


def _between(known: list[tuple], rng: np.random.Generator) -> list[tuple]:
    """As many points as a layout may have, and more: new ones lie between two on the same link."""
    points = dict.fromkeys(known)
    while len(points) < 2 * ANY_COUNTS[1]:
        link, *first = known[int(rng.integers(len(known)))]
        others = [point[1:] for point in known if point[0] == link and list(point[1:]) != first]
        if others:
            second, share = others[int(rng.integers(len(others)))], rng.uniform()
            new = link, *(np.array(first) + share * (np.array(second) - first)).tolist()
            points[new] = None
    return list(points)


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


def _said(values: dict) -> dict:
    return {key: value for key, value in values.items() if value is not None}


def _toml(value) -> str:
    """Numbers, truth values, and lists of them."""
    if isinstance(value, bool):
        return str(value).lower()
    return f"[{', '.join(map(_toml, value))}]" if isinstance(value, (tuple, list)) else repr(value)
