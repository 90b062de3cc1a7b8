"""How fast E is: landscapes, one posture and one motion, beside independent baselines.

Times are CPU time of this process, medians. On a busy machine only their ratios mean something. BLAS must be held to
one thread before numpy is loaded (OPENBLAS_NUM_THREADS=1), or its threads count as well.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...analysis.landscape import grid_axes, landscape_over
from ...estimation.transfers import TRANSFERS
from ...estimation.transfers.transfer import conflict
from ...estimation.views import FourViews
from ...loop.session import Session
from ...loop.settings import Settings
from ...servo import SERVOS
from ...simulation.scene import load_scene
from ...simulation.world import World
from . import baselines
from .draws import surface_points

LOOP_SHARE = 10  # loops are timed on every tenth posture in a seeded order, or on all with --full-loop
SINGLE_CALLS = 200  # timed together, well above the clock's resolution
BATCH = 8  # postures that a servo evaluates together
ROUNDS, SLOW_ROUNDS = 15, 5
MANY_POINTS = 100  # as a tracker of textures gives
MOTIONS = 300  # of each servo
STAGES = 6


@dataclass(frozen=True)
class OpenCV:
    """Times of the OpenCV baseline, whose E differs from the others'."""

    loop_s: float  # for all postures, scaled from those timed
    posture_s: float  # one posture
    E_at_demonstrator: float  # px², in the demonstrator's posture
    E_median: float  # px², over the postures timed


@dataclass(frozen=True)
class Times:
    """Seconds of CPU time, and largest relative differences to the baselines. Landscapes include kinematics."""

    scene: str
    points: int
    postures: int
    loop_postures: int  # on which loops were timed
    landscape_s: dict[str, float]  # by transfer
    many_s: dict[str, float]  # by transfer, with MANY_POINTS points on the robot's surface
    condition_s: float  # epipolar with its condition number
    batch_s: float  # numpy batch
    batch_condition_s: float  # numpy batch with the condition number
    loop_s: float  # numpy loop, scaled to all postures
    fit_s: dict[str, dict[int, float]]  # by transfer and number of postures: fit, transfer, residual and E of images
    loop_posture_s: float  # numpy loop, given the images of one posture
    batch_posture_s: float  # numpy batch, given the images of one posture
    motion_s: dict[str, dict[str, float]]  # by transfer and servo: one whole `Session.step`
    opencv: OpenCV | None
    opencv_why_not: str | None
    batch_agreement: float  # of E
    loop_agreement: float  # of E
    condition_agreement: float


def run(
    scene: str = Settings().scene,
    points: int = Settings().points,
    full_loop: bool = False,
    seed: int = 0,
    progress: Callable[[float], None] = lambda share: None,
) -> Times:
    """Measure with the scene's demonstrator, over the 1° grid of its two moving joints."""
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
    many = World(world.scene, body=surface_points(world.scene.robot, links, MANY_POINTS, rng)[0])
    landscape_s = {name: _median_s(lambda: over_grid(name), ROUNDS) for name in TRANSFERS}  # noqa: B023
    many_s = {name: _median_s(lambda: over_grid(name, many), SLOW_ROUNDS) for name in TRANSFERS}  # noqa: B023
    condition_s = _median_s(lambda: over_grid("epipolar", with_condition=True), ROUNDS)
    progress(1 / STAGES)
    batch_s = _median_s(lambda: baselines.batch(world, demo, postures), SLOW_ROUNDS)
    batch_condition_s = _median_s(lambda: baselines.batch(world, demo, postures, True), SLOW_ROUNDS)
    progress(2 / STAGES)
    loop_s, loop_E = _loop_s(baselines.loop, world, demo, postures, sample)
    progress(3 / STAGES)
    own, _ = world.own_images(postures[:: len(postures) // BATCH][:BATCH].T)
    own = np.ascontiguousarray(own)
    fit_s = {name: _fit_s(fit, demo, own) for name, fit in TRANSFERS.items()}
    loop_posture_s = call_s(lambda: baselines.conflict(demo, own[0]))
    batch_posture_s = call_s(lambda: baselines.conflicts(demo, own[:1]))
    progress(4 / STAGES)
    why_not = baselines.opencv_unavailable(points)
    opencv = None if why_not else _opencv(world, theta, demo, postures, sample)
    progress(5 / STAGES)
    motion_s = {name: {servo: _motion_s(scene, points, name, servo) for servo in SERVOS} for name in TRANSFERS}
    found = over_grid("epipolar", with_condition=True)
    batch_E, batch_condition = baselines.batch(world, demo, postures, True)
    progress(1.0)
    assert found.condition is not None and batch_condition is not None
    return Times(
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
    """Time for all postures, scaled from those of the sample, and the E of those."""
    loop(world, demo, postures[sample[:1]])  # loading at the first call does not count
    began = time.process_time()
    E = loop(world, demo, postures[sample])
    return (time.process_time() - began) * len(postures) / len(sample), E


def _opencv(world: World, theta: NDArray, demo: NDArray, postures: NDArray, sample: NDArray) -> OpenCV:
    loop_s, E = _loop_s(baselines.opencv_loop, world, demo, postures, sample)
    own = baselines.own_image(world, postures[0])
    return OpenCV(
        loop_s=loop_s,
        posture_s=call_s(lambda: baselines.opencv_conflict(demo, own)),
        E_at_demonstrator=baselines.opencv_conflict(demo, baselines.own_image(world, theta)),
        E_median=float(np.median(E)),
    )


def _fit_s(fit: Callable, demo: NDArray, own: NDArray) -> dict[int, float]:
    """Time by number of postures. own: (BATCH, N, 4) px."""

    def of(images: NDArray) -> float:
        views = FourViews(demo, images, np.ones(1, bool))
        return call_s(lambda: conflict(fit(views).residual(views)))

    return {1: of(own[0]), BATCH: of(own)}


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
    """Return the CPU time of one call, the median of ROUNDS."""

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


def speed_table(found: Times) -> str:
    """Lay out the times for people, each block relative to its first row."""
    timed = "all postures" if found.loop_postures == found.postures else f"{found.loop_postures} postures, scaled"
    return "\n".join(
        [
            f"E over {found.postures} postures of {found.scene}, {found.points} points",
            "with kinematics and projection (CPU time on one thread, medians)",
            *_landscape_rows(found, timed),
            "one posture: fit, recovery, residual and E of given images, without kinematics and projection",
            *_posture_rows(found),
            f"one motion: a whole step with kinematics and projection, median of {MOTIONS} from the start",
            *(
                f"  {f'{name}, {servo}':<60} {seconds * 1e6:9.0f} µs"
                for name, times in found.motion_s.items()
                for servo, seconds in times.items()
            ),
            "largest relative difference",
            f"  {'E to the batch, all postures':<60} {found.batch_agreement:9.1e}",
            f"  {f'E to the loop, {found.loop_postures} postures':<60} {found.loop_agreement:9.1e}",
            f"  {'cond(A) to the batch, all postures':<60} {found.condition_agreement:9.1e}",
        ]
    )


def _landscape_rows(found: Times, timed: str) -> list[str]:
    def row(what: str, seconds: float, against: float = found.landscape_s["epipolar"]) -> str:
        return f"  {what:<60} {seconds * 1e3:9.1f} ms  {seconds / against:8.1f} x"

    cv, with_condition = found.opencv, found.condition_s
    return [
        *(row(name, seconds) for name, seconds in found.landscape_s.items()),
        row("numpy batch: eigh and solve", found.batch_s),
        row(f"numpy loop: eigh and lstsq ({timed})", found.loop_s),
        row(f"OpenCV loop: perspective, another E ({timed})", cv.loop_s) if cv else f"  {found.opencv_why_not}",
        row("epipolar with cond(A)", with_condition, with_condition),
        row("numpy batch, without cond(A)", found.batch_s, with_condition),
        row("numpy batch with cond(A), eigvalsh of its AᵀA", found.batch_condition_s, with_condition),
        "the same postures, points on the robot's surface, beside the same transfer above",
        *(row(f"{name}, {MANY_POINTS} points", s, found.landscape_s[name]) for name, s in found.many_s.items()),
    ]


def _posture_rows(found: Times) -> list[str]:
    def row(what: str, seconds: float, against: float = found.fit_s["epipolar"][1]) -> str:
        return f"  {what:<60} {seconds * 1e6:9.0f} µs  {seconds / against:8.1f} x"

    cv = found.opencv
    return [
        *(row(name, times[1]) for name, times in found.fit_s.items()),
        row("numpy batch of one: eigh and solve", found.batch_posture_s),
        row("numpy loop: eigh and lstsq", found.loop_posture_s),
        row("OpenCV: perspective, another E", cv.posture_s) if cv else f"  {found.opencv_why_not}",
        *(
            row(f"{name}, {count} postures together", seconds)
            for name, times in found.fit_s.items()
            for count, seconds in times.items()
            if count > 1
        ),
    ]
