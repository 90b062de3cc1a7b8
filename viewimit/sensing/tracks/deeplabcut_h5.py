"""DeepLabCut's tables, as pandas keeps them in HDF5 by PyTables, in its two layouts, "table" and "fixed".

table    rows (index, values_block_0 …); the headings of each block are a pickled list in the attribute
         values_block_0_kind. Nothing but lists, tuples and strings is unpickled.
fixed    block0_values (rows, columns); headings as levels and labels, block0_items_level0 …, rows as axis1 or, of
         several levels, axis1_level0 …
"""

import io
import pickle
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .deeplabcut import Heading, frame_of, track_of
from .hdf5 import text
from .hdf5 import values as values_of
from .track import Track

CSV = "export it as CSV: pandas.read_hdf(…).to_csv(…), or deeplabcut.analyze_videos(…, save_as_csv=True)"


def find_table(file: Any) -> Any | None:
    """The group of the first table that pandas has written, None if there is none."""
    return next((group for group in file.values() if "pandas_type" in group.attrs), None)


def read_deeplabcut_h5(path: Path, group: Any, individual: str | None) -> Track:
    """group: a table. Raises ValueError that names the file, KeyError for what is missing."""
    kind = text(group.attrs["pandas_type"])
    if kind not in ("frame_table", "frame"):
        raise ValueError(f"{path}: a table of kind {kind!r}, not a frame; {CSV}")
    index, headings, values = _of_table(path, group) if kind == "frame_table" else _of_fixed(path, group)
    frames = np.array([_frame(path, k, one) for k, one in enumerate(index)], int)
    return track_of(str(path), [_heading(path, one) for one in headings], frames, values, individual)


def _of_table(path: Path, group: Any) -> tuple[list, list, NDArray]:
    table = group["table"]
    blocks = sorted((name for name in table.dtype.names if name.startswith("values_block_")), key=lambda n: int(n[13:]))
    headings = [one for block in blocks for one in _unpickled(path, table.attrs[f"{block}_kind"])]
    rows = values_of(table)
    values = np.concatenate([_numbers(path, rows[block]).reshape(len(rows), -1) for block in blocks], 1)
    return rows["index"].tolist(), headings, values


def _of_fixed(path: Path, group: Any) -> tuple[list, list, NDArray]:
    headings, values = [], []
    for block in range(int(group.attrs["nblocks"])):
        headings += _levels(group, f"block{block}_items")
        values.append(_numbers(path, values_of(group[f"block{block}_values"])))
    regular = text(group.attrs["axis1_variety"]) == "regular"
    index = values_of(group["axis1"]).tolist() if regular else _levels(group, "axis1")
    return index, headings, np.concatenate(values, 1)


def _levels(group: Any, of: str) -> list[tuple]:
    """A MultiIndex."""
    columns = []
    for level in range(int(group.attrs[f"{of}_nlevels"])):
        names, labels = values_of(group[f"{of}_level{level}"]), values_of(group[f"{of}_label{level}"])
        columns.append([names[label] for label in labels])
    return list(zip(*columns))


def _numbers(path: Path, values: Any) -> NDArray:
    if not np.issubdtype(values.dtype, np.number):
        raise ValueError(f"{path}: its values are kept as {values.dtype}, not as numbers; {CSV}")
    return values.astype(float)


def _heading(path: Path, one: Sequence) -> Heading:
    if not all(isinstance(name, (str, bytes, int, float, np.generic)) for name in one):
        raise ValueError(f"{path}: its headings are no names; {CSV}")
    names = [text(name) for name in one]
    if len(names) not in (3, 4):
        raise ValueError(
            f"{path}: headings of {len(names)} levels; DeepLabCut's are scorer, (individuals,) bodyparts, coords"
        )
    return ("" if len(names) == 3 else names[1], names[-2], names[-1])


def _frame(path: Path, row: int, index: Any) -> int:
    cells = index if isinstance(index, tuple) else (index,)
    return frame_of(f"{path}: row {row + 1}", [text(cell) for cell in cells])


class _Plain(pickle.Unpickler):
    """Of lists, tuples, strings and numbers alone: nothing is imported, so nothing can be run."""

    def find_class(self, module: str, name: str) -> Any:
        raise pickle.UnpicklingError(f"it asks for {module}.{name}")


def _unpickled(path: Path, value: Any) -> list:
    content = value if isinstance(value, bytes) else text(value).encode("latin-1")
    try:
        found = _Plain(io.BytesIO(content)).load()
    except (
        pickle.UnpicklingError,
        EOFError,
        ValueError,
        IndexError,
        KeyError,
        AttributeError,
        TypeError,
        OverflowError,
    ) as error:
        raise ValueError(f"{path}: its headings cannot be read: {error}; {CSV}") from None
    return list(found)
