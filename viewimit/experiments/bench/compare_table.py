"""The runs of compared laws as a table that is kept: a row a run."""

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import get_type_hints

import numpy as np

from ...servo.status import ServoStatus
from ..files import write_csv


@dataclass(frozen=True)
class Row:
    """One run of one law, as the CSV has it. run: of the case, the same draw for all laws."""

    case: str
    run: int
    servo: str
    motions: int
    status: ServoStatus
    error_deg: float
    expected_deg: float
    E_px2: float


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
