"""What the runs of servo laws tell of each: shares and percentiles with their intervals, and differences from the
paper's law on the same draws."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .compare_table import Row
from .intervals import Interval, of_median, of_percentile, paired_difference
from .success import FALSE_DEG, Share

PAPER_LAW = "gradient"
WITHIN_DEG = (0.5, 1.0)
HIGH = 95.0  # percentile


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


def compared(rows: Sequence[Row]) -> list[Compared]:
    """By case and law, in the order of the rows."""
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
