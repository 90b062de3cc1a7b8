"""How fast E is: landscapes, one posture and one motion, beside independent baselines in the same run.

Times are CPU time of this process, medians; on a noisy machine only their ratios mean something. BLAS must be
held to one thread before numpy is loaded (OPENBLAS_NUM_THREADS=1), or its threads count as well.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...analysis.landscape import grid_axes, landscape_over
from ...estimation.residuals import conflict
from ...estimation.transfers import TRANSFERS
from ...estimation.views import FourViews
from ...loop.session import Session
from ...loop.settings import Settings
from ...servo import SERVOS
from ...simulation.scene import load_scene
from ...simulation.world import World
from . import baselines, opencv_baseline
from .surface import surface_points

LOOP_SHARE = 10  # loops are timed on every tenth posture in a seeded order, unless all are asked for
SINGLE_CALLS = 200  # calls timed together, well above the clock's resolution
BATCH = 8  # postures that a servo asks for together
ROUNDS = 15
SLOW_ROUNDS = 5
MANY = 100  # points, as a tracker of textures gives
MOTIONS = 300  # of each servo
STAGES = 6


@dataclass(frozen=True)
class OpenCV:
    """loop_s: for all postures, from those timed; posture_s: one posture. Its E is another one: px², at the
    demonstrator's posture, and the median over the postures timed."""

    loop_s: float
    posture_s: float
    E_at_demonstrator: float
    E_median: float


@dataclass(frozen=True)
class Benchmark:
    """Seconds of CPU time. agreement: largest relative difference of E to a baseline, over the postures it had.

    landscape_s: by transfer, condition_s: epipolar with its condition; batch_s, batch_condition_s: numpy batch;
    loop_s: for all postures, from `loop_postures` that were timed; many_s: by transfer, with MANY points on the robot's
    surface; all with kinematics and projection.
    fit_s: by transfer and number of postures, one fit, recovery, residual and E of given images;
    loop_posture_s, batch_posture_s: the baselines given the images of one posture.
    motion_s: by transfer and servo, one whole `Session.step`. opencv: None if it cannot run, and opencv_why_not.
    """

    scene: str
    points: int
    postures: int
    loop_postures: int
    landscape_s: dict[str, float]
    many_s: dict[str, float]
    condition_s: float
    batch_s: float
    batch_condition_s: float
    loop_s: float
    fit_s: dict[str, dict[int, float]]
    loop_posture_s: float
    batch_posture_s: float
    motion_s: dict[str, dict[str, float]]
    opencv: OpenCV | None
    opencv_why_not: str | None
    batch_agreement: float
    loop_agreement: float
    condition_agreement: float


def run(
    scene: str = "panda",
    points: int = 10,
    full_loop: bool = False,
    seed: int = 0,
    tell: Callable[[float], None] = lambda share: None,
) -> Benchmark:
    """Measure the scene's demonstrator at rest, over the 1° grid of its two moving joints. tell(share done)."""
    world = World(load_scene(scene), points)
    theta = np.radians(world.scene.posture_deg)[world.scene.moving]
    demo, _ = world.demo_images(theta)
    postures = np.stack(np.meshgrid(*grid_axes(world), indexing="ij"), -1).reshape(-1, 2)
    rng = np.random.default_rng(seed)
    sample = rng.permutation(len(postures))
    sample = sample if full_loop else sample[: len(postures) // LOOP_SHARE]

    def over_grid(transfer: str, world: World = world, with_condition: bool = False):
        images, _ = world.demo_images(theta)
        seen = np.ones((len(images), 2), bool)
        return landscape_over(world, TRANSFERS[transfer], images, seen, with_condition=with_condition)

    links = range(len(world.scene.posture_deg) + 1)
    many = World(world.scene, body=surface_points(world.scene.robot, links, MANY, rng)[0])
    landscape_s = {name: _median_s(lambda: over_grid(name), ROUNDS) for name in TRANSFERS}  # noqa: B023
    many_s = {name: _median_s(lambda: over_grid(name, many), SLOW_ROUNDS) for name in TRANSFERS}  # noqa: B023
    condition_s = _median_s(lambda: over_grid("epipolar", with_condition=True), ROUNDS)
    tell(1 / STAGES)
    batch_s = _median_s(lambda: baselines.batch(world, demo, postures), SLOW_ROUNDS)
    batch_condition_s = _median_s(lambda: baselines.batch(world, demo, postures, True), SLOW_ROUNDS)
    tell(2 / STAGES)
    loop_s, loop_E = _loop_s(baselines.loop, world, demo, postures, sample)
    tell(3 / STAGES)
    own, _ = world.own_images(postures[:: len(postures) // BATCH][:BATCH].T)
    own = np.ascontiguousarray(own)
    fit_s = {name: _fit_s(fit, demo, own) for name, fit in TRANSFERS.items()}
    loop_posture_s = call_s(lambda: baselines.conflict(demo, own[0]))
    batch_posture_s = call_s(lambda: baselines.conflicts(demo, own[:1]))
    tell(4 / STAGES)
    why_not = opencv_baseline.why_not(points)
    opencv = None if why_not else _opencv(world, theta, demo, postures, sample)
    tell(5 / STAGES)
    motion_s = {name: {servo: _motion_s(scene, points, name, servo) for servo in SERVOS} for name in TRANSFERS}
    found = over_grid("epipolar", with_condition=True)
    batch_E, batch_condition = baselines.batch(world, demo, postures, True)
    tell(1.0)
    assert found.condition is not None and batch_condition is not None  # both were asked for
    return Benchmark(
        scene=scene,
        points=points,
        postures=len(postures),
        loop_postures=len(sample),
        landscape_s=landscape_s,
        many_s=many_s,
        condition_s=condition_s,
        batch_s=batch_s,
        batch_condition_s=batch_condition_s,
        loop_s=loop_s,
        fit_s=fit_s,
        loop_posture_s=loop_posture_s,
        batch_posture_s=batch_posture_s,
        motion_s=motion_s,
        opencv=opencv,
        opencv_why_not=why_not,
        batch_agreement=_difference(found.E.ravel(), batch_E),
        loop_agreement=_difference(found.E.ravel()[sample], loop_E),
        condition_agreement=_difference(found.condition.ravel(), batch_condition),
    )


def _loop_s(loop: Callable, world: World, demo: NDArray, postures: NDArray, sample: NDArray) -> tuple[float, NDArray]:
    """Seconds for all postures, from those of the sample, and their E."""
    loop(world, demo, postures[sample[:1]])  # what is loaded at the first call is not counted
    began = time.process_time()
    E = loop(world, demo, postures[sample])
    return (time.process_time() - began) * len(postures) / len(sample), E


def _opencv(world: World, theta: NDArray, demo: NDArray, postures: NDArray, sample: NDArray) -> OpenCV:
    loop_s, E = _loop_s(opencv_baseline.loop, world, demo, postures, sample)
    own = baselines.own_image(world, postures[0])
    return OpenCV(
        loop_s=loop_s,
        posture_s=call_s(lambda: opencv_baseline.conflict(demo, own)),
        E_at_demonstrator=opencv_baseline.conflict(demo, baselines.own_image(world, theta)),
        E_median=float(np.median(E)),
    )


def _fit_s(fit: Callable, demo: NDArray, own: NDArray) -> dict[int, float]:
    """By number of postures. own: (BATCH, N, 4) px."""

    def of(images: NDArray) -> float:
        views = FourViews(demo, images, np.ones(1, bool))
        return call_s(lambda: conflict(fit(views).residual(views)))

    return {1: of(own[0]), BATCH: of(own)}


def _motion_s(scene: str, points: int, transfer: str, servo: str) -> float:
    """Of motions from the scene's start, again and again when the servo rests. NaN if it does not move there."""
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
    def calls():
        for _ in range(SINGLE_CALLS):
            call()

    return _median_s(calls, ROUNDS) / SINGLE_CALLS


def _median_s(work: Callable[[], object], rounds: int) -> float:
    """CPU time of this process, after one call to warm up."""
    work()
    times = []
    for _ in range(rounds):
        began = time.process_time()
        work()
        times.append(time.process_time() - began)
    return float(np.median(times))


def _difference(found: NDArray, expected: NDArray) -> float:
    return float(np.max(np.abs(found / expected - 1)))
