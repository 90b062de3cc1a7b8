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
from collections.abc import Sequence
from dataclasses import replace
from itertools import islice, zip_longest
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .arrays import as_text, read_dataset
from .columns import SEEN, Meaning, as_numbers, meaning_of, name_unread, refuse
from .numbering import FrameLabels
from .text import Table
from .track import CERTAIN, Rows, Track, choose_individual, require_cells, with_seen

LEVELS = ("scorer", "individuals", "bodyparts", "coords")  # the first two may be missing
Heading = tuple[str, str, str]  # individual ("" if there is one), body part, coordinate
SINGLE = "single"  # DeepLabCut's individual for points that belong to none
EXPORT_CSV = "export it as CSV: pandas.read_hdf(…).to_csv(…), or deeplabcut.analyze_videos(…, save_as_csv=True)"


def read_deeplabcut_csv(path: Path, individual: str | None) -> Track:
    """Read a CSV file. Raises ValueError that names the file, line and column, and OSError."""
    table = Table(path)
    lines = table.lines()
    head = list(islice(lines, 1))
    while head[-1][1][0] in LEVELS[:-1] and len(head) < len(LEVELS):
        head.append(next(lines, (0, [""])))
    levels = [cells[0] for _, cells in head]
    if levels != [name for name in LEVELS if name in levels] or levels[-2:] != list(LEVELS[-2:]):
        raise ValueError(f"{path}: its first lines must begin with {', '.join(LEVELS)}, as DeepLabCut's do")
    line, parts = head[-2]
    for other, cells in head:
        table.require_count(other, cells, len(parts))
    first = next(
        (k for k, name in enumerate(parts[1:], 1) if name), len(parts)
    )  # the columns before say which frame it is
    several = head[levels.index("individuals")][1] if "individuals" in levels else [""] * len(parts)
    headings = [_trimmed(one) for one in zip(several[first:], parts[first:], head[-1][1][first:])]
    labels, frames, numbers = FrameLabels(), list[int](), list[list[float]]()
    for line, cells in lines:
        cells = table.filled(line, cells, len(parts))
        if not frames and not any(map(str.strip, cells[first:])) and not _is_frame(cells[first - 1]):
            continue  # the name of pandas' index
        frames.append(table.frame(labels, line, "1", cells[first - 1]))
        numbers.append(
            [_cell(table, line, first + k + 1, one, text) for k, (one, text) in enumerate(zip(headings, cells[first:]))]
        )
    values = np.array(numbers).reshape(len(frames), len(headings))
    return track_of(str(path), headings, labels, frames, values, individual)


def _is_frame(text: str) -> bool:
    try:
        FrameLabels().add(text)
    except ValueError:
        return False
    return True


def _trimmed(heading: Heading) -> Heading:
    individual, part, coordinate = (name.strip() for name in heading)
    return individual, part, coordinate


def _cell(table: Table, line: int, column: int, heading: Heading, text: str) -> float:
    """The number in a cell; inf for an empty one that says whether a point is seen, NaN for one that is not read."""
    _, part, name = heading
    where, meaning = f"{column} ({part} {name})", meaning_of(name)
    if meaning in SEEN:
        return table.seen(line, where, meaning, text)
    return table.number(line, where, text, np.nan) if meaning in (Meaning.X, Meaning.Y) else np.nan


def track_of(
    where: str,
    headings: Sequence[Heading],
    labels: FrameLabels,
    frames: Sequence[int],
    values: NDArray[Any],
    individual: str | None,
) -> Track:
    """Make a track of values, (T, columns), in frames by the index of their label.

    Raises ValueError that names the file and the column.
    """
    parts, unread = _body_parts(where, headings)
    chosen = choose_individual(where, list(dict.fromkeys(one for one, _ in parts if one != SINGLE)), individual)
    columns = {part: found for (one, part), found in parts.items() if one == chosen}
    if not columns:
        raise ValueError(f"{where}: no body part")
    for part, found in columns.items():
        for meaning, of in found.items():
            if meaning not in SEEN and len(of) > 1:
                raise ValueError(f"{where}: two columns are {meaning.value} of {part!r}: keep those of one scorer")
        if not {Meaning.X, Meaning.Y} <= found.keys():
            raise ValueError(f"{where}: body part {part!r} needs columns x and y, and likelihood if it is known")
    numbers = labels.numbers()[np.array(frames, int)]
    order = np.argsort(numbers, kind="stable")
    twice = np.flatnonzero(np.diff(numbers[order]) == 0)
    if len(twice):
        number = int(numbers[order][twice[0]])
        raise ValueError(
            f"{where}: frame {labels.described(number)} stands in two rows; keep the pictures of one video, "
            "named with the number of the frame"
        )
    image = np.stack([values[:, [found[Meaning.X][0], found[Meaning.Y][0]]] for found in columns.values()], 1)
    known = [np.where(np.isnan(column), np.inf, column) for column in values.T]
    unknown = np.full(len(values), np.inf)
    seen = [
        (meaning, np.stack([unknown if k is None else known[k] for k in of], 1)[order])
        for meaning in SEEN
        for of in zip_longest(*(found.get(meaning, []) for found in columns.values()))
    ]
    track = Track(numbers[order], tuple(columns), image[order], np.zeros(image.shape[:2]), unread=unread)
    return with_seen(where, track, seen)


def _body_parts(where: str, headings: Sequence[Heading]) -> tuple[dict[tuple[str, str], dict[Meaning, list[int]]], str]:
    """Columns of each individual's body parts by meaning, and what is not read.

    A part without any column of a point, such as Lightning Pose's `set`, is none.
    """
    refuse(where, [name for _, _, name in headings])
    parts: dict[tuple[str, str], dict[Meaning, list[int]]] = {}
    unread = []
    for k, (one, part, name) in enumerate(headings):
        meaning = meaning_of(name)
        if meaning in (Meaning.X, Meaning.Y, *SEEN):
            parts.setdefault((one, part), {}).setdefault(meaning, []).append(k)
        else:
            unread.append(name or part)
    return parts, name_unread("column", unread)


def read_deeplabcut_h5(path: Path, group: Any, individual: str | None) -> Track:
    """Read a table in HDF5. Raises ValueError that names the file, and KeyError for a missing part."""
    kind = as_text(group.attrs["pandas_type"])
    if kind not in ("frame_table", "frame"):
        raise ValueError(f"{path}: a table of kind {kind!r}, not a frame; {EXPORT_CSV}")
    index, headings, values = _read_table(path, group) if kind == "frame_table" else _read_fixed(path, group)
    labels = FrameLabels()
    frames = []
    for row, one in enumerate(index, 1):
        try:
            frames.append(labels.add(as_text(one[-1] if isinstance(one, tuple) else one)))
        except ValueError as error:
            raise ValueError(f"{path}: row {row}: {error}") from None
    return track_of(str(path), headings, labels, frames, values, individual)


def _read_table(path: Path, group: Any) -> tuple[list[Any], list[Heading], NDArray[Any]]:
    table = group["table"]
    blocks = sorted((name for name in table.dtype.names if name.startswith("values_block_")), key=lambda n: int(n[13:]))
    headings: list[Heading] = []
    rows, values = read_dataset(table), []
    for block in blocks:
        of = [_heading(path, one) for one in _unpickled(path, table.attrs[f"{block}_kind"])]
        headings += of
        values.append(_numbers(path, of, rows[block].reshape(len(rows), -1)))
    return rows["index"].tolist(), headings, np.concatenate(values, 1)


def _read_fixed(path: Path, group: Any) -> tuple[list[Any], list[Heading], NDArray[Any]]:
    regular = as_text(group.attrs["axis1_variety"]) == "regular"
    index = read_dataset(group["axis1"]).tolist() if regular else _levels(group, "axis1")
    headings: list[Heading] = []
    values = []
    for block in range(int(group.attrs["nblocks"])):
        of = [_heading(path, one) for one in _levels(group, f"block{block}_items")]
        dataset = group[f"block{block}_values"]
        found = read_dataset(dataset)
        if dataset.dtype == object:  # pickled, so not opened
            found = np.full((len(index), len(of)), None)
        headings += of
        values.append(_numbers(path, of, found))
    return index, headings, np.concatenate(values, 1)


def _levels(group: Any, of: str) -> list[tuple[Any, ...]]:
    """The rows of a MultiIndex."""
    columns = []
    for level in range(int(group.attrs[f"{of}_nlevels"])):
        names, labels = read_dataset(group[f"{of}_level{level}"]), read_dataset(group[f"{of}_label{level}"])
        columns.append([names[label] for label in labels])
    return list(zip(*columns))


def _numbers(path: Path, headings: Sequence[Heading], values: NDArray[Any]) -> NDArray[np.float64]:
    """Values of a block, (rows, columns), as numbers; NaN in columns that are not read."""
    if values.dtype.kind in "biuf":
        return values.astype(float)
    found = np.full(values.shape, np.nan)
    for k, (_, part, name) in enumerate(headings):
        meaning = meaning_of(name)
        if meaning in SEEN and values.dtype != object:
            found[:, k] = as_numbers(f"{path}: {part} {name}", meaning, values[:, k])
        elif meaning in (Meaning.X, Meaning.Y, *SEEN):
            raise ValueError(f"{path}: {part} {name} is kept as {values.dtype}, not as numbers; {EXPORT_CSV}")
    return found


def _heading(path: Path, one: Sequence[Any]) -> Heading:
    if not all(isinstance(name, (str, bytes, int, float, np.generic)) for name in one):
        raise ValueError(f"{path}: its headings are no names; {EXPORT_CSV}")
    names = [as_text(name) for name in one]
    if len(names) not in (3, 4):
        raise ValueError(
            f"{path}: headings of {len(names)} levels; DeepLabCut's are scorer, (individuals,) bodyparts, coords"
        )
    return _trimmed(("" if len(names) == 3 else names[1], names[-2], names[-1]))


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


FRAME, TRACK, INSTANCE_SCORE, X, Y = "frame_idx", "track", "instance.score", ".x", ".y"
ANALYSIS = (
    "tracks", "track_names", "track_occupancy", "node_names", "edge_names", "edge_inds", "instance_scores",
    "tracking_scores", "labels_path", "video_path", "video_ind", "provenance",
)  # fmt: skip
MATLAB = ("track", "xy", "node", "frame")
LABELLED = 0  # kind of instance; 1 is predicted


def read_sleap_csv(path: Path, individual: str | None) -> Track:
    """Read an exported table. Raises ValueError that names the file, line and column, and OSError."""
    table = Table(path)
    lines = table.lines()
    _, heading = next(lines)
    nodes = [name.removesuffix(X) for name in heading if name.endswith(X) and name.removesuffix(X) + Y in heading]
    at = {name: k for k, name in enumerate(heading)}
    about = {node: [(k, meaning_of(name[len(node) + 1 :])) for name, k in at.items() if name.startswith(f"{node}.")]
             for node in nodes}  # fmt: skip
    used = {k for found in about.values() for k, meaning in found if meaning in (Meaning.X, Meaning.Y, *SEEN)}
    refuse(str(path), [heading[k].rpartition(".")[2] for found in about.values() for k, _ in found])
    unread = [name for k, name in enumerate(heading) if k not in used and name not in (FRAME, TRACK, INSTANCE_SCORE)]
    read = [(line, table.filled(line, cells, len(heading))) for line, cells in lines]
    tracks = [cells[at[TRACK]].strip() if TRACK in at else "" for _, cells in read]
    chosen = choose_individual(str(path), list(dict.fromkeys(filter(None, tracks))), individual)
    endings = dict.fromkeys(heading[k][len(node) :] for node, found in about.items() for k, one in found if one in SEEN)
    meanings = [meaning_of(ending) for ending in endings]
    rows = Rows(FrameLabels(), meanings)
    asked = {node: [(name, at.get(name), meaning) for name, meaning in zip([node + one for one in endings], meanings)]
             for node in nodes}  # fmt: skip
    for (line, cells), track in zip(read, tracks):
        if track != chosen:
            continue
        frame = table.frame(rows.labels, line, FRAME, cells[at[FRAME]])
        for node in nodes:
            x, y = (table.number(line, node + axis, cells[at[node + axis]], np.nan) for axis in (X, Y))
            says = [np.inf if k is None else table.seen(line, one, of, cells[k]) for one, k, of in asked[node]]
            if np.isfinite((x, y)).all():
                rows.add(line, frame, node, x, y, says)
    try:
        rows.require_once(str(path))
    except ValueError as error:
        raise ValueError(f"{error}: instances without a track; track them in SLEAP first") from None
    return replace(rows.track(str(path)), unread=name_unread("column", unread))


def read_sleap_analysis(path: Path, file: Any, individual: str | None) -> Track:
    """Read exported arrays. Raises ValueError that names the file, and KeyError for a missing part."""
    found = file["tracks"]
    dims = tuple(json.loads(as_text(found.attrs["dims"]))) if "dims" in found.attrs else MATLAB
    if sorted(dims) != sorted(MATLAB) or found.ndim != len(MATLAB):
        again = "export it by SLEAP as analysis HDF5 again"
        raise ValueError(f"{path}: tracks have {found.ndim} dimensions {dims}; {again}")
    tracks = read_dataset(file["tracks"]).transpose([dims.index(name) for name in ("track", "frame", "node", "xy")])
    nodes, names = (
        [as_text(one) for one in read_dataset(file[key])] if key in file else []
        for key in ("node_names", "track_names")
    )
    nodes = nodes or list(map(str, range(tracks.shape[2])))
    names = names or [f"track_{k}" for k in range(len(tracks))]
    if tracks.shape[-1] != 2 or len(nodes) != tracks.shape[2] or len(names) != len(tracks):
        raise ValueError(
            f"{path}: tracks of shape {file['tracks'].shape} do not fit {len(names)} tracks of {len(nodes)} "
            "nodes; export it by SLEAP as analysis HDF5 again, or as CSV"
        )
    k = names.index(choose_individual(str(path), names, individual))
    refuse(str(path), file)
    flat = [name for name in dims if name != "xy"]
    order = [flat.index(name) for name in ("track", "frame", "node")]
    about = [key for key in file if meaning_of(key) in SEEN and file[key].ndim == len(order)]
    seen = []
    for key in about:
        values = as_numbers(f"{path}: {key}", meaning_of(key), read_dataset(file[key]).transpose(order)[k])
        seen.append((meaning_of(key), np.where(np.isnan(values), np.inf, values)))
    frames, image = np.arange(tracks.shape[1], dtype=np.uint64), tracks[k].astype(float)
    unread = name_unread("array", [key for key in file if key not in (*ANALYSIS, *about)])
    return with_seen(str(path), Track(frames, tuple(nodes), image, np.zeros(image.shape[:2]), unread=unread), seen)


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
    numbers = np.unique(frames["frame_idx"]).astype(np.uint64)
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
            own = points[kind][int(one["point_id_start"]) : int(one["point_id_end"])]
            image[t] = np.where(own["visible"][:, None], np.stack([own["x"], own["y"]], -1), np.nan)
            confidence[t] = own["score"] if "score" in (own.dtype.names or ()) else CERTAIN
    return Track(numbers, tuple(nodes), image, confidence)
