"""How fast E is: over the whole range, at one posture, and in one motion of each servo.

Times are CPU time of this process, medians. On a busy machine only their ratios mean something. BLAS must be held to
one thread before numpy is loaded (OPENBLAS_NUM_THREADS=1), or its threads count as well.
"""

import time
import timeit
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...analysis.landscape import Landscape, grid_axes, landscape_over
from ...estimation.transfers import TRANSFERS
from ...estimation.transfers.transfer import conflict
from ...estimation.views import FourViews
from ...loop.session import Session
from ...loop.settings import Settings
from ...servo import SERVOS
from ...simulation.scene import load_scene
from ...simulation.world import World
from .draws import surface_points

SINGLE_CALLS = 200  # timed together, well above the clock's resolution
ROUNDS, SLOW_ROUNDS = 15, 5
MANY_POINTS = 100  # as a tracker of textures gives
MOTIONS = 300  # of each servo


@dataclass(frozen=True)
class Times:
    """Seconds of CPU time, by transfer. Landscapes include kinematics."""

    scene: str
    points: int
    postures: int
    landscape_s: dict[str, float]
    many_s: dict[str, float]  # with MANY_POINTS points on the robot's surface
    posture_s: dict[str, float]  # fit, transfer, residual and E of given images
    motion_s: dict[str, dict[str, float]]  # by servo: one whole `Session.step`


def run(scene: str, points: int, seed: int = 0, progress: Callable[[float], None] = lambda share: None) -> Times:
    """Measure with the scene's demonstrator, over the 1° grid of its two moving joints."""
    world = World(load_scene(scene), points)
    links = range(len(world.scene.posture_deg) + 1)
    body, _ = surface_points(world.scene.robot, links, MANY_POINTS, np.random.default_rng(seed))
    many, axes = World(world.scene, body=body), grid_axes(world)
    demo = scene_demonstrator(world)
    own, _ = world.own_images(tuple(axis[0] for axis in axes))

    def by_transfer(share: float, seconds: Callable[[str], float]) -> dict[str, float]:
        found = {name: seconds(name) for name in TRANSFERS}
        progress(share)
        return found

    return Times(
        scene=scene,
        points=points,
        postures=axes[0].size * axes[1].size,
        landscape_s=by_transfer(0.2, lambda name: median_s(lambda: over_range(world, name))),
        many_s=by_transfer(0.4, lambda name: median_s(lambda: over_range(many, name), SLOW_ROUNDS)),
        posture_s=by_transfer(0.5, lambda name: call_s(lambda: E_of_images(name, demo, own))),
        motion_s={name: {servo: _motion_s(scene, points, name, servo) for servo in SERVOS} for name in TRANSFERS},
    )


def scene_demonstrator(world: World) -> NDArray[np.float64]:
    """Return the images of the scene's demonstrator, (N, 4) px."""
    return world.demo_images(np.radians(world.scene.posture_deg)[world.scene.moving])[0]


def over_range(world: World, transfer: str, with_condition: bool = False) -> Landscape:
    """Compute E over the range, with all points in sight."""
    images = scene_demonstrator(world)
    seen = np.ones((len(images), 2), bool)
    return landscape_over(world, TRANSFERS[transfer], images, seen, grid_axes(world), with_condition)


def E_of_images(transfer: str, demo: NDArray[np.float64], own: NDArray[np.float64]) -> NDArray[np.float64]:
    """Compute E [px²] of images (N, 4) px of the demonstrator and (N, 4) px of the learner."""
    views = FourViews(demo, own, np.ones(1, bool))
    return conflict(TRANSFERS[transfer](views).residual(views))


def _motion_s(scene: str, points: int, transfer: str, servo: str) -> float:
    """Time of motions from the scene's start, again when the servo rests. NaN if it does not move there."""
    session = Session(Settings.paper(scene=scene, points=points, transfer=transfer, servo=servo))
    times: list[float] = []
    while len(times) < MOTIONS:
        began = time.process_time()
        moved = session.step()
        took = time.process_time() - began
        if moved:
            times.append(took)
        elif session.snapshot.motion == 0:
            return np.nan
        else:
            session.reset()
    return float(np.median(times))


def call_s(call: Callable[[], object]) -> float:
    """Return the CPU time of one short call, the median of ROUNDS."""
    return median_s(lambda: [call() for _ in range(SINGLE_CALLS)]) / SINGLE_CALLS


def median_s(work: Callable[[], object], rounds: int | None = None) -> float:
    """Return the CPU time of this process for some work, after one call to warm up."""
    work()
    collecting = "import gc; gc.enable()"  # as in use; timeit switches it off
    return float(np.median(timeit.repeat(work, collecting, time.process_time, rounds or ROUNDS, number=1)))


def speed_table(found: Times) -> str:
    """Lay out the times for people, each block relative to its first row."""
    range_s, posture_s = found.landscape_s["epipolar"], found.posture_s["epipolar"]
    return "\n".join(
        [
            f"E over {found.postures} postures of {found.scene}, {found.points} points",
            "with kinematics and projection (CPU time on one thread, medians)",
            *(row(name, s, range_s) for name, s in found.landscape_s.items()),
            "the same postures, points on the robot's surface, beside the same transfer above",
            *(row(f"{name}, {MANY_POINTS} points", s, found.landscape_s[name]) for name, s in found.many_s.items()),
            "one posture: fit, recovery, residual and E of given images, without kinematics and projection",
            *(row(name, s, posture_s) for name, s in found.posture_s.items()),
            f"one motion: a whole step with kinematics and projection, median of {MOTIONS} from the start",
            *(
                row(f"{name}, {servo}", seconds, found.motion_s["epipolar"]["broyden"])
                for name, times in found.motion_s.items()
                for servo, seconds in times.items()
            ),
        ]
    )


def row(what: str, seconds: float, beside: float) -> str:
    """Return a line of the table."""
    return f"  {what:<60} {seconds * 1e3:9.3f} ms  {seconds / beside:8.1f} x"
