"""Servo laws beside each other: the same bodies, images, noise and starts for all, a run of each, every motion counted.

All laws see E through the same transfer, make their own probes, and may make as many motions. Differences are of the
same draw by two laws, to the paper's.
"""

import csv
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import get_type_hints

import msgspec
import numpy as np
from numpy.typing import NDArray

from ...session import Session
from ...settings import Settings
from ...simulation.eyes import ProjectedEyes
from ...simulation.robot import BodyPoints
from ...simulation.scene import Scene, load_scene
from ..executors.study import Study, each
from ..files import write_csv
from .intervals import Interval, of_median, of_percentile, paired_difference
from .random_scenes import draw
from .robustness import DEMO_DEG, PATIENCE, SEVEN
from .scenes import open_resized, written
from .success import FALSE_DEG, Share
from .surface import SurfaceEyes, surface_points

PAPER_LAW = "gradient"
WITHIN_DEG = (0.5, 1.0)
TRIES = 200  # bodies, for one with enough points in sight at both ends
HIGH = 95.0  # percentile


@dataclass(frozen=True)
class Case:
    """changes: of the settings; any_head: in scenes drawn anew for each run; hidden: so many points anywhere on the
    surface, seen where that faces the camera, None for the scene's layout; offset_deg: of the start from the
    demonstrator, None for anywhere."""

    name: str
    changes: dict
    any_head: bool = False
    hidden: int | None = None
    offset_deg: float | None = None


CASES = (
    Case("default scene", {}),
    Case("toed-in heads", {}, any_head=True),
    Case("noise 0.5 px, 25 frames", {"noise_px": 0.5, "frames": 25}),
    Case("20 points, hidden by surfaces", {}, hidden=20),
    Case("seven joints, ±30°, 16 points", {"joints": SEVEN, "points": 16}, offset_deg=30.0),
)


@dataclass(frozen=True)
class Ending:
    """Of one law's run: motions made; error_deg: largest joint error at the end; expected_deg: what the law says of
    that, NaN if nothing; E: px², NaN with too few points in sight."""

    motions: int
    status: str
    error_deg: float
    expected_deg: float
    E: float


@dataclass(frozen=True)
class Row:
    """One run of one law, as the CSV has it. run: of the case, the same draw for all laws."""

    case: str
    run: int
    servo: str
    motions: int
    status: str
    error_deg: float
    expected_deg: float
    E_px2: float


@dataclass(frozen=True)
class Compared:
    """A law in a case. within: shares of runs that ended so near, degrees; falsely: of all runs, claimed and more than
    FALSE_DEG off.

    gained: share within WITHIN_DEG[0] beyond the paper's law's; error_less: median of how much less the error is than
    that of the paper's law from the same draw, degrees; motions_less: of motions. None for the paper's law itself.
    """

    case: str
    servo: str
    runs: int
    within: dict[float, Share]
    motions_median: Interval
    motions_95: Interval
    error_median: Interval
    error_95: Interval
    claimed: Share
    falsely: Share
    gained: Interval | None
    error_less: Interval | None
    motions_less: Interval | None


def run(
    settings: Settings,
    servos: Sequence[str],
    runs: int,
    seed: int,
    max_motions: int,
    cases: Sequence[Case] = CASES,
    workers: int | Study | None = None,
    tell: Callable[[float], None] = lambda share: None,
) -> list[Row]:
    """Of every case and law, from the same draws. settings: the transfer. tell(share done)."""
    tasks = [(settings, case, servos, [seed, k], max_motions) for case in cases for k in range(runs)]
    rows: list[Row] = []
    for (_, case, _, (_, k), _), endings in zip(tasks, each(run_draw, tasks, workers)):
        for servo, ending in zip(servos, endings):
            motions, status, *numbers = asdict(ending).values()
            rows.append(Row(case.name, k, servo, motions, status, *numbers))
        tell(len(rows) / (len(tasks) * len(servos)))
    return rows


def run_draw(settings: Settings, case: Case, servos: Sequence[str], seed: list[int], max_motions: int) -> list[Ending]:
    """A run of each law, from one draw."""
    rng = np.random.default_rng(seed)
    with _drawn(msgspec.structs.replace(settings, **case.changes), case, rng) as (session, begun):
        endings = []
        for servo in servos:
            session.begin(msgspec.structs.replace(begun, servo=servo))
            last = session.run(max_motions, PATIENCE)
            error = np.degrees(np.abs(last.theta - last.theta_demo).max())
            expected = np.nan if last.expected_error is None else np.degrees(last.expected_error)
            endings.append(Ending(last.motion, last.status, float(error), float(expected), float(last.E)))
        return endings


@contextmanager
def _drawn(settings: Settings, case: Case, rng: np.random.Generator) -> Iterator[tuple[Session, Settings]]:
    """A session, and the settings that all laws begin with."""
    if case.any_head:
        drawn = draw(rng, any_head=True)
        with written(drawn) as path:
            settings = msgspec.structs.replace(settings, scene=path, points=drawn.points)
            session = Session(settings, partial(open_resized, size=drawn.size))
            yield session, _begun(settings, case, session.scene, rng)
    elif case.hidden is not None:
        scene = load_scene(settings.scene)
        begun = _begun(settings, case, scene, rng)
        for _ in range(TRIES):
            body = surface_points(scene.robot, range(len(scene.posture_deg) + 1), case.hidden, rng)
            session = Session(begun, partial(_open_surface, body=body))
            if session.snapshot.transfer is not None:
                break
        yield session, begun
    else:
        session = Session(settings)
        yield session, _begun(settings, case, session.scene, rng)


def _begun(settings: Settings, case: Case, scene: Scene, rng: np.random.Generator) -> Settings:
    low, high = np.transpose(scene.range_deg)
    if case.offset_deg is None:
        demo, start = rng.uniform(low, high, (2, len(low)))
    else:
        rest = np.array(scene.posture_deg)[scene.moving]
        demo = np.clip(rest + rng.uniform(-DEMO_DEG, DEMO_DEG, len(low)), low, high)
        start = np.clip(demo + rng.uniform(-case.offset_deg, case.offset_deg, len(low)), low, high)
    postures = {"demonstrator_deg": tuple(demo.tolist()), "start_deg": tuple(start.tolist())}
    return msgspec.structs.replace(settings, seed=int(rng.integers(2**32)), **postures)


def _open_surface(camera: str, scene: Scene, points: int, body: tuple[BodyPoints, NDArray]) -> ProjectedEyes:
    return SurfaceEyes(scene, *body)


def compared(rows: Sequence[Row]) -> list[Compared]:
    """By case and law, in the order of the rows."""
    cells: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        cells.setdefault((row.case, row.servo), []).append(row)
    return [_compared(cell, cells.get((case, PAPER_LAW))) for (case, _), cell in cells.items()]


def _compared(cell: Sequence[Row], paper: Sequence[Row] | None) -> Compared:
    error, motions = _column(cell, "error_deg"), _column(cell, "motions")
    claimed = np.array([row.status == "converged" for row in cell])
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
        {near: Share.of(error <= near) for near in WITHIN_DEG},
        of_median(motions),
        of_percentile(motions, HIGH),
        of_median(error),
        of_percentile(error, HIGH),
        Share.of(claimed),
        Share.of(claimed & (error > FALSE_DEG)),
        gained,
        error_less,
        motions_less,
    )


def _column(rows: Sequence[Row], name: str) -> NDArray:
    return np.array([getattr(row, name) for row in rows], float)


def write(rows: Sequence[Row], path: Path) -> None:
    """As CSV, a row a run, which `read` reads. Raises OSError."""
    write_csv(path, {name: np.array([getattr(row, name) for row in rows]) for name in Row.__dataclass_fields__})


def read(path: Path) -> list[Row]:
    """Raises OSError, and ValueError that names the line."""
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
