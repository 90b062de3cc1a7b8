"""Read SLEAP's tracks: the table and the arrays that it exports for analysis, and its own .slp files.

table       track, frame_idx, instance.score, then tip.x, tip.y, tip.score for each node; one row for each instance
arrays      tracks (tracks, 2, nodes, frames), transposed for MATLAB, or as their attribute `dims` says
.slp        frames → instances → points or pred_points, joined by ranges; the names of nodes in the metadata's JSON
"""

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .arrays import as_text, read_dataset
from .text import Table
from .track import CERTAIN, Rows, Track, choose_individual, require_cells

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
    read = list(lines)
    for line, cells in read:
        table.require_count(line, cells, len(heading))
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
