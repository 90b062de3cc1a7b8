"""What all benchmarks share: their options, the runs of their cases, shares with their intervals, and tables."""

import contextlib
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import asdict, dataclass, field
from statistics import NormalDist
from typing import Annotated, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ...loop.history import MAX_HISTORY
from ...loop.self_calibration import MIN_POSTURES
from ...loop.settings import FIELDS, MAX_SEED, USUAL_POINTS, Setting, Settings
from ...loop.snapshot import Snapshot
from ...simulation.scene import Scene, load_scene
from ..executors import LocalPool, Study

WITHIN_DEG = (0.5, 1.0, 3.0)  # largest joint errors up to which runs are counted
FALSE_DEG = 1.0  # by `is_false`, a claim is false if it is farther off,
N_SIGMA = 3.0  # and by more than this many times what the learner expects
PATIENCE = 20  # looks in a row with too few points after which a run ends
CONFIDENCE = 0.95
RESAMPLES, BOOTSTRAP_SEED = 2000, 0
MAX_RUNS, MAX_REHEARSED = 10_000_000, 200

Progress = Callable[[float], None]  # receives the share done


def no_progress(share: float) -> None:
    """Show nothing."""


class OptionError(ValueError):
    """An option of a benchmark is wrong; the message names the option."""


@contextlib.contextmanager
def option(name: str) -> Iterator[None]:
    """Report errors of files and values as errors of this option."""
    try:
        yield
    except OSError as error:
        raise OptionError(f"{name}: {error.filename}: {error.strerror}" if error.filename else str(error)) from None
    except ValueError as error:
        raise OptionError(f"{name}: {error}") from None


RUNS = Setting(description="random starts and demonstrators", unit="N", bounds=(1, MAX_RUNS))
MaxMotions = Annotated[int, Setting(description="motions of a run, at most", unit="N", bounds=(0, MAX_HISTORY))]
Rehearsed = Annotated[
    int,
    Setting(
        description="postures in which a servo that can use it calibrates itself first; their motions do not count",
        unit="N",
        bounds=(MIN_POSTURES, MAX_REHEARSED),
    ),
]


@dataclass
class Context:
    """Where the runs of a benchmark are made, and how its progress is shown."""

    study: Study = field(default_factory=Study)  # its result does not depend on it
    progress: Callable[[str], AbstractContextManager[Progress]] = lambda name: nullcontext(no_progress)
    show: Callable[[str], None] = lambda line: None  # shows a line of the report as soon as it is known

    @classmethod
    def in_processes(cls, count: int) -> "Context":
        """Make the runs in `count` processes here; 1 is this one."""
        return cls(Study(LocalPool(count)))


@dataclass(frozen=True, kw_only=True)
class Benchmark:
    """A subcommand of `viewimit bench`: its fields are its options, its docstring is its help."""

    seed: Annotated[int, Setting(description="seed of all random numbers", unit="N", bounds=(0, MAX_SEED))] = 0
    distributed: ClassVar[bool] = True  # whether its runs can be made on a cluster and kept in a folder

    def run(self, context: Context) -> tuple[Any, str]:
        """Make the runs. Return the result as JSON has it, and as a text for people. Raises OptionError."""
        raise NotImplementedError


@dataclass(frozen=True, kw_only=True)
class SceneOptions(Benchmark):
    """Options of benchmarks in one scene."""

    scene: Annotated[str, FIELDS["scene"]] = Settings().scene
    points: Annotated[int | None, FIELDS["points"]] = None

    def load(self) -> tuple[Scene, int]:
        """Load the scene, and return the number of points of its layout, by default the usual one."""
        scene = load_scene(self.scene)
        return scene, scene.layout_near(USUAL_POINTS) if self.points is None else self.points


@dataclass(frozen=True, kw_only=True)
class RunOptions(Benchmark):
    """Options of benchmarks with random runs."""

    runs: Annotated[int, RUNS] = 200


@dataclass(frozen=True, kw_only=True)
class MethodOptions(Benchmark):
    """Options of benchmarks of any method."""

    transfer: Annotated[str | None, FIELDS["transfer"]] = None
    servo: Annotated[str | None, FIELDS["servo"]] = None

    def method(self, **changes: Any) -> Settings:
        """Return the best settings with this transfer and servo, and one frame at each posture."""
        changes |= {name: value for name in ("transfer", "servo") if (value := vars(self)[name])}
        return Settings(frames=1, **changes)


@dataclass(frozen=True, kw_only=True)
class CaseOptions(Benchmark):
    """Options of benchmarks with several cases."""

    case: Annotated[
        str | None,
        Setting(description="case of this name, or those whose names contain it", unit="text", default="all"),
    ] = None
    cases: ClassVar[Sequence[Any]]  # each with a name

    def chosen_cases(self) -> list[Any]:
        """Return the case of this name, or those whose names contain it. Raises OptionError if there is none."""
        named = [case for case in self.cases if case.name == self.case]
        chosen = named or [case for case in self.cases if (self.case or "") in case.name]
        if not chosen:
            names = "; ".join(case.name for case in self.cases)
            raise OptionError(f"--case: none contains {self.case!r}: {names}")
        return chosen


def run_cases(
    work: Callable[..., Any], tasks: Sequence[Sequence[tuple[Any, ...]]], context: Context | None, title: str
) -> list[list[Any]]:
    """Call work(*task) for the tasks of every case, and return the results of each case.

    `work` declares the type of its result, so that a study can keep it. title: of the progress bar.
    """
    context = context or Context()
    flat, found = [task for of_case in tasks for task in of_case], []
    with context.progress(title) as progress:
        for result in context.study.each(work, flat):
            found.append(result)
            progress(len(found) / len(flat))
    results = iter(found)
    return [[next(results) for _ in of_case] for of_case in tasks]


def error_deg(last: Snapshot) -> float:
    """Return the largest joint error to the demonstrator, degrees."""
    return float(np.degrees(np.abs(last.theta - last.theta_demo)).max())


def expected_deg(last: Snapshot, unknown: float = np.nan) -> float:
    """Return the largest joint error that the learner itself expects, degrees."""
    return unknown if last.expected_error is None else float(np.degrees(last.expected_error))


def is_false(error: float, expected: float) -> bool:
    """Whether a claim with this error is false, degrees. expected: by the learner, NaN if it expects none."""
    return error > FALSE_DEG and not error <= N_SIGMA * expected


def rms(values: Any) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


@dataclass(frozen=True)
class Share:
    """A share of runs, with Wilson's score interval."""

    count: int
    runs: int
    share: float
    low: float
    high: float

    @classmethod
    def of(cls, happened: Iterable[bool]) -> "Share":
        """Count the true ones."""
        happened = list(happened)
        count, runs = sum(map(bool, happened)), len(happened)
        return cls(count, runs, count / runs, *wilson(count, runs))

    def __str__(self) -> str:
        """Such as 97 % (93–99), the interval rounded outwards; 0 and 100 % stand for none and all only."""
        text = f"{self.share:.0%}"
        if text == "100%" and self.count < self.runs:
            text = ">99%"
        elif text == "0%" and self.count > 0:
            text = "<1%"
        return f"{text[:-1]} % ({math.floor(100 * self.low)}–{math.ceil(100 * self.high)})"

    @property
    def with_tenths(self) -> str:
        """Such as 0.5 % (0.2–1.2), for small shares."""
        low, high = math.floor(1000 * self.low) / 10, math.ceil(1000 * self.high) / 10
        return f"{self.share:.1%} ({low:g}–{high:g})".replace("%", " %")


def shares_within(errors_deg: NDArray[np.float64], limits: Sequence[float] = WITHIN_DEG) -> dict[float, Share]:
    """Return, by limit in degrees, the share of errors up to it."""
    return {limit: Share.of(errors_deg <= limit) for limit in limits}


def wilson(count: int, runs: int) -> tuple[float, float]:
    """Return Wilson's score interval (1927) of a share, for CONFIDENCE."""
    z = NormalDist().inv_cdf((1 + CONFIDENCE) / 2)
    share, shrink = count / runs, 1 + z * z / runs
    middle = (share + z * z / (2 * runs)) / shrink
    half = z / shrink * math.sqrt(share * (1 - share) / runs + (z / (2 * runs)) ** 2)
    return middle - half if count else 0.0, middle + half if count < runs else 1.0


@dataclass(frozen=True)
class Interval:
    """An estimate and its interval for CONFIDENCE."""

    value: float
    low: float
    high: float

    def text(self, digits: int, unit: str = "") -> str:
        """Such as 0.02° (0.01–0.03), the interval rounded outwards."""
        scale = 10**digits
        low, high = math.floor(self.low * scale) / scale, math.ceil(self.high * scale) / scale
        dash = "–" if low >= 0 else " to "
        return f"{self.value:.{digits}f}{unit} ({low:.{digits}f}{dash}{high:.{digits}f})"

    @property
    def percentage_points(self) -> str:
        """A difference of shares, such as +8 % (+2 to +15), the interval rounded outwards."""
        return f"{100 * self.value:+.0f} % ({math.floor(100 * self.low):+d} to {math.ceil(100 * self.high):+d})"


def of_median(values: NDArray[np.float64]) -> Interval:
    """Return the median of values (n,), n ≥ 1, with its bootstrap interval."""
    return of_percentile(values, 50.0)


def of_percentile(values: NDArray[np.float64], percent: float) -> Interval:
    """Return a percentile of values (n,), n ≥ 1, with its bootstrap interval (percentile method, Efron 1979)."""
    chosen = np.random.default_rng(BOOTSTRAP_SEED).integers(len(values), size=(RESAMPLES, len(values)))
    tail = 50.0 * (1 - CONFIDENCE)
    low, high = np.percentile(np.percentile(values[chosen], percent, axis=-1), (tail, 100 - tail))
    return Interval(float(np.percentile(values, percent)), float(low), float(high))


def paired_difference(first: NDArray[np.bool_], second: NDArray[np.bool_]) -> Interval:
    """Return the difference of two shares of the same n draws, (n,) each.

    The interval is Newcombe's score interval for paired data (Statistics in Medicine 17, 1998, method 10).
    """
    n = len(first)
    both, neither = int((first & second).sum()), int((~first & ~second).sum())
    only_first, only_second = int((first & ~second).sum()), int((~first & second).sum())
    p, q = (both + only_first) / n, (both + only_second) / n
    (p_low, p_high), (q_low, q_high) = wilson(both + only_first, n), wilson(both + only_second, n)
    margins = float(both + only_first) * (only_second + neither) * (both + only_second) * (only_first + neither)
    product = float(both * neither - only_first * only_second)
    if product > 0:
        product = max(product - n / 2, 0.0)  # correction for continuity
    phi = product / margins**0.5 if margins else 0.0
    below = (p - p_low) ** 2 - 2 * phi * (p - p_low) * (q_high - q) + (q_high - q) ** 2
    above = (p_high - p) ** 2 - 2 * phi * (p_high - p) * (q - q_low) + (q - q_low) ** 2
    return Interval(p - q, p - q - below**0.5, p - q + above**0.5)


def table(columns: Sequence[tuple[str, int]], rows: Iterable[tuple[str, Sequence[object]]], names: int = 44) -> str:
    """Lay out rows, each a name and its cells, below headings with their widths; a dash stands for None.

    names: width of the names.
    """
    heads, widths = zip(*columns)
    line = lambda cells: "".join(f"{'–' if cell is None else str(cell):>{width}}" for cell, width in zip(cells, widths))
    return "\n".join([" " * (names + 2) + line(heads), *(f"  {name:<{names}}" + line(cells) for name, cells in rows)])


def as_json(outcomes: Iterable[Any]) -> list[dict[str, Any]]:
    """Return dataclasses as dictionaries."""
    return [asdict(outcome) for outcome in outcomes]
