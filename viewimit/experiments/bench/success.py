"""How often and how soon a servo arrives, from many starts, at many demonstrators.

Every transfer and servo gets the same pairs of start and demonstrator. Runs are apart from each other and are made in
as many processes as there are; the result does not depend on how many.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from statistics import NormalDist

import msgspec
import numpy as np
from numpy.typing import NDArray

from ...analysis.landscape import Landscape, conflict_of_images, grid_axes, landscape_over
from ...loop.session import Session
from ...loop.settings import Settings
from ...simulation.scene import Scene
from ...simulation.world import World
from ..executors.study import Study, each
from .eyes import shared_eyes

COARSE_DEG, FINER_DEG, FINE_DEG = 4.0, 0.25, 0.05  # of the search for the transfer's own minimum, beside 1°
AROUND_DEG = 5.0, 1.5, 0.4  # how far each finer grid goes
WITHIN_DEG = (0.5, 1.0, 3.0)
FALSE_DEG = 1.0  # from where it arrived, a claim is false
TARGETS = ("own_minimum", "demonstrator")
CONFIDENCE = 0.95

Posture = tuple[float, ...]
Pair = tuple[Posture, Posture]


@dataclass(frozen=True)
class Run:
    """motions made; claimed: the servo says that it has converged; ended, nearest: largest joint error to each of
    TARGETS, at the end and when it was least; bias: of the transfer's own minimum to the demonstrator. Degrees."""

    motions: int
    claimed: bool
    ended: dict[str, float]
    nearest: dict[str, float]
    bias: float


@dataclass(frozen=True)
class Share:
    """`count` of `runs`, and Wilson's score interval of the share."""

    count: int
    runs: int
    share: float
    low: float
    high: float

    @classmethod
    def of(cls, happened: Iterable[bool]) -> "Share":
        happened = list(happened)
        count, runs = sum(map(bool, happened)), len(happened)
        return cls(count, runs, count / runs, *wilson(count, runs))


@dataclass(frozen=True)
class Success:
    """Of one transfer and servo. ended, came: shares of runs by target and by how near, degrees, at the end and at some
    time; claimed_falsely: FALSE_DEG from the transfer's own minimum or more. Motions, bias: median, 95th percentile."""

    transfer: str
    servo: str
    runs: int
    max_motions: int
    ended: dict[str, dict[float, Share]]
    came: dict[str, dict[float, Share]]
    motions_median: float
    motions_95: float
    claimed: Share
    claimed_falsely: Share
    bias_deg_median: float
    bias_deg_95: float


def random_pairs(scene: Scene, runs: int, seed: int) -> list[Pair]:
    """Start and demonstrator, each uniform over the range of all moving joints, degrees."""
    low, high = np.transpose(scene.range_deg)
    drawn = np.random.default_rng(seed).uniform(low, high, (runs, 2, len(low)))
    return [(tuple(start), tuple(demonstrator)) for start, demonstrator in drawn.tolist()]


def grid_pairs(scene: Scene, counts: Sequence[int]) -> list[Pair]:
    """Starts on a grid over the range, `counts` a joint, and the scene's own demonstrator, degrees."""
    axes = (np.linspace(*limits, count) for limits, count in zip(scene.range_deg, counts, strict=True))
    starts = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, len(counts))
    demonstrator = tuple(scene.posture_deg[joint] for joint in scene.moving)
    return [(tuple(start), demonstrator) for start in starts.tolist()]


def run(
    settings: Settings,
    pairs: Sequence[Pair],
    transfers: Sequence[str],
    servos: Sequence[str],
    max_motions: int,
    workers: int | Study | None = None,
    tell: Callable[[float], None] = lambda share: None,
    rehearsed: int = 0,
) -> list[Success]:
    """Of every transfer and servo, from every pair. rehearsed: postures in which the learner has watched itself before,
    other ones for every pair; their motions do not count. workers: processes, if None as many as processors.

    tell(share done), as often as a pair is done with.
    """
    tasks = [
        (
            msgspec.structs.replace(settings, transfer=name, start_deg=start, demonstrator_deg=demo),
            servos,
            max_motions,
            rehearsed,
            k,
        )
        for name in transfers
        for k, (start, demo) in enumerate(pairs)
    ]
    results = []
    for runs in each(run_pair, tasks, workers):
        results.append(runs)
        tell(len(results) / len(tasks))
    return [
        summary(name, servo, max_motions, [runs[s] for runs in results[t * len(pairs) : (t + 1) * len(pairs)]])
        for t, name in enumerate(transfers)
        for s, servo in enumerate(servos)
    ]


def run_pair(
    settings: Settings, servos: Sequence[str], max_motions: int, rehearsed: int = 0, seed: int = 0
) -> list[Run]:
    """A run of each servo, from the settings' start to their demonstrator. seed: of the postures rehearsed."""
    session = Session(msgspec.structs.replace(settings, servo=servos[0]), open_eyes=shared_eyes)
    if rehearsed:
        session.calibrate(rehearsed, seed)
    targets = dict(zip(TARGETS, (own_minimum(session), session.snapshot.theta_demo)))
    bias = _error_deg(*targets.values())
    runs = []
    for servo in servos:
        if rehearsed or servo != session.settings.servo:  # else it has just begun
            session.begin(msgspec.structs.replace(settings, servo=servo))
        last = session.run(max_motions, patience=1).last
        visited = np.array([snapshot.theta for snapshot in session.history])
        errors = {name: _error_deg(visited, target) for name, target in targets.items()}
        ended, nearest = ({name: float(pick(e)) for name, e in errors.items()} for pick in (lambda e: e[-1], np.min))
        runs.append(Run(last.motion, last.status.is_claim, ended, nearest, float(bias)))
    return runs


def own_minimum(session: Session) -> NDArray:
    """(2,) rad: where the transfer's E is smallest for the demonstrator as now seen, whatever its posture.

    On a grid of FINE_DEG: the local minima of a coarse one are looked at by finer ones. NaN if too few points are seen.
    """
    views, fit, world = session.snapshot.views, session.snapshot.fit, session.world
    over = lambda axes: landscape_over(world, fit, views.demo, views.visible[:, :2], axes)
    degrees, axes, images = _grids(world)
    places = Landscape(axes, *conflict_of_images(fit, views.demo, views.visible[:, :2], *images)).local_minima()
    if not len(places):
        return np.full(2, np.nan)
    about = [over(tuple(a[np.abs(a - at) <= np.radians(AROUND_DEG[0])] for a, at in zip(degrees, p))) for p in places]
    lowest = min(about, key=lambda found: np.nanmin(found.E)).minimum
    for step, around in zip((FINER_DEG, FINE_DEG), AROUND_DEG[1:]):
        offsets = np.radians(np.arange(-around, around + step / 2, step))
        lowest = over(
            tuple(
                np.unique(np.clip(at + offsets, low, high))
                for at, low, high in zip(lowest, session.scene.lower, session.scene.upper)
            )
        ).minimum
    return lowest


@lru_cache(1)  # they are the same for every run of a study
def _grids(world: World) -> tuple[tuple[NDArray, NDArray], tuple[NDArray, NDArray], tuple[NDArray, NDArray]]:
    """The axes of grids of 1° and of COARSE_DEG, rad, and the learner's images over the latter."""
    coarse = grid_axes(world, step_deg=COARSE_DEG)
    return grid_axes(world), coarse, world.own_images((coarse[0][:, None], coarse[1]))


def summary(transfer: str, servo: str, max_motions: int, runs: Sequence[Run]) -> Success:
    motions, bias = [run.motions for run in runs], [run.bias for run in runs]

    def shares(errors: str) -> dict[str, dict[float, Share]]:
        return {
            target: {near: Share.of(getattr(run, errors)[target] <= near for run in runs) for near in WITHIN_DEG}
            for target in TARGETS
        }

    return Success(
        transfer,
        servo,
        len(runs),
        max_motions,
        ended=shares("ended"),
        came=shares("nearest"),
        motions_median=float(np.median(motions)),
        motions_95=float(np.percentile(motions, 95)),
        claimed=Share.of(run.claimed for run in runs),
        claimed_falsely=Share.of(run.claimed and run.ended["own_minimum"] > FALSE_DEG for run in runs),
        bias_deg_median=float(np.median(bias)),
        bias_deg_95=float(np.percentile(bias, 95)),
    )


def wilson(count: int, runs: int) -> tuple[float, float]:
    """Wilson's score interval (1927) of a share, for CONFIDENCE: low, high."""
    z = NormalDist().inv_cdf((1 + CONFIDENCE) / 2)
    share, shrink = count / runs, 1 + z * z / runs
    middle = (share + z * z / (2 * runs)) / shrink
    half = z / shrink * math.sqrt(share * (1 - share) / runs + (z / (2 * runs)) ** 2)
    return middle - half if count else 0.0, middle + half if count < runs else 1.0


def _error_deg(theta: NDArray, target: NDArray) -> NDArray:
    """Largest joint error. theta: (..., m) rad → (...) degrees."""
    return np.degrees(np.abs(theta - target)).max(-1)
