"""What is dealt at random, by a seed that can be told: a learner's start, fields of settings, and where the head's
cameras stand."""

from collections.abc import Callable, Mapping, Sequence

import msgspec
import numpy as np
from numpy.typing import NDArray

from viewimit.loop.settings import Settings
from viewimit.simulation.scene import Head, Scene, load_scene
from viewimit.simulation.world import World

from .format import Range

APART_DEG = 30.0  # of a start that is dealt from the demonstrator, its joint that is farthest
FEWEST_POINTS, LOOKS, TRIES = 5, 64, 100  # seen in every one of so many postures; so many deals are tried
replace = msgspec.structs.replace


def _distance(head: Head, metres: float) -> Head:
    """From the middle of what it looks at, in the direction in which it stands."""
    middle = (np.array(head.gaze_demonstrator) + head.gaze_learner) / 2
    away = np.array(head.position) - middle
    return replace(head, position=tuple((middle + metres * away / np.linalg.norm(away)).tolist()))


HEAD: Mapping[str, Callable[[Head, float], Head]] = {  # what can be dealt of it
    "head distance": _distance,
    "head baseline": lambda head, metres: replace(head, baseline=metres),
    "head toe-in": lambda head, degrees: replace(head, toe_in_deg=degrees),
}


def varied(scene: Scene, head: Mapping[str, float]) -> Scene:
    """The scene with another head. head: by the names of HEAD."""
    for name, value in head.items():
        scene = replace(scene, head=HEAD[name](scene.head, value))
    return scene


def deal(ranges: Sequence[Range], settings: Settings, seed: int) -> tuple[dict[str, float], dict[str, float]]:
    """Fields of settings, and what is different about the head, each evenly within its range: of those deals in which
    points enough are seen. Raises ValueError if there are none."""
    scene = load_scene(settings.scene, settings.robot, settings.joints)
    for attempt in range(TRIES):
        rng = np.random.default_rng([seed, attempt])
        dealt = {one.name: _rounded(one, float(rng.uniform(one.low, one.high))) for one in ranges}
        head = {name: value for name, value in dealt.items() if name in HEAD}
        if _seen(World(varied(scene, head), settings.points), rng) >= FEWEST_POINTS:
            return {name: value for name, value in dealt.items() if name not in HEAD}, head
    raise ValueError(
        f"in none of {TRIES} scenes dealt are {FEWEST_POINTS} points seen in all images, wherever arms stand"
    )


def deal_start(scene: Scene, theta_demo: NDArray, seed: int | Sequence[int]) -> tuple[float, ...]:
    """Degrees: a learner's start at random, whole ones, a joint of which is far from the demonstrator's."""
    rng, (low, high) = np.random.default_rng(seed), np.array(scene.range_deg, float).T
    while True:
        start = np.round(rng.uniform(low, high))
        if np.abs(start - np.degrees(theta_demo)).max() > APART_DEG:
            return tuple(start.tolist())


def _rounded(one: Range, value: float) -> float:
    return round(one.low + one.step * round((value - one.low) / one.step), 6)


def _seen(world: World, rng: np.random.Generator) -> int:
    """Points in all four images at once, the least over postures at random."""
    theta = rng.uniform(world.scene.lower, world.scene.upper, (LOOKS, len(world.scene.lower))).T
    visible = np.concatenate([world.demo_images(theta)[1], world.own_images(theta)[1]], -1)
    return int(visible.all(-1).sum(-1).min())
