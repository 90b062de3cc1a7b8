"""The engine of all studies: a case opens sessions from random draws, each run leaves one record, and records are
summarised, laid out and kept in one way.

A case is a name and a function from a `Draw` to a `Session`. Cases form groups, the subcommands of `viewimit bench`.
A claim is false if it is more than FALSE_DEG and more than N_SIGMA expected errors off, in every table.
"""

import hashlib
import importlib
import os
import sys
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from ...estimation.transfers import TRANSFERS
from ...loop.session import Session
from ...loop.settings import Settings, UnknownMethod
from ...loop.simulated_robot import OpenEyes
from ...loop.snapshot import RunResult
from ...servo import SERVOS, ServoMethod, ServoStatus, servo_method
from ...simulation.eyes import open_eyes
from ..executors import LIBRARY, Study
from .intervals import Interval, Share, of_median, of_percentile, paired_difference, rms, share_of

WITHIN_DEG = (0.5, 1.0, 3.0)  # largest joint errors up to which runs are counted
NEAR_DEG = WITHIN_DEG[0]
FALSE_DEG, N_SIGMA = 1.0, 3.0
N_SIGMA_COVERED = 2.0  # expected errors within which a claim is covered
HIGH_PERCENTILE = 95.0


@dataclass(frozen=True)
class Run:
    """One run. Errors are degrees."""

    case: str
    transfer: str
    servo: str
    number: int  # of the draw: the same for all servos of a case
    motions: int
    status: ServoStatus
    reason: str  # what the learner says of the demonstrator, or of the arm; "" for nothing
    errors_deg: tuple[float, ...]  # of each joint at the end; of the worst one alone in an earlier table
    expected_deg: float  # of the worst joint, by the learner; NaN if it says nothing
    E_px2: float  # NaN with too few points in sight
    travel_deg: float  # sum over all motions of the joint that moved most
    cpu_s: float  # of the motions
    ended: bool  # whether it came to rest, or gave up, before the last motion allowed
    kept: bool  # whether it ends as the case promises
    measures: dict[str, float]  # what the case measures beside

    @property
    def error_deg(self) -> float:
        """Of the worst joint."""
        return max(self.errors_deg)

    @property
    def claimed(self) -> bool:
        return self.status.is_claim

    @property
    def false(self) -> bool:
        """Whether it is a false claim."""
        return self.claimed and self.is_off(FALSE_DEG)

    def is_off(self, least_deg: float) -> bool:
        """Whether it ended farther off than this and than N_SIGMA expected errors, of which NaN excuses none."""
        return self.error_deg > least_deg and not self.error_deg <= N_SIGMA * self.expected_deg


def arrives(run: Run) -> bool:
    """Promise of most cases."""
    return run.error_deg <= NEAR_DEG


def claims_nothing(run: Run) -> bool:
    """Promise of a case that does not determine the posture."""
    return not run.claimed


def claims_nothing_false(run: Run) -> bool:
    """Promise of a case that may not determine the posture."""
    return not run.false


@dataclass(frozen=True)
class Says:
    """Promise of a case: the learner gives this reason, and no false claim."""

    word: str

    def __call__(self, run: Run) -> bool:
        return run.reason == self.word and not run.false


@dataclass
class Draw:
    """What a case opens a session from."""

    settings: Settings  # transfer, servo, scene and layout that were asked for
    number: int  # of the draw
    seed: int  # of the study
    rng: np.random.Generator
    law: ServoMethod | None = None  # a servo that the settings cannot name
    max_motions: int = 0  # of the run
    notes: dict[str, Any] = field(default_factory=dict)  # what `open` and `drive` leave for `measure`

    def session(self, open_eyes: OpenEyes = open_eyes, **changes: Any) -> Session:
        """Open a session with these fields of `Settings` changed."""
        return Session(msgspec.structs.replace(self.settings, **changes), open_eyes=open_eyes, servo=self.law)


def of_run(seed: int, number: int) -> np.random.Generator:
    """Return the generator of a run, which depends on nothing else."""
    return np.random.default_rng([seed, number])


def until_rest(session: Session, draw: Draw, max_motions: int, patience: int) -> RunResult:
    """Run until the servo rests."""
    return session.run(max_motions, patience)


def nothing(session: Session, draw: Draw) -> dict[str, float]:
    """Measure nothing beside."""
    return {}


@dataclass(frozen=True)
class Case:
    """A condition under which runs are made. Its functions are of a module, so that other processes find them."""

    name: str
    open: Callable[[Draw], Session]
    promises: Callable[[Run], bool] = arrives
    drive: Callable[[Session, Draw, int, int], RunResult] = until_rest
    measure: Callable[[Session, Draw], dict[str, float]] = nothing  # at the end, not counted as the run's CPU
    max_motions: int = 80
    patience: int = 20  # looks in a row with too few points after which a run ends
    max_runs: int | None = None  # of all draws, the first ones
    unnamed: bool = False  # whether it is for servos alone that find which point is which
    generator: Callable[[int, int], np.random.Generator] = of_run


Measures = Mapping[str, Callable[[Sequence[Run]], Any]]


def best_method(transfer: str | None, servos: Sequence[str]) -> list[tuple[str, str]]:
    """Return the transfers and servos of a group: those asked for, else the best ones."""
    return [(transfer or Settings().transfer, servo) for servo in servos or [Settings().servo]]


@dataclass(frozen=True)
class Group:
    """Cases that are one subcommand of `viewimit bench`."""

    title: str  # for help
    cases: Sequence[Case] = ()
    settings: Settings = Settings(frames=1)
    methods: Callable[[str | None, Sequence[str]], list[tuple[str, str]]] = best_method
    measures: Measures = field(default_factory=dict)  # columns beside the common ones, of the runs of a row
    runs: int = 200
    in_scene: bool = False  # whether --scene and --n-points apply
    of_folder: Callable[[Path], Sequence[Case]] | None = None  # makes the cases of a folder


def own_servo(name: str) -> ServoMethod | None:
    """Return the servo MODULE:OBJECT; None for one of SERVOS, which settings name. Raises UnknownMethod."""
    module, colon, attribute = name.partition(":")
    if name in SERVOS:
        return None
    if not colon:
        raise UnknownMethod(f"no servo {name!r}; there are {', '.join(SERVOS)}, or MODULE:OBJECT of your own")
    if "" not in sys.path and os.getcwd() not in sys.path:
        sys.path.insert(0, os.getcwd())  # as of `python -m`: a command's first place is the folder that it is in
    try:
        given = getattr(importlib.import_module(module), attribute)
        return servo_method(given() if isinstance(given, type) else given)
    except (ImportError, AttributeError, TypeError) as error:
        raise UnknownMethod(f"{name}: {error}") from None


def cannot_run(case: Case, servo: str) -> str:
    """Return in a line why a servo has no runs of a case; nothing if it has. Raises UnknownMethod."""
    needs_names = not (own_servo(servo) or SERVOS[servo]).names_points
    return f"{case.name}: {servo} needs points with names" if case.unnamed and needs_names else ""


def own_files(servos: Sequence[str], cases: Sequence[Case]) -> dict[str, str]:
    """Return a hash of each file, not of this library, that has a servo, a transfer or a case: {"lab.py": "3f…"}."""
    methods = [type((own_servo(name) or SERVOS[name]).servo) for name in (*SERVOS, *servos)]
    functions = [getattr(case.open, "func", case.open) for case in cases]
    modules = {one.__module__ for one in (*methods, *functions, *(method.fit for method in TRANSFERS.values()))}
    files = [Path(getattr(sys.modules.get(module), "__file__", None) or "") for module in modules]
    own = [file.resolve() for file in files if file.is_file() and LIBRARY not in file.resolve().parents]
    return {file.name: hashlib.sha256(file.read_bytes()).hexdigest()[:12] for file in own}


def run_once(
    case: Case, settings: Settings, servo: str, seed: int, number: int, max_motions: int, rehearsed: int = 0
) -> Run:
    """Make one run of a case by this servo."""
    law = own_servo(servo)
    settings = settings if law else msgspec.structs.replace(settings, servo=servo)
    draw = Draw(settings, number, seed, case.generator(seed, number), law, max_motions)
    session = case.open(draw)
    if rehearsed:
        session.calibrate(rehearsed, number)
        session.reset()
    began = time.thread_time()
    result = case.drive(session, draw, max_motions, case.patience)
    cpu_s = time.thread_time() - began
    last = session.snapshot
    run = Run(
        case=case.name,
        transfer=settings.transfer,
        servo=servo,
        number=number,
        motions=result.motions,
        status=last.status,
        reason="" if last.misfit is None else str(last.misfit.kind),
        errors_deg=tuple(np.degrees(np.abs(last.theta - last.theta_demo)).tolist()),
        expected_deg=np.nan if last.expected_error is None else float(np.degrees(last.expected_error)),
        E_px2=float(last.E),
        travel_deg=float(np.degrees(result.travel)),
        cpu_s=cpu_s,
        ended=result.motions < max_motions,
        kept=False,
        measures=case.measure(session, draw),
    )
    return replace(run, kept=bool(case.promises(run)))


def run_one(group: Group, name: str, number: int, seed: int = 0, **changes: Any) -> Run:
    """Make one run of the case of this name, by the group's own method; fields of `Settings` may differ."""
    (case,) = [case for case in group.cases if case.name == name]
    ((transfer, servo), *_) = group.methods(None, ())
    settings = msgspec.structs.replace(group.settings, transfer=transfer, **changes)
    return run_once(case, settings, servo, seed, number, case.max_motions)


def run_cases(
    group: Group,
    cases: Sequence[Case],
    study: Study,
    *,
    methods: Sequence[tuple[str, str]] = (),
    settings: Settings | None = None,
    runs: int | None = None,
    seed: int = 0,
    max_motions: int | None = None,
    rehearsed: int = 0,
    progress: Callable[[float], None] = lambda share: None,
) -> list[Run]:
    """Make the runs of these cases by every transfer and servo that can, from the same draws. Raises StudyError."""
    settings, tasks = settings or group.settings, []
    for case in cases:
        for transfer, servo in methods or group.methods(None, ()):
            if cannot_run(case, servo):
                continue
            changed = msgspec.structs.replace(settings, transfer=transfer)
            most = case.max_motions if max_motions is None else max_motions
            count = runs or group.runs
            for number in range(min(count, case.max_runs or count)):
                tasks.append((case, changed, servo, seed, number, most, rehearsed))
    return study.map(run_once, tasks, progress)


def chosen(cases: Sequence[Any], name: str | None) -> list[Any]:
    """Return the case of this name, or those whose names contain it. Raises ValueError if there is none."""
    named = [case for case in cases if case.name == name]
    found = named or [case for case in cases if (name or "") in case.name]
    if not found:
        raise ValueError(f"none contains {name!r}: {'; '.join(case.name for case in cases)}")
    return found


@dataclass(frozen=True)
class Less:
    """How much better than by the first servo, from the same draws: medians of differences."""

    near: Interval  # difference of the shares within NEAR_DEG
    error_deg: Interval
    motions: Interval


@dataclass(frozen=True)
class Summary:
    """The runs of one case by one transfer and servo. None: no run to count."""

    case: str
    transfer: str
    servo: str
    runs: int
    kept: Share  # of all runs: those that end as the case promises
    within: dict[float, Share]  # by degrees: shares of runs that ended so near
    claimed: Share
    beyond: Share | None  # more than FALSE_DEG off, of claims
    false: Share | None  # and more than N_SIGMA expected errors, of claims
    covered: Share | None  # within N_SIGMA_COVERED expected errors, of claims
    unended: Share
    motions: Interval
    motions_95: Interval
    motions_most: int
    error_deg: Interval  # of the worst joint
    error_95_deg: Interval
    rms_deg: float
    claims_rms_deg: float | None
    expected_deg: float | None  # rms of claims
    travel_deg: float  # median
    cpu_s: float  # median
    statuses: dict[str, int]
    reasons: dict[str, int]
    less: Less | None  # None for the first servo of a case
    measures: dict[str, Any]


def summarise(runs: Sequence[Run], measures: Measures) -> list[Summary]:
    """Summarise runs by case, transfer and servo. Raises ValueError for a servo that lacks runs."""
    rows: dict[tuple[str, str, str], list[Run]] = {}
    for run in runs:
        rows.setdefault((run.case, run.transfer, run.servo), []).append(run)
    first: dict[tuple[str, str], list[Run]] = {}
    return [_summary(row, first.setdefault(key[:2], row), measures) for key, row in rows.items()]


def _summary(runs: Sequence[Run], first: Sequence[Run], measures: Measures) -> Summary:
    column = lambda name, of=runs: np.array([getattr(run, name) for run in of], float)
    error, motions, claims = column("error_deg"), column("motions"), [run for run in runs if run.claimed]
    less = None
    if first is not runs:
        if [run.number for run in first] != [run.number for run in runs]:
            raise ValueError(f"{runs[0].case}: {runs[0].servo} and {first[0].servo} have not the same runs")
        less = Less(
            paired_difference(error <= NEAR_DEG, column("error_deg", first) <= NEAR_DEG),
            of_median(column("error_deg", first) - error),
            of_median(column("motions", first) - motions),
        )
    return Summary(
        case=runs[0].case,
        transfer=runs[0].transfer,
        servo=runs[0].servo,
        runs=len(runs),
        kept=Share.of(run.kept for run in runs),
        within={limit: Share.of(error <= limit) for limit in WITHIN_DEG},
        claimed=Share.of(run.claimed for run in runs),
        beyond=share_of([run.error_deg > FALSE_DEG for run in claims]),
        false=share_of([run.false for run in claims]),
        covered=share_of([run.error_deg <= N_SIGMA_COVERED * run.expected_deg for run in claims]),
        unended=Share.of(not run.ended for run in runs),
        motions=of_median(motions),
        motions_95=of_percentile(motions, HIGH_PERCENTILE),
        motions_most=int(motions.max()),
        error_deg=of_median(error),
        error_95_deg=of_percentile(error, HIGH_PERCENTILE),
        rms_deg=rms(error),
        claims_rms_deg=rms([run.error_deg for run in claims]) if claims else None,
        expected_deg=rms([run.expected_deg for run in claims]) if claims else None,
        travel_deg=float(np.median(column("travel_deg"))),
        cpu_s=float(np.median(column("cpu_s"))),
        statuses=dict(Counter(str(run.status) for run in runs)),
        reasons=dict(Counter(run.reason for run in runs if run.reason)),
        less=less,
        measures={name: found for name, of in measures.items() if (found := of(runs)) is not None},
    )
