"""Read DeepLabCut's tables, as CSV and as pandas keeps them in HDF5.

The headings are scorer, individuals (if there are several), bodyparts and coords. Each further row is a frame, with
its number or the path of its picture. Predictions have x, y and likelihood; CollectedData has x and y.

pandas has two layouts in HDF5:

table    rows (index, values_block_0 …); the headings of each block are a pickled list in the attribute
         values_block_0_kind. Only lists, tuples, strings and numbers are unpickled.
fixed    block0_values (rows, columns); headings as levels and labels, block0_items_level0 …, and rows as axis1 or, if
         they have several levels, as axis1_level0 …
"""

import io
import pickle
import re
from collections import Counter
from collections.abc import Sequence
from itertools import islice
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .arrays import as_text, read_dataset
from .text import MAX_FRAME, Table
from .track import CERTAIN, Track, choose_individual

LEVELS = (("scorer", "bodyparts", "coords"), ("scorer", "individuals", "bodyparts", "coords"))
Heading = tuple[str, str, str]  # individual ("" if there is one), body part, coordinate
SINGLE = "single"  # DeepLabCut's individual for points that belong to none
EXPORT_CSV = "export it as CSV: pandas.read_hdf(…).to_csv(…), or deeplabcut.analyze_videos(…, save_as_csv=True)"


def read_deeplabcut_csv(path: Path, individual: str | None) -> Track:
    """Read a CSV file. Raises ValueError that names the file, line and column, and OSError."""
    table = Table(path)
    lines = table.lines()
    head = list(islice(lines, 3))
    if len(head) > 1 and head[1][1][0] == "individuals":
        head += islice(lines, 1)
    levels = tuple(cells[0] for _, cells in head)
    if levels not in LEVELS:
        expected = " or ".join(", ".join(names) for names in LEVELS)
        raise ValueError(f"{path}: its first lines must begin with {expected}, as DeepLabCut's do")
    line, parts = head[-2]
    for other, cells in head:
        table.require_count(other, cells, len(parts))
    first = next(
        (k for k, name in enumerate(parts[1:], 1) if name), len(parts)
    )  # the columns before say which frame it is
    several = head[1][1] if len(levels) == 4 else [""] * len(parts)
    headings = list(zip(several[first:], parts[first:], head[-1][1][first:]))
    frames, numbers = [], []
    for line, cells in lines:
        table.require_count(line, cells, len(parts))
        frames.append(frame_of(f"{path}: line {line}, column 1", cells[:first]))
        numbers.append(
            [
                table.number(line, f"{first + k + 1} ({part} {coordinate})", cells[first + k], np.nan)
                for k, (_, part, coordinate) in enumerate(headings)
            ]
        )
    values = np.array(numbers).reshape(len(frames), len(headings))
    return track_of(str(path), headings, np.array(frames, int), values, individual)


def track_of(
    where: str, headings: Sequence[Heading], frames: NDArray[Any], values: NDArray[Any], individual: str | None
) -> Track:
    """Make a track of values, (T, columns). Raises ValueError that names the file and the column."""
    chosen = choose_individual(where, list(dict.fromkeys(one for one, _, _ in headings if one != SINGLE)), individual)
    several = [heading for heading, count in Counter(headings).items() if count > 1 and heading[0] == chosen]
    if several:
        _, part, name = several[0]
        raise ValueError(f"{where}: two columns are {name} of {part!r}: keep those of one scorer")
    columns = {(part, name): k for k, (one, part, name) in enumerate(headings) if one == chosen}
    parts = list(dict.fromkeys(part for part, _ in columns))
    for part in parts:
        if not {(part, "x"), (part, "y")} <= columns.keys():
            raise ValueError(f"{where}: body part {part!r} needs columns x and y, and likelihood if it is known")
    if not parts:
        raise ValueError(f"{where}: no body part")
    image = np.stack([values[:, [columns[part, "x"], columns[part, "y"]]] for part in parts], 1)
    likelihoods = [
        values[:, columns[part, "likelihood"]] if (part, "likelihood") in columns else None for part in parts
    ]
    likelihood = np.stack([np.full(len(values), CERTAIN) if one is None else one for one in likelihoods], 1)
    order = np.argsort(frames, kind="stable")
    twice = np.flatnonzero(np.diff(frames[order]) == 0)
    if len(twice):
        raise ValueError(f"{where}: frame {frames[order][twice[0]]} stands in two rows; keep the pictures of one video")
    confidence = np.where(np.isnan(likelihood), CERTAIN, likelihood)  # labelled by hand
    return Track(frames[order], tuple(parts), image[order], confidence[order])


def frame_of(where: str, cells: Sequence[str]) -> int:
    """Return the number of a frame, or the last number in the name of its picture. Raises ValueError."""
    text = cells[-1].strip().replace("\\", "/")
    if text.isdecimal() and int(text) <= MAX_FRAME:
        return int(text)
    digits = re.findall(r"\d+", PurePosixPath(text).stem)
    if not digits or not PurePosixPath(text).suffix or int(digits[-1]) > MAX_FRAME:
        raise ValueError(
            f"{where}: {text!r} is neither a whole number from 0 nor a picture named with one, img0003.png"
        )
    return int(digits[-1])


def find_table(file: Any) -> Any | None:
    """Return the group of the first table that pandas has written, None if there is none."""
    return next((group for group in file.values() if "pandas_type" in group.attrs), None)


def read_deeplabcut_h5(path: Path, group: Any, individual: str | None) -> Track:
    """Read a table in HDF5. Raises ValueError that names the file, and KeyError for a missing part."""
    kind = as_text(group.attrs["pandas_type"])
    if kind not in ("frame_table", "frame"):
        raise ValueError(f"{path}: a table of kind {kind!r}, not a frame; {EXPORT_CSV}")
    index, headings, values = _read_table(path, group) if kind == "frame_table" else _read_fixed(path, group)
    frames = np.array([_frame(path, k, one) for k, one in enumerate(index)], int)
    return track_of(str(path), [_heading(path, one) for one in headings], frames, values, individual)


def _read_table(path: Path, group: Any) -> tuple[list[Any], list[Any], NDArray[Any]]:
    table = group["table"]
    blocks = sorted((name for name in table.dtype.names if name.startswith("values_block_")), key=lambda n: int(n[13:]))
    headings = [one for block in blocks for one in _unpickled(path, table.attrs[f"{block}_kind"])]
    rows = read_dataset(table)
    values = np.concatenate([_numbers(path, rows[block]).reshape(len(rows), -1) for block in blocks], 1)
    return rows["index"].tolist(), headings, values


def _read_fixed(path: Path, group: Any) -> tuple[list[Any], list[Any], NDArray[Any]]:
    headings, values = [], []
    for block in range(int(group.attrs["nblocks"])):
        headings += _levels(group, f"block{block}_items")
        values.append(_numbers(path, read_dataset(group[f"block{block}_values"])))
    regular = as_text(group.attrs["axis1_variety"]) == "regular"
    index = read_dataset(group["axis1"]).tolist() if regular else _levels(group, "axis1")
    return index, headings, np.concatenate(values, 1)


def _levels(group: Any, of: str) -> list[tuple[Any, ...]]:
    """The rows of a MultiIndex."""
    columns = []
    for level in range(int(group.attrs[f"{of}_nlevels"])):
        names, labels = read_dataset(group[f"{of}_level{level}"]), read_dataset(group[f"{of}_label{level}"])
        columns.append([names[label] for label in labels])
    return list(zip(*columns))


def _numbers(path: Path, values: Any) -> NDArray[Any]:
    if not np.issubdtype(values.dtype, np.number):
        raise ValueError(f"{path}: its values are kept as {values.dtype}, not as numbers; {EXPORT_CSV}")
    return values.astype(float)


def _heading(path: Path, one: Sequence[Any]) -> Heading:
    if not all(isinstance(name, (str, bytes, int, float, np.generic)) for name in one):
        raise ValueError(f"{path}: its headings are no names; {EXPORT_CSV}")
    names = [as_text(name) for name in one]
    if len(names) not in (3, 4):
        raise ValueError(
            f"{path}: headings of {len(names)} levels; DeepLabCut's are scorer, (individuals,) bodyparts, coords"
        )
    return ("" if len(names) == 3 else names[1], names[-2], names[-1])


def _frame(path: Path, row: int, index: Any) -> int:
    cells = index if isinstance(index, tuple) else (index,)
    return frame_of(f"{path}: row {row + 1}", [as_text(cell) for cell in cells])


PICKLE_ERRORS = (
    pickle.UnpicklingError, EOFError, ValueError, IndexError, KeyError, AttributeError, TypeError, OverflowError,
)  # fmt: skip


class _PlainUnpickler(pickle.Unpickler):
    """Unpickles lists, tuples, strings and numbers only: it imports nothing, so it runs nothing."""

    def find_class(self, module: str, name: str) -> Any:
        raise pickle.UnpicklingError(f"it asks for {module}.{name}")


def _unpickled(path: Path, value: Any) -> list[Any]:
    content = value if isinstance(value, bytes) else as_text(value).encode("latin-1")
    try:
        found = _PlainUnpickler(io.BytesIO(content)).load()
    except PICKLE_ERRORS as error:
        raise ValueError(f"{path}: its headings cannot be read: {error}; {EXPORT_CSV}") from None
    return list(found)
