"""How often and how soon a servo arrives, from many starts, at many demonstrators."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache
from typing import Annotated, Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from ...analysis.landscape import Landscape, conflict_of_images, grid_axes, landscape_over
from ...estimation.transfers import TRANSFERS
from ...loop.session import Session
from ...loop.settings import PAPER_FIELDS, Setting, Settings
from ...servo import SERVOS
from ...simulation.scene import Scene
from ...simulation.world import World
from .benchmark import (
    FALSE_DEG,
    WITHIN_DEG,
    Context,
    MaxMotions,
    MethodOptions,
    OptionError,
    Rehearsed,
    RunOptions,
    SceneOptions,
    Share,
    run_cases,
)
from .draws import shared_eyes

COARSE_STEP_DEG, FINER_STEP_DEG, FINE_STEP_DEG = 4.0, 0.25, 0.05  # of the grids on which a minimum is searched
SEARCH_RADII_DEG = 5.0, 1.5, 0.4  # of each finer grid
TARGETS = {"own_minimum": "to the transfer's own minimum", "demonstrator": "to the demonstrator"}

Posture = tuple[float, ...]
Pair = tuple[Posture, Posture]


@dataclass(frozen=True)
class Run:
    """One run. Errors are largest joint errors, degrees."""

    motions: int
    claimed: bool  # whether the servo says that it has converged
    ended: dict[str, float]  # error to each of TARGETS at the end
    nearest: dict[str, float]  # smallest error to each of TARGETS during the run
    bias: float  # from the transfer's own minimum to the demonstrator


@dataclass(frozen=True)
class Success:
    """The runs of one transfer and servo."""

    transfer: str
    servo: str
    runs: int
    max_motions: int
    ended: dict[str, dict[float, Share]]  # by target and degrees: shares of runs that ended so near
    came: dict[str, dict[float, Share]]  # shares of runs that came so near at any time
    motions_median: float
    motions_95: float  # 95th percentile
    claimed: Share
    claimed_falsely: Share  # FALSE_DEG or more from the transfer's own minimum
    bias_deg_median: float
    bias_deg_95: float


@dataclass(frozen=True, kw_only=True)
class SuccessBenchmark(SceneOptions, RunOptions, MethodOptions):
    """Success of every transfer and servo, from the same starts at the same demonstrators."""

    grid: Annotated[
        tuple[int, int] | None,
        Setting(
            description="instead of --runs: starts for each joint, with the scene's own demonstrator",
            unit="N,N",
            bounds=(1, 1000),
        ),
    ] = None
    max_motions: MaxMotions = 500
    rehearsed: Rehearsed = 0

    def run(self, context: Context) -> tuple[Any, str]:
        """See `Benchmark.run`."""
        scene, points = self.load()
        if self.grid:
            pairs = grid_pairs(scene, self.grid)
            what = f"{len(pairs)} starts on a grid over the whole range, the scene's demonstrator"
        else:
            pairs = random_pairs(scene, self.runs, self.seed)
            what = f"{len(pairs)} random starts and demonstrators over the whole range, seed {self.seed}"
        if self.rehearsed:
            what += f", {self.rehearsed} postures rehearsed"
        settings = Settings.paper(scene=self.scene, points=points)
        results: list[Success] = []
        for transfers, servos in self._methods():
            results += run(settings, pairs, transfers, servos, self.max_motions, context, self.rehearsed)
        heading = f"{what}, {points} points of {self.scene}"
        return [{"pairs": heading, **asdict(result)} for result in results], success_table(results, heading)

    def _methods(self) -> list[tuple[list[str], list[str]]]:
        """Return transfers with the servos to run on them.

        Slow servos, such as the paper's law, take minutes. They run with the paper's transfer only, unless transfer or
        servo is given by name.
        """
        transfers, servos = [self.transfer or ""], [self.servo or ""]
        if not self.servo:
            servos = [name for name, servo in SERVOS.items() if servo.predicts or not self.rehearsed]
        elif self.rehearsed and not SERVOS[self.servo].predicts:
            raise OptionError(f"--rehearsed: {self.servo} learns from its own motions alone")
        if self.transfer or self.servo or self.rehearsed:
            return [(transfers if self.transfer else list(TRANSFERS), servos)]
        others = [name for name in TRANSFERS if name != PAPER_FIELDS["transfer"]]
        return [([PAPER_FIELDS["transfer"]], servos), (others, quick_servos())]


def quick_servos() -> list[str]:
    """Return the servos that need few motions."""
    return [name for name, servo in SERVOS.items() if not servo.slow]


def random_pairs(scene: Scene, runs: int, seed: int) -> list[Pair]:
    """Draw starts and demonstrators, uniform over the range of all moving joints, degrees."""
    low, high = np.transpose(scene.range_deg)
    drawn = np.random.default_rng(seed).uniform(low, high, (runs, 2, len(low)))
    return [(tuple(start), tuple(demonstrator)) for start, demonstrator in drawn.tolist()]


def grid_pairs(scene: Scene, counts: Sequence[int]) -> list[Pair]:
    """Return starts on a grid over the range, `counts` for each joint, with the scene's demonstrator, degrees."""
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
    context: Context | None = None,
    rehearsed: int = 0,
) -> list[Success]:
    """Run every transfer and servo from every pair of start and demonstrator.

    rehearsed: postures in which the learner calibrates itself first, drawn for every pair. See also `run_cases`.
    """
    replace = msgspec.structs.replace
    tasks = [
        [
            (
                replace(settings, transfer=name, start_deg=start, demonstrator_deg=demo),
                servos,
                max_motions,
                rehearsed,
                k,
            )
            for k, (start, demo) in enumerate(pairs)
        ]
        for name in transfers
    ]
    found = run_cases(run_pair, tasks, context, f"success, {', '.join(transfers)}")
    return [
        summary(name, servo, max_motions, [runs[s] for runs in of_transfer])
        for name, of_transfer in zip(transfers, found)
        for s, servo in enumerate(servos)
    ]


def run_pair(
    settings: Settings, servos: Sequence[str], max_motions: int, rehearsed: int = 0, seed: int = 0
) -> list[Run]:
    """Run each servo from the settings' start to their demonstrator. seed: of the postures of a rehearsal."""
    session = Session(msgspec.structs.replace(settings, servo=servos[0]), open_eyes=shared_eyes)
    if rehearsed:
        session.calibrate(rehearsed, seed)
    targets = dict(zip(TARGETS, (own_minimum(session), session.snapshot.theta_demo)))
    bias = _error_deg(*targets.values())
    runs = []
    for servo in servos:
        if rehearsed or servo != session.settings.servo:  # otherwise it has just begun
            session.begin(msgspec.structs.replace(settings, servo=servo))
        last = session.run(max_motions, patience=1).last
        visited = np.array([snapshot.theta for snapshot in session.history])
        errors = {name: _error_deg(visited, target) for name, target in targets.items()}
        ended, nearest = ({name: float(pick(e)) for name, e in errors.items()} for pick in (lambda e: e[-1], np.min))
        runs.append(Run(last.motion, last.status.is_claim, ended, nearest, float(bias)))
    return runs


def own_minimum(session: Session) -> NDArray[np.float64]:
    """Find the posture with the smallest E for the demonstrator as now seen, (2,) rad, on a grid of FINE_STEP_DEG.

    Finer grids around the local minima of a coarse one are searched. NaN if too few points are seen.
    """
    views, fit, world = session.snapshot.views, session.snapshot.fit, session.world
    over = lambda axes: landscape_over(world, fit, views.demo, views.visible[:, :2], axes)
    degrees, axes, images = _grids(world)
    places = Landscape(axes, *conflict_of_images(fit, views.demo, views.visible[:, :2], *images)).local_minima()
    if not len(places):
        return np.full(2, np.nan)
    about = [
        over(tuple(a[np.abs(a - at) <= np.radians(SEARCH_RADII_DEG[0])] for a, at in zip(degrees, p))) for p in places
    ]
    lowest = min(about, key=lambda found: np.nanmin(found.E)).minimum
    for step, around in zip((FINER_STEP_DEG, FINE_STEP_DEG), SEARCH_RADII_DEG[1:]):
        offsets = np.radians(np.arange(-around, around + step / 2, step))
        lowest = over(
            tuple(
                np.unique(np.clip(at + offsets, low, high))
                for at, low, high in zip(lowest, session.scene.lower, session.scene.upper)
            )
        ).minimum
    return lowest


@lru_cache(1)  # the same for every run of a study
def _grids(world: World) -> tuple[tuple[NDArray, NDArray], tuple[NDArray, NDArray], tuple[NDArray, NDArray]]:
    """Axes of grids of 1° and of COARSE_STEP_DEG, rad, and the learner's images over the latter."""
    coarse = grid_axes(world, step_deg=COARSE_STEP_DEG)
    return grid_axes(world), coarse, world.own_images((coarse[0][:, None], coarse[1]))


def summary(transfer: str, servo: str, max_motions: int, runs: Sequence[Run]) -> Success:
    """Count the runs of one transfer and servo."""
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


def success_table(results: list[Success], pairs: str) -> str:
    """Lay out the results for people: a block for each target, then motions and claims."""
    lines = [
        f"{pairs}, at most {results[0].max_motions} motions",
        "share of runs, largest joint error (in brackets the 95 % confidence interval)",
    ]
    most = WITHIN_DEG[-1]
    for target, title in TARGETS.items():
        lines.append(_line(title, "", *(f"ended ≤{near:g}°" for near in WITHIN_DEG), f"came ≤{most:g}°"))
        lines += [_line(r.transfer, r.servo, *r.ended[target].values(), r.came[target][most]) for r in results]
    lines.append(_line("motions and claims", "", "median", "95 %", "claimed", f"falsely, >{FALSE_DEG:g}°"))
    for r in results:
        motions = f"{r.motions_median:.0f}", f"{r.motions_95:.0f}"
        lines.append(_line(r.transfer, r.servo, *motions, r.claimed, r.claimed_falsely))
    lines.append("from the transfer's own minimum to the demonstrator")
    for r in {r.transfer: r for r in results}.values():
        lines.append(f"  {r.transfer:<12}median {r.bias_deg_median:.2f}°, 95 % within {r.bias_deg_95:.2f}°")
    return "\n".join(lines)


def _line(first: str, second: str, *cells: object) -> str:
    """A heading, without a second word, or a row below it."""
    name = f"  {first:<12}{second:<18}" if second else f"{first:<32}"
    return name + "".join(f"{cell!s:>17}" for cell in cells)


def _error_deg(theta: NDArray, target: NDArray) -> NDArray:
    """Largest joint error. theta: (..., m) rad → (...) degrees."""
    return np.degrees(np.abs(theta - target)).max(-1)
