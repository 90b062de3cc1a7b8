"""Servo laws side by side: each runs on the same bodies, images, noise and starts, and every motion counts.

All laws see E through the same transfer, make their own probing motions, may make as many motions, and may begin again
as often: the trust region by itself, the others by `Restarts`. Beside them are ORACLES: calibrated visual servoing,
which is given the arm and the cameras, and descends once.
"""

import csv
from collections import ChainMap
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any, get_type_hints

import msgspec
import numpy as np
from numpy.typing import NDArray

from ...loop.session import Session
from ...loop.settings import OWN, Setting, Settings
from ...servo import SERVOS, ServoMethod
from ...servo.status import ServoStatus
from ...simulation.eyes import ProjectedEyes
from ...simulation.robot import BodyPoints
from ...simulation.scene import Scene, load_scene
from ..experiment import write_csv
from .benchmark import (
    FALSE_DEG,
    PATIENCE,
    WITHIN_DEG,
    CaseOptions,
    Context,
    Interval,
    MaxMotions,
    MethodOptions,
    RunOptions,
    SceneOptions,
    Share,
    as_json,
    error_deg,
    expected_deg,
    of_median,
    of_percentile,
    option,
    paired_difference,
    run_cases,
    shares_within,
    table,
)
from .calibrated import ORACLES, CalibratedServo
from .draws import MAX_BODIES, SurfaceEyes, draw_postures, draw_scene, surface_points
from .generative import Generative
from .restarts import Restarts
from .robustness import SEVEN
from .scenes import open_resized, scene_file

LITERATURE = {"generative": ServoMethod(servo=Generative(), predicts=True)}  # further laws, for this comparison alone
PAPER_LAW, OWN_RESTARTS = "gradient", {"trust-region"}  # laws that begin again by themselves
HIGH_PERCENTILE = 95.0
TABLE, PAGE = "comparison.csv", "comparison.md"
MARKS = "<!-- begin of the table -->", "<!-- end of the table -->"
COMPARED_SERVO = Setting(
    description="control law beside the paper's; an oracle is given the URDF and the calibrated cameras",
    default="all",
    choices=ChainMap[str, Any](ORACLES, LITERATURE, SERVOS),
)


@dataclass(frozen=True)
class Case:
    """A condition under which runs are made."""

    name: str
    changes: dict[str, Any]  # of the settings
    any_head: bool = False  # in a new random scene for each run
    hidden: int | None = None  # points on the surface, seen where it faces the camera; None: the scene's layout
    offset_deg: float | None = None  # largest distance of the start from the demonstrator; None: anywhere
    max_runs: int | None = None  # of all draws, the first ones; None: all of them


CASES = (
    Case("default scene", {}),
    Case("toed-in heads", {}, any_head=True),
    Case("noise 0.5 px, 25 frames", {"noise_px": 0.5, "frames": 25}),
    Case("20 points, hidden by surfaces", {}, hidden=20),
    Case("seven joints, ±30°, 16 points", {"joints": SEVEN, "points": 16}, offset_deg=30.0, max_runs=96),
)


@dataclass(frozen=True)
class Row:
    """One run of one law, as the CSV has it."""

    case: str
    run: int  # of the case: the same draw for all laws
    servo: str
    motions: int
    status: ServoStatus
    error_deg: float  # largest joint error at the end
    expected_deg: float  # what the law says of it, NaN if nothing
    E_px2: float  # NaN with too few points in sight


@dataclass(frozen=True)
class Compared:
    """The runs of one law in one case. The last three are differences from the paper's law, None for itself."""

    case: str
    servo: str
    runs: int
    within: dict[float, Share]  # by degrees: shares of runs that ended so near
    motions_median: Interval
    motions_95: Interval
    error_median: Interval
    error_95: Interval
    claimed: Share
    falsely: Share  # claimed and more than FALSE_DEG off, whatever the law expects (unlike `is_false`), of all runs
    gained: Interval | None  # share within WITHIN_DEG[0] beyond the paper's law's
    error_less: Interval | None  # median of the reduction of the error, degrees
    motions_less: Interval | None  # median of the reduction of motions


@dataclass(frozen=True, kw_only=True)
class CompareBenchmark(SceneOptions, RunOptions, MethodOptions, CaseOptions):
    """All servo laws side by side, from the same draws."""

    path: Annotated[
        Path | None, Setting(description="table of runs that --csv has written, to be judged again", unit="path")
    ] = None
    servo: Annotated[str | None, COMPARED_SERVO] = None
    max_motions: MaxMotions = 200
    csv: Annotated[Path | None, Setting(description="file that keeps every run, a row each", unit="file")] = None
    docs: Annotated[
        Path | None,
        Setting(description=f"folder where {TABLE} is written, and the table between the marks of {PAGE}", unit="dir"),
    ] = None
    cases = CASES

    def run(self, context: Context) -> tuple[Any, str]:
        """See `Benchmark.run`."""
        if self.path:
            with option("PATH"):
                rows = read(self.path)
                compared(rows)  # raises ValueError for a table that lacks runs
            heading = f"{self.path}"
        else:
            _, points = self.load()
            laws = (*SERVOS, *LITERATURE, *ORACLES)
            servos = [name for name in laws if self.servo in (None, name) or name == PAPER_LAW]
            plain = self if self.servo in SERVOS else replace(self, servo=None)
            transfer, cases = plain.method().transfer, self.chosen_cases()
            settings = Settings.paper(scene=self.scene, points=points, transfer=transfer)
            rows = run(settings, servos, self.runs, self.seed, self.max_motions, cases, context)
            heading = (
                f"{self.runs} random runs a case of every law, {transfer}, at most {self.max_motions} motions, "
                f"seed {self.seed}"
            )
        if self.csv:
            with option("--csv"):
                write(rows, self.csv)
        found = compared(rows)
        if self.docs:
            with option("--docs"):
                write(rows, self.docs / TABLE)
                write_between_marks(f"```text\n{compared_table(found)}\n```", self.docs / PAGE)
        return as_json(found), f"{heading}\n{compared_table(found)}"


def run(
    settings: Settings,
    servos: Sequence[str],
    runs: int,
    seed: int,
    max_motions: int,
    cases: Sequence[Case] = CASES,
    context: Context | None = None,
) -> list[Row]:
    """Run every case and law from the same draws. settings: the transfer. See also `run_cases`."""
    count = lambda case: min(runs, case.max_runs or runs)
    tasks = [[(settings, case, servos, [seed, k], max_motions) for k in range(count(case))] for case in cases]
    found = run_cases(run_draw, tasks, context, "compare")
    return [row for of_case in found for of_draw in of_case for row in of_draw]


def run_draw(settings: Settings, case: Case, servos: Sequence[str], seed: list[int], max_motions: int) -> list[Row]:
    """Run each law from one draw; the last number of its seed is that of the run."""
    rng = np.random.default_rng(seed)
    oracle, rows = CalibratedServo(), []
    lent = ServoMethod(servo=oracle, mirror_columns=True)
    with _drawn(msgspec.structs.replace(settings, **case.changes), case, rng, lent) as (session, begun):
        oracle.session = session
        for servo in servos:
            if servo in ORACLES:
                oracle.become(ORACLES[servo], seed)
                lent.servo, lent.predicts = oracle, False
            elif servo not in OWN_RESTARTS:
                method = ChainMap(LITERATURE, SERVOS)[servo]
                lent.servo, lent.predicts = Restarts(method, tuple(seed), max_motions), True
            session.begin(msgspec.structs.replace(begun, servo=servo if servo in OWN_RESTARTS else OWN))
            last = session.run(max_motions, PATIENCE).last
            errors = error_deg(last), expected_deg(last), float(last.E)
            rows.append(Row(case.name, seed[-1], servo, last.motion, last.status, *errors))
        return rows


@contextmanager
def _drawn(
    settings: Settings, case: Case, rng: np.random.Generator, lent: ServoMethod
) -> Iterator[tuple[Session, Settings]]:
    """Draw a session, and the settings that all laws begin with. lent: the session's own servo."""
    if case.any_head:
        drawn = draw_scene(rng, any_head=True)
        with scene_file(drawn) as path:
            settings = msgspec.structs.replace(settings, scene=path, points=drawn.points)
            session = Session(settings, open_eyes=partial(open_resized, size=drawn.size), servo=lent)
            yield session, _with_postures(settings, case, session.scene, rng)
    elif case.hidden is not None:
        scene = load_scene(settings.scene)
        begun = _with_postures(settings, case, scene, rng)
        for _ in range(MAX_BODIES):
            body = surface_points(scene.robot, range(len(scene.posture_deg) + 1), case.hidden, rng)
            session = Session(begun, open_eyes=partial(_open_surface, body=body), servo=lent)
            if session.snapshot.transfer is not None:
                break
        yield session, begun
    else:
        session = Session(settings, servo=lent)
        yield session, _with_postures(settings, case, session.scene, rng)


def _with_postures(settings: Settings, case: Case, scene: Scene, rng: np.random.Generator) -> Settings:
    postures = draw_postures(scene, rng, case.offset_deg)
    return msgspec.structs.replace(settings, seed=int(rng.integers(2**32)), **postures)


def _open_surface(camera: str, scene: Scene, points: int, body: tuple[BodyPoints, NDArray]) -> ProjectedEyes:
    return SurfaceEyes(scene, *body)


def write(rows: Sequence[Row], path: Path) -> None:
    """Write a CSV file, a row for each run. Raises OSError."""
    write_csv(path, {name: np.array([getattr(row, name) for row in rows]) for name in Row.__dataclass_fields__})


def write_between_marks(text: str, page: Path) -> None:
    """Replace what is between the MARKS of a page. Raises OSError, or ValueError for a page without them."""
    begin, end = MARKS
    before, found, rest = page.read_text("utf-8").partition(begin)
    _, found_end, after = rest.partition(end)
    if not (found and found_end):
        raise ValueError(f"{page}: lacks the marks {begin} and {end}, between which the table is written")
    page.write_text(f"{before}{begin}\n\n{text}\n\n{end}{after}", "utf-8")


def read(path: Path) -> list[Row]:
    """Read what `write` has written. Raises OSError, or ValueError that names the line."""
    kinds = get_type_hints(Row)
    with path.open(newline="", encoding="utf-8") as file:
        lines = csv.DictReader(file)
        if lines.fieldnames is None or list(lines.fieldnames) != list(kinds):
            raise ValueError(
                f"{path}: is no table of runs that --csv has written: its heading is not {','.join(kinds)}"
            )
        rows = []
        for line in lines:
            try:
                cells = {name: kind(line[name] or "nan") for name, kind in kinds.items()}
            except (TypeError, ValueError) as error:
                raise ValueError(f"{path}: line {lines.line_num}: {error}") from None
            rows.append(Row(**cells))
    if not rows:
        raise ValueError(f"{path}: holds no runs")
    return rows


def compared(rows: Sequence[Row]) -> list[Compared]:
    """Summarise runs by case and law, in the order of the rows. Raises ValueError for a law that lacks runs."""
    cells: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        cells.setdefault((row.case, row.servo), []).append(row)
    return [_compared(cell, cells.get((case, PAPER_LAW))) for (case, _), cell in cells.items()]


def _compared(cell: Sequence[Row], paper: Sequence[Row] | None) -> Compared:
    error, motions = _column(cell, "error_deg"), _column(cell, "motions")
    claimed = np.array([row.status.is_claim for row in cell])
    gained = error_less = motions_less = None
    if paper is not None and cell[0].servo != PAPER_LAW:
        if [row.run for row in paper] != [row.run for row in cell]:
            raise ValueError(f"{cell[0].case}: {cell[0].servo} and {PAPER_LAW} have not the same runs")
        theirs = _column(paper, "error_deg")
        gained = paired_difference(error <= WITHIN_DEG[0], theirs <= WITHIN_DEG[0])
        error_less, motions_less = of_median(theirs - error), of_median(_column(paper, "motions") - motions)
    return Compared(
        cell[0].case,
        cell[0].servo,
        len(cell),
        shares_within(error, WITHIN_DEG[:2]),
        of_median(motions),
        of_percentile(motions, HIGH_PERCENTILE),
        of_median(error),
        of_percentile(error, HIGH_PERCENTILE),
        Share.of(claimed),
        Share.of(claimed & (error > FALSE_DEG)),
        gained,
        error_less,
        motions_less,
    )


def _column(rows: Sequence[Row], name: str) -> NDArray:
    return np.array([getattr(row, name) for row in rows], float)


def compared_table(found: Sequence[Compared]) -> str:
    """Lay out the laws for people: a block for each case, a row for each law, with 95 % confidence intervals."""
    near = WITHIN_DEG[0]
    columns = [
        *((f"ended ≤{within:g}°", 17) for within in WITHIN_DEG[:2]),
        *(("motions", 16), ("95 %", 16), ("error", 24), ("95 %", 24), ("claimed", 17)),
        *(("false", 13), (f"≤{near:g}°, more", 22), ("error less", 22)),
    ]
    lines = [
        "largest joint error at the end; more, less: than by the paper's law from the same draws, share and median of "
        "differences; in brackets 95 % confidence intervals",
        f"claimed: of all runs; false: claimed and more than {FALSE_DEG:g}° off, of all runs; none: it made no claim",
    ]
    if any(cell.servo in ORACLES for cell in found):
        lines.append(
            "oracle: is given the URDF, the points on it, both bases and the cameras (1deg: each of them turned by 1°)"
        )
    for case in dict.fromkeys(o.case for o in found):
        laws = [o for o in found if o.case == case]
        rows = [
            (
                o.servo,
                (
                    *o.within.values(),
                    *(o.motions_median.text(0), o.motions_95.text(0)),
                    *(o.error_median.text(2, "°"), o.error_95.text(2, "°")),
                    *((o.claimed, o.falsely) if o.claimed.count else ("none", "none")),
                    o.gained and o.gained.percentage_points,
                    o.error_less and o.error_less.text(1, "°"),
                ),
            )
            for o in laws
        ]
        lines += [f"{case}, {laws[0].runs} runs a law", table(columns, rows, 18)]
    return "\n".join(lines)
