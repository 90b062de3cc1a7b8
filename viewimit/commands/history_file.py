"""The history of a run as a file: .csv, a row a motion with DIGITS, and .npz, its arrays in full."""

import csv
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..loop.history import History

TABLES = (".csv", ".npz")
DIGITS = 12  # of a number in a table: without those that conversion to degrees adds


def require_format(path: Path, others: Sequence[str] = ()) -> None:
    """Raises ValueError for an extension that is not written. others: that are written elsewhere."""
    suffix, there = path.suffix.lower(), (*TABLES, *others)
    if suffix not in there:
        raise ValueError(f"{path}: unknown extension {suffix!r}; there are {', '.join(there)}")


def write(path: Path, history: History) -> None:
    """Write by extension. Raises OSError if that cannot be."""
    if path.suffix.lower() == ".npz":
        with path.open("wb") as file:  # numpy would add the extension to a name that ends in .NPZ
            np.savez(file, **history.arrays())  # type: ignore[arg-type]
        return
    rows = history.table()
    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(rows[0])
        table.writerows(map(_cell, row.values()) for row in rows)


def _cell(value: object) -> object:
    return f"{value:.{DIGITS}g}" if isinstance(value, float) else value
