"""Read the files of pose trackers: DeepLabCut's tables, as CSV and as pandas keeps them in HDF5, and SLEAP's.

DeepLabCut's headings are scorer, individuals (if there are several), bodyparts and coords. Each further row is a frame,
with its number or the path of its picture. Predictions have x, y and likelihood; CollectedData has x and y. pandas has
two layouts in HDF5:

table    rows (index, values_block_0 …); the headings of each block are a pickled list in the attribute
         values_block_0_kind. Only lists, tuples, strings and numbers are unpickled.
fixed    block0_values (rows, columns); headings as levels and labels, block0_items_level0 …, and rows as axis1 or, if
         they have several levels, as axis1_level0 …

SLEAP exports a table and arrays for analysis, and has its own .slp files:

table    track, frame_idx, instance.score, then tip.x, tip.y, tip.score for each node; one row for each instance
arrays   tracks (tracks, 2, nodes, frames), transposed for MATLAB, or as their attribute `dims` says
.slp     frames → instances → points or pred_points, joined by ranges; the names of nodes in the metadata's JSON
"""

import io
import json
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
from .track import CERTAIN, Rows, Track, choose_individual, require_cells

LEVELS = (("scorer", "bodyparts", "coords"), ("scorer", "individuals", "bodyparts", "coords"))
Heading = tuple[str, str, str]  # individual ("" if there is one), body part, coordinate
COORDINATES = ("x", "y", "likelihood")  # of a body part in one picture
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
        cells = table.filled(line, cells, len(parts))
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
    for part, name in columns:
        if name not in COORDINATES:
            what = "points in space: take the table of each picture" if name == "z" else "which is not understood"
            raise ValueError(f"{where}: body part {part!r} has a column {name!r}, {what}")
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


FRAME, TRACK, X, Y, SCORE = "frame_idx", "track", ".x", ".y", ".score"
MATLAB = ("track", "xy", "node", "frame")
LABELLED = 0  # kind of instance; 1 is predicted


def read_sleap_csv(path: Path, individual: str | None) -> Track:
    """Read an exported table. Raises ValueError that names the file, line and column, and OSError."""
    table = Table(path)
    lines = table.lines()
    _, heading = next(lines)
    nodes = [name.removesuffix(X) for name in heading if name.endswith(X) and name.removesuffix(X) + Y in heading]
    at = {name: k for k, name in enumerate(heading)}
    read = [(line, table.filled(line, cells, len(heading))) for line, cells in lines]
    tracks = [cells[at[TRACK]].strip() if TRACK in at else "" for _, cells in read]
    chosen = choose_individual(str(path), list(dict.fromkeys(filter(None, tracks))), individual)
    rows = Rows()
    for (line, cells), track in zip(read, tracks):
        if track != chosen:
            continue
        frame = table.whole(line, FRAME, cells[at[FRAME]])
        for node in nodes:
            x, y = (table.number(line, node + axis, cells[at[node + axis]], np.nan) for axis in (X, Y))
            score = node + SCORE
            confidence = table.number(line, score, cells[at[score]], CERTAIN) if score in at else CERTAIN
            if np.isfinite((x, y)).all():
                rows.add(line, frame, node, x, y, confidence)
    try:
        rows.require_once(str(path))
    except ValueError as error:
        raise ValueError(f"{error}: instances without a track; track them in SLEAP first") from None
    return rows.track(str(path))


def read_sleap_analysis(path: Path, file: Any, individual: str | None) -> Track:
    """Read exported arrays. Raises ValueError that names the file, and KeyError for a missing part."""
    dims = _dims(path, file["tracks"])
    tracks = read_dataset(file["tracks"]).transpose([dims.index(name) for name in ("track", "frame", "node", "xy")])
    nodes = _names(file, "node_names") or list(map(str, range(tracks.shape[2])))
    names = _names(file, "track_names")
    names = names or [f"track_{k}" for k in range(len(tracks))]
    if tracks.shape[-1] != 2 or len(nodes) != tracks.shape[2] or len(names) != len(tracks):
        raise ValueError(
            f"{path}: tracks of shape {file['tracks'].shape} do not fit {len(names)} tracks of {len(nodes)} "
            "nodes; export it by SLEAP as analysis HDF5 again, or as CSV"
        )
    k = names.index(choose_individual(str(path), names, individual))
    scores = np.full(tracks.shape[:3], np.nan)
    if "point_scores" in file:
        flat = [name for name in dims if name != "xy"]
        scores = read_dataset(file["point_scores"]).transpose([flat.index(name) for name in ("track", "frame", "node")])
    confidence = np.where(np.isnan(scores[k]), CERTAIN, scores[k])  # labelled by hand
    return Track(np.arange(tracks.shape[1]), tuple(nodes), tracks[k].astype(float), confidence)


def _names(file: Any, key: str) -> list[str]:
    """The list of that name, empty without one."""
    return [as_text(name) for name in read_dataset(file[key])] if key in file else []


def _dims(path: Path, tracks: Any) -> tuple[str, ...]:
    dims = tuple(json.loads(as_text(tracks.attrs["dims"]))) if "dims" in tracks.attrs else MATLAB
    if sorted(dims) != sorted(MATLAB) or tracks.ndim != len(MATLAB):
        raise ValueError(
            f"{path}: tracks have {tracks.ndim} dimensions {dims}; export it by SLEAP as analysis HDF5 again"
        )
    return dims


def read_slp(path: Path, file: Any, individual: str | None) -> Track:
    """Read an .slp file. Raises ValueError that names the file, and KeyError for a missing part."""
    metadata = json.loads(as_text(file["metadata"].attrs["json"]))
    if len(metadata["skeletons"]) != 1:
        raise ValueError(f"{path}: {len(metadata['skeletons'])} skeletons; export the one by SLEAP as analysis HDF5")
    nodes = [metadata["nodes"][node["id"]]["name"] for node in metadata["skeletons"][0]["nodes"]]
    names = [json.loads(as_text(one))[1] for one in read_dataset(file["tracks_json"])]
    frames, instances = read_dataset(file["frames"]), read_dataset(file["instances"])
    if len(np.unique(frames["video"])) > 1:
        raise ValueError(
            f"{path}: {len(np.unique(frames['video']))} videos; export each by SLEAP as analysis HDF5 or CSV"
        )
    used = sorted(set(instances["track"].tolist()) - {-1})
    chosen = choose_individual(str(path), [names[k] for k in used], individual)
    track = names.index(chosen) if chosen else -1
    numbers = np.unique(frames["frame_idx"]).astype(int)
    require_cells(str(path), len(numbers), len(nodes))
    if (frames["instance_id_end"].astype(float) - frames["instance_id_start"]).clip(0).sum() > len(instances):
        raise ValueError(f"{path}: damaged: an instance is of several frames; export it by SLEAP again")
    image = np.full((len(numbers), len(nodes), 2), np.nan)
    confidence, kinds = np.zeros(image.shape[:2]), np.full(len(numbers), -1)
    points = {kind: read_dataset(file["points" if kind == LABELLED else "pred_points"]) for kind in (0, 1)}
    for frame in frames:
        t = int(np.searchsorted(numbers, frame["frame_idx"]))
        for one in instances[int(frame["instance_id_start"]) : int(frame["instance_id_end"])]:
            kind = int(one["instance_type"])
            if one["track"] != track or kinds[t] == LABELLED != kind:  # labels replace predictions
                continue
            if kinds[t] == kind:
                who = f"two instances of track {chosen}" if chosen else "two instances without a track"
                raise ValueError(f"{path}: frame {numbers[t]} has {who}; track them in SLEAP first")
            kinds[t] = kind
            image[t], confidence[t] = _instance_points(
                points[kind][int(one["point_id_start"]) : int(one["point_id_end"])]
            )
    return Track(numbers, tuple(nodes), image, confidence)


def _instance_points(points: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Points of one instance, (nodes, 2) px, NaN if not visible, and their scores, (nodes,)."""
    image = np.stack([points["x"], points["y"]], -1)
    image[~points["visible"]] = np.nan
    return image, points["score"] if "score" in (points.dtype.names or ()) else np.full(len(points), CERTAIN)
