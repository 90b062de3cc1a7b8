"""An experiment's result as files: tables as CSV and NPZ, figures as SVG and PNG, and a manifest that says of what."""

import csv
import json
import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from ..drawing.export import figures
from ..drawing.plots import describe_settings
from .experiment import Experiment, Result
from .paper.claims import Claim, verdict
from .tables import Table, Tables

PACKAGES = ("viewimit", "numpy", "resvg_py")


def write(name: str, experiment: Experiment, result: Result, folder: Path) -> list[Path]:
    """What an experiment has found, under its name, into a folder that is made if need be; a PNG only where one can be
    rendered. Raises OSError."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    tables: Tables = result.tables
    written = [folder / f"{name}.npz"]
    arrays: dict[str, Any] = {f"{table}.{key}": column for table in tables for key, column in tables[table].items()}
    np.savez_compressed(written[0], **arrays)
    for table, columns in tables.items():
        if columns:
            written.append(folder / f"{name}-{table}.csv")
            write_csv(written[-1], columns)
    if experiment.draw is not None:
        drawing = figures.standalone(experiment.figure(result), experiment.title, describe_settings(result.settings))
        for suffix in (".svg", ".png") if figures.can_render() else (".svg",):
            written.append(folder / f"{name}{suffix}")
            figures.write(written[-1], drawing)
    manifest = folder / f"{name}.json"
    said = _manifest(name, result, [path.name for path in written])
    manifest.write_text(json.dumps(said, indent=1, ensure_ascii=False, allow_nan=False) + "\n", "utf-8")
    return [*written, manifest]


def told(claims: list[Claim]) -> dict:
    """Claims as JSON has them, and what they come to."""
    return {"verdict": verdict(claims), "claims": [msgspec.to_builtins(claim) for claim in claims]}


def _manifest(name: str, result, files: list[str]) -> dict:
    return {
        "figure": name,
        "settings": msgspec.to_builtins(result.settings),
        "seed": result.settings.seed,
        "versions": {"python": platform.python_version(), **_versions()},
        **told(result.claims),
        "files": files,
    }


def _versions() -> dict[str, str]:
    found = {}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:  # an extra that is not installed
            continue
    return found


def write_csv(path: Path, columns: Table) -> None:
    """Numbers with ten digits, what is none as an empty cell. Raises OSError."""
    with path.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(columns)
        rows.writerows(zip(*(_cells(column) for column in columns.values())))


def _cells(column: np.ndarray) -> list:
    """Numbers with ten digits, NaN as an empty cell, truth as 1 and 0."""
    if column.dtype.kind == "b":
        return column.astype(int).tolist()
    if column.dtype.kind != "f":
        return column.tolist()
    return ["" if np.isnan(value) else f"{value:.10g}" for value in column.tolist()]
