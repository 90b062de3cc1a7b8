"""Servo laws beside each other: the same bodies, images, noise and starts for all, a run of each, every motion counted.

All laws see E through the same transfer, make their own probes, and may make as many motions.
"""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass

import msgspec
import numpy as np

from ...loop.settings import Settings
from ...servo.status import ServoStatus
from ..executors.study import Study, each
from .compare_draws import CASES, Case, drawn
from .compare_table import Row
from .robustness import PATIENCE


@dataclass(frozen=True)
class Ending:
    """Of one law's run: motions made; error_deg: largest joint error at the end; expected_deg: what the law says of
    that, NaN if nothing; E: px², NaN with too few points in sight."""

    motions: int
    status: ServoStatus
    error_deg: float
    expected_deg: float
    E: float


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
    with drawn(msgspec.structs.replace(settings, **case.changes), case, rng) as (session, begun):
        endings = []
        for servo in servos:
            session.begin(msgspec.structs.replace(begun, servo=servo))
            last = session.run(max_motions, PATIENCE).last
            error = np.degrees(np.abs(last.theta - last.theta_demo).max())
            expected = np.nan if last.expected_error is None else np.degrees(last.expected_error)
            endings.append(Ending(last.motion, last.status, float(error), float(expected), float(last.E)))
        return endings
