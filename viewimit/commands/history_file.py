"""The history of a run as a file, a row a motion: .csv, with DIGITS, and .npz, in full, with the same names; degrees
and px²."""

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..snapshot import Snapshot

TABLES = (".csv", ".npz")
DIGITS = 12  # of a number in a table: without those that conversion to degrees adds


def require_format(path: Path, others: Sequence[str] = ()) -> None:
    """Raises ValueError for an extension that is not written. others: that are written elsewhere."""
    suffix, there = path.suffix.lower(), (*TABLES, *others)
    if suffix not in there:
        raise ValueError(f"{path}: unknown extension {suffix!r}; there are {', '.join(there)}")


def write(path: Path, history: Sequence[Snapshot], joints: Sequence[int]) -> None:
    """Write by extension. joints: numbers from 1 of those that move. Raises OSError if that cannot be."""
    columns = _columns(history, joints)
    if path.suffix.lower() == ".npz":
        with path.open("wb") as file:  # numpy would add the extension to a name that ends in .NPZ
            np.savez(file, **columns)
        return
    with path.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(columns)
        rows.writerows(zip(*(map(_cell, column.tolist()) for column in columns.values())))


def _columns(history: Sequence[Snapshot], joints: Sequence[int]) -> dict[str, Any]:
    """Each of one value a motion: moved is the motion that led there; usable, the points seen in all views."""
    angles: dict[str, Any] = {
        "theta": [moment.theta for moment in history],
        "demonstrator": [moment.theta_demo for moment in history],
        "moved": [moment.moved for moment in history],
    }
    by_joint = {
        f"{name}{joint}_deg": column
        for name, values in angles.items()
        for joint, column in zip(joints, np.degrees(values).T)
    }
    return {
        "motion": np.array([moment.motion for moment in history]),
        **by_joint,
        "E_px2": np.array([moment.E for moment in history]),
        "usable": np.array([int(moment.usable.sum()) for moment in history]),
        "probe": np.array([bool(moment.probe) for moment in history]),
        "status": np.array([moment.status for moment in history]),
    }


def _cell(value: object) -> object:
    return f"{value:.{DIGITS}g}" if isinstance(value, float) else value
