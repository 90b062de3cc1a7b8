"""Scenes drawn at random about the shipped ones: robot, head, baseline, bases, yaws and body points.

They hold both arms in all four images over the whole range. Heads have two equal, parallel cameras, or any: turned
inwards, with unlike lenses, and a learner of another size.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from ...simulation.scene import Eye, Head, Scene, load_scene
from ...simulation.world import World

ROBOTS = "panda", "iiwa"
HEAD_M, BASE_M, BASELINE_M, YAW_DEG = 0.25, (0.15, 0.15, 0.045), (0.3, 0.8), 45.0
COUNTS = 8, 10, 16  # points
LOW, MIDDLE = 2, 4  # links from the base: at least SPREAD points below, between and beyond these
SPREAD = 2
LOOKS = 64  # postures in which all must be seen
ANY_COUNTS, SIZES = (10, 40), (0.8, 1.2)  # of any head's scenes: points, and the learner's size
TOE_IN_DEG, ZOOM, OBLONG, OFFSET_PX = (0.0, 20.0), (0.75, 1.15), (0.9, 1.1), 15.0


@dataclass(frozen=True)
class Drawn:
    """points: of the scene's new layout; size: of the learner, relative to the robot's."""

    scene: Scene
    points: int
    size: float = 1.0


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


def _moved(position: Sequence[float], shift: NDArray) -> tuple[float, ...]:
    return tuple((np.array(position) + shift).tolist())


def _said(values: dict) -> dict:
    return {key: value for key, value in values.items() if value is not None}


def _toml(value) -> str:
    """Numbers, truth values, and lists of them."""
    if isinstance(value, bool):
        return str(value).lower()
    return f"[{', '.join(map(_toml, value))}]" if isinstance(value, (tuple, list)) else repr(value)
