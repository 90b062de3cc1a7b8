"""SLEAP's tracks: the table and the arrays that it exports for analysis, and its own .slp files.

table       track, frame_idx, instance.score, then of each node tip.x, tip.y, tip.score; a row an instance
arrays      tracks (tracks, 2, nodes, frames), transposed for MATLAB, or as their attribute `dims` says
.slp        frames → instances → points or pred_points, joined by ranges; the nodes' names in the metadata's JSON
"""

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .arrays import text
from .arrays import values as values_of
from .deeplabcut import choose
from .text import Table
from .track import CERTAIN, Rows, Track, require_cells

FRAME, TRACK, X, Y, SCORE = "frame_idx", "track", ".x", ".y", ".score"
MATLAB = ("track", "xy", "node", "frame")
BY_HAND = 0  # kinds of instance: labelled, predicted


def read_sleap_csv(path: Path, individual: str | None) -> Track:
    """Raises ValueError that names the file, and the line and column of what is wrong; OSError."""
    table = Table(path)
    lines = table.lines()
    _, heading = next(lines)
    nodes = [name.removesuffix(X) for name in heading if name.endswith(X) and name.removesuffix(X) + Y in heading]
    at = {name: k for k, name in enumerate(heading)}
    read = list(lines)
    for line, cells in read:
        table.require_count(line, cells, len(heading))
    tracks = [cells[at[TRACK]].strip() if TRACK in at else "" for _, cells in read]
    chosen = choose(str(path), list(dict.fromkeys(filter(None, tracks))), individual)
    rows = Rows()
    for (line, cells), track in zip(read, tracks):
        if track != chosen:
            continue
        frame = table.whole(line, FRAME, cells[at[FRAME]])
        for node in nodes:
            x, y = (table.number(line, node + axis, cells[at[node + axis]], np.nan) for axis in (X, Y))
            score = node + SCORE
            sure = table.number(line, score, cells[at[score]], CERTAIN) if score in at else CERTAIN
            if np.isfinite((x, y)).all():
                rows.add(line, frame, node, x, y, sure)
    try:
        rows.require_once(str(path))
    except ValueError as error:
        raise ValueError(f"{error}: instances without a track; track them in SLEAP first") from None
    return rows.track(str(path))


def read_sleap_analysis(path: Path, file: Any, individual: str | None) -> Track:
    """file: open. Raises ValueError that names the file, KeyError for what is missing."""
    dims = _dims(path, file["tracks"])
    tracks = values_of(file["tracks"]).transpose([dims.index(name) for name in ("track", "frame", "node", "xy")])
    nodes = _names(file, "node_names") or list(map(str, range(tracks.shape[2])))
    names = _names(file, "track_names")
    names = names or [f"track_{k}" for k in range(len(tracks))]
    if tracks.shape[-1] != 2 or len(nodes) != tracks.shape[2] or len(names) != len(tracks):
        raise ValueError(
            f"{path}: tracks of shape {file['tracks'].shape} do not fit {len(names)} tracks of {len(nodes)} "
            "nodes; export it by SLEAP as analysis HDF5 again, or as CSV"
        )
    k = names.index(choose(str(path), names, individual))
    scores = np.full(tracks.shape[:3], np.nan)
    if "point_scores" in file:
        flat = [name for name in dims if name != "xy"]
        scores = values_of(file["point_scores"]).transpose([flat.index(name) for name in ("track", "frame", "node")])
    confidence = np.where(np.isnan(scores[k]), CERTAIN, scores[k])  # labelled by hand
    return Track(np.arange(tracks.shape[1]), tuple(nodes), tracks[k].astype(float), confidence)


def _names(file: Any, key: str) -> list[str]:
    """None without a list of that name."""
    return [text(name) for name in values_of(file[key])] if key in file else []


def _dims(path: Path, tracks: Any) -> tuple[str, ...]:
    dims = tuple(json.loads(text(tracks.attrs["dims"]))) if "dims" in tracks.attrs else MATLAB
    if sorted(dims) != sorted(MATLAB) or tracks.ndim != len(MATLAB):
        raise ValueError(
            f"{path}: tracks have {tracks.ndim} dimensions {dims}; export it by SLEAP as analysis HDF5 again"
        )
    return dims


def read_slp(path: Path, file: Any, individual: str | None) -> Track:
    """file: open. Raises ValueError that names the file, KeyError for what is missing."""
    metadata = json.loads(text(file["metadata"].attrs["json"]))
    if len(metadata["skeletons"]) != 1:
        raise ValueError(f"{path}: {len(metadata['skeletons'])} skeletons; export the one by SLEAP as analysis HDF5")
    nodes = [metadata["nodes"][node["id"]]["name"] for node in metadata["skeletons"][0]["nodes"]]
    names = [json.loads(text(one))[1] for one in values_of(file["tracks_json"])]
    frames, instances = values_of(file["frames"]), values_of(file["instances"])
    if len(np.unique(frames["video"])) > 1:
        raise ValueError(
            f"{path}: {len(np.unique(frames['video']))} videos; export each by SLEAP as analysis HDF5 or CSV"
        )
    used = sorted(set(instances["track"].tolist()) - {-1})
    chosen = choose(str(path), [names[k] for k in used], individual)
    track = names.index(chosen) if chosen else -1
    numbers = np.unique(frames["frame_idx"]).astype(int)
    require_cells(str(path), len(numbers), len(nodes))
    if (frames["instance_id_end"].astype(float) - frames["instance_id_start"]).clip(0).sum() > len(instances):
        raise ValueError(f"{path}: damaged: an instance is of several frames; export it by SLEAP again")
    image = np.full((len(numbers), len(nodes), 2), np.nan)
    confidence, kinds = np.zeros(image.shape[:2]), np.full(len(numbers), -1)
    points = {kind: values_of(file["points" if kind == BY_HAND else "pred_points"]) for kind in (0, 1)}
    for frame in frames:
        t = int(np.searchsorted(numbers, frame["frame_idx"]))
        for one in instances[int(frame["instance_id_start"]) : int(frame["instance_id_end"])]:
            kind = int(one["instance_type"])
            if one["track"] != track or kinds[t] == BY_HAND != kind:  # what is labelled by hand goes before
                continue
            if kinds[t] == kind:
                who = f"two instances of track {chosen}" if chosen else "two instances without a track"
                raise ValueError(f"{path}: frame {numbers[t]} has {who}; track them in SLEAP first")
            kinds[t] = kind
            image[t], confidence[t] = _placed(points[kind][int(one["point_id_start"]) : int(one["point_id_end"])])
    return Track(numbers, tuple(nodes), image, confidence)


def _placed(points: NDArray) -> tuple[NDArray, NDArray]:
    """Of one instance: (nodes, 2) px, NaN where not visible, and (nodes,) scores."""
    image = np.stack([points["x"], points["y"]], -1)
    image[~points["visible"]] = np.nan
    return image, points["score"] if "score" in (points.dtype.names or ()) else np.full(len(points), CERTAIN)
