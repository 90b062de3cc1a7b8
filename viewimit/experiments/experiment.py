"""Experiments of the paper, their results as tables, and the files made of them: CSV, NPZ, SVG, PNG and a manifest."""

import csv
import json
import platform
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, Protocol

import msgspec
import numpy as np
from numpy.typing import NDArray

from ..analysis.trajectory import Imitation
from ..drawing.export import figures
from ..drawing.plots import describe_settings
from ..loop.settings import Settings
from ..simulation.scene import Scene, load_scene
from .paper.common import Claim, Claims, verdict

Table = dict[str, NDArray]  # columns of equal length, by name, with units in the names
Tables = dict[str, Table]

PACKAGES = ("viewimit", "numpy", "resvg_py")  # named in a manifest


class Result(Protocol):
    """The result of an experiment."""

    @property
    def settings(self) -> Settings: ...

    @property
    def claims(self) -> Claims:
        """What the paper says beside the result."""
        ...

    @property
    def tables(self) -> Tables:
        """The numbers."""
        ...


@dataclass(frozen=True)
class Experiment:
    """An experiment of the paper."""

    title: str  # the figure, a colon, its subject, as in "Fig. 7: landscape and minima"

    run: Callable[..., Any]
    """run(settings, progress, **options) → Result. progress(share done, result so far or None) is called meanwhile.
    Raises ValueError for settings that do not suit it."""

    draw: Callable[..., str] | None = None
    """draw(scene, result) → SVG in HTML. The result may be partial; None draws an empty figure, with a sentence."""

    options: tuple[str, ...] = ()
    """Options of `run` that a user chooses. "motion": the demonstrator's, a name or an `analysis.trajectory.Motion`."""

    imitation: Callable[..., Imitation] | None = None
    """imitation(result) → the motion in it that can be played back."""

    @property
    def short_title(self) -> str:
        return self.title.split(":")[0]

    def figure(self, found: Result) -> str:
        """Draw a whole or partial result."""
        settings = found.settings
        scene = load_scene(settings.scene, settings.robot, settings.joints, body_points=settings.body_points)
        return "" if self.draw is None else self.draw(scene, found)

    def empty_figure(self, scene: Scene) -> str:
        """Draw frames and axes, and a sentence that says what the experiment shows."""
        return "" if self.draw is None else self.draw(scene, None)


def joint_columns(joints: Sequence[int], name: str, degrees: NDArray[np.float64]) -> Table:
    """Make a column for each joint of degrees, (k, m), such as theta2_deg."""
    return {f"{name}{joint}_deg": degrees[:, k] for k, joint in enumerate(joints)}


def stacked(parts: list[dict[str, Any]]) -> Table:
    """Stack tables of the same columns. A scalar stands for a whole column of a part."""
    if not parts:
        return {}
    lengths = [max(np.size(column) for column in part.values()) for part in parts]
    return {
        name: np.concatenate([np.broadcast_to(part[name], length) for part, length in zip(parts, lengths)])
        for name in parts[0]
    }


def write(name: str, experiment: Experiment, result: Result, folder: Path) -> list[Path]:
    """Write a result under this name into a folder, which is made if need be; PNG and PDF only with their packages.

    Returns the paths. Raises OSError.
    """
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
        for suffix in (".svg", *filter(figures.can_render, figures.WRITERS)):
            written.append(folder / f"{name}{suffix}")
            figures.write(written[-1], drawing)
    manifest = {
        "figure": name,
        "settings": msgspec.to_builtins(result.settings),
        "seed": result.settings.seed,
        "versions": {"python": platform.python_version(), **_versions()},
        **claims_json(result.claims),
        "files": [path.name for path in written],
    }
    path = folder / f"{name}.json"
    path.write_text(json.dumps(manifest, indent=1, ensure_ascii=False, allow_nan=False) + "\n", "utf-8")
    return [*written, path]


def claims_json(claims: list[Claim]) -> dict[str, Any]:
    """Return claims and their verdict, as JSON has them."""
    return {"verdict": verdict(claims), "claims": [msgspec.to_builtins(claim) for claim in claims]}


def _versions() -> dict[str, str]:
    found = {}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:  # an extra that is not installed
            continue
    return found


def write_csv(path: Path, columns: Table) -> None:
    """Write the cells of columns. Raises OSError."""
    with path.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(columns)
        rows.writerows(map(cell, row) for row in zip(*(column.tolist() for column in columns.values())))


def cell(value: Any) -> Any:
    """Return what a cell of a table shows: numbers with ten digits, nothing for None and NaN, 1 and 0 for booleans."""
    if isinstance(value, bool):
        return int(value)
    if isinstance(value, float):
        return "" if np.isnan(value) else f"{value:.10g}"
    return "" if value is None else value
