"""How fast E is: landscapes against two plain numpy baselines, and one posture as the servo asks for it.

Times are CPU time of this process, medians; on a noisy machine only their ratios mean something. BLAS must be
held to one thread before numpy is loaded (OPENBLAS_NUM_THREADS=1), or its threads count as well.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..evaluation import conflict, residual
from ..landscape import grid_axes, landscape
from ..scene import load_scene
from ..transfer import TRANSFERS
from ..views import FourViews
from ..world import World
from . import baselines

LOOP_SHARE = 10  # the loop is timed on every tenth posture in a seeded order, unless all are asked for
SINGLE_CALLS = 200  # calls timed together, well above the clock's resolution
BATCH = 8  # postures that a servo asks for together
ROUNDS = 15
SLOW_ROUNDS = 5


@dataclass(frozen=True)
class Benchmark:
    """Seconds of CPU time. agreement: largest relative difference of E to a baseline, over the postures it had.

    landscape_s: by transfer, condition_s: epipolar with its condition; batch_s, batch_condition_s: numpy batch;
    loop_s: for all postures, from `loop_postures` that were timed; fit_s: by transfer and number of
    postures, one fit, recovery, residual and E.
    """

    scene: str
    points: int
    postures: int
    loop_postures: int
    landscape_s: dict[str, float]
    condition_s: float
    batch_s: float
    batch_condition_s: float
    loop_s: float
    fit_s: dict[str, dict[int, float]]
    batch_agreement: float
    loop_agreement: float
    condition_agreement: float


def run(scene: str = "panda", points: int = 10, full_loop: bool = False, seed: int = 0) -> Benchmark:
    """Measure the scene's demonstrator at rest, over the 1° grid of its two moving joints."""
    world = World(load_scene(scene), points)
    theta = np.radians(world.scene.posture_deg)[world.scene.moving]
    demo, _ = world.demo_images(theta)
    seen = np.ones((points, 2), bool)
    postures = np.stack(np.meshgrid(*grid_axes(world), indexing="ij"), -1).reshape(-1, 2)
    sample = np.random.default_rng(seed).permutation(len(postures))
    sample = sample if full_loop else sample[: len(postures) // LOOP_SHARE]

    def over_grid(transfer: str, with_condition: bool = False):
        return landscape(world, TRANSFERS[transfer], demo, seen, with_condition=with_condition)

    landscape_s = {name: _median_s(lambda: over_grid(name), ROUNDS) for name in TRANSFERS}  # noqa: B023
    condition_s = _median_s(lambda: over_grid("epipolar", True), ROUNDS)
    batch_s = _median_s(lambda: baselines.batch(world, demo, postures), SLOW_ROUNDS)
    batch_condition_s = _median_s(lambda: baselines.batch(world, demo, postures, True), SLOW_ROUNDS)
    began = time.process_time()
    loop_E = baselines.loop(world, demo, postures[sample])
    loop_s = (time.process_time() - began) * len(postures) / len(sample)
    found = over_grid("epipolar", True)
    batch_E, batch_condition = baselines.batch(world, demo, postures, True)
    return Benchmark(
        scene=scene,
        points=points,
        postures=len(postures),
        loop_postures=len(sample),
        landscape_s=landscape_s,
        condition_s=condition_s,
        batch_s=batch_s,
        batch_condition_s=batch_condition_s,
        loop_s=loop_s,
        fit_s={name: _fit_s(world, fit, demo, postures) for name, fit in TRANSFERS.items()},
        batch_agreement=_difference(found.E.ravel(), batch_E),
        loop_agreement=_difference(found.E.ravel()[sample], loop_E),
        condition_agreement=_difference(found.condition.ravel(), batch_condition),
    )


def table(result: Benchmark) -> str:
    """The figures for people."""
    ours, with_condition = result.landscape_s["epipolar"], result.condition_s
    timed = "all postures" if result.loop_postures == result.postures else f"{result.loop_postures} postures, scaled"

    def row(what: str, seconds: float, against: float) -> str:
        return f"  {what:<52} {seconds * 1e3:9.1f} ms  {seconds / against:8.1f} x"

    lines = [
        f"E over {result.postures} postures of {result.scene}, {result.points} points",
        "with kinematics and projection (CPU time on one thread, medians)",
        row("epipolar", ours, ours),
        row("numpy batch: eigh and solve", result.batch_s, ours),
        row(f"numpy loop: eigh and lstsq ({timed})", result.loop_s, ours),
        row("epipolar with cond(A)", with_condition, with_condition),
        row("numpy batch, without cond(A)", result.batch_s, with_condition),
        row("numpy batch with cond(A), eigvalsh of its AᵀA", result.batch_condition_s, with_condition),
    ]
    lines += [row(name, seconds, ours) for name, seconds in result.landscape_s.items() if name != "epipolar"]
    lines.append("fit, recovery, residual and E")
    for name, times in result.fit_s.items():
        for count, seconds in times.items():
            postures = "one posture" if count == 1 else f"{count} postures together"
            lines.append(f"  {name + ', ' + postures:<52} {seconds * 1e6:9.0f} µs")
    lines += [
        "largest relative difference",
        f"  {'E to the batch, all postures':<52} {result.batch_agreement:9.1e}",
        f"  {f'E to the loop, {result.loop_postures} postures':<52} {result.loop_agreement:9.1e}",
        f"  {'cond(A) to the batch, all postures':<52} {result.condition_agreement:9.1e}",
    ]
    return "\n".join(lines)


def _fit_s(world: World, fit: Callable, demo: NDArray, postures: NDArray) -> dict[int, float]:
    own, _ = world.own_images(postures[:: len(postures) // BATCH][:BATCH].T)
    found = {}
    for count, images in ((1, np.ascontiguousarray(own[0])), (BATCH, np.ascontiguousarray(own))):
        views = FourViews(demo, images, np.ones(1, bool))

        def calls(views=views):
            for _ in range(SINGLE_CALLS):
                conflict(residual(fit(views), views))

        found[count] = _median_s(calls, ROUNDS) / SINGLE_CALLS
    return found


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
