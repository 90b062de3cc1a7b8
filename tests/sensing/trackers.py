"""Tracks written as other packages write theirs: DeepLabCut by pandas, SLEAP by the layouts of its exports.

After deeplabcut's to_hdf(…, "df_with_missing") and to_csv of its predictions and of CollectedData, and sleap's
info/write_tracking_h5.py, io/format/hdf5.py, and sleap-io's csv.py, whose own files were read once besides.
"""

import json
from dataclasses import dataclass

import numpy as np
import pytest


@dataclass(frozen=True)
class Seen:
    """image: (individuals, frames, parts, 2) px, NaN where not seen; sure: (individuals, frames, parts)."""

    image: np.ndarray
    sure: np.ndarray
    frames: np.ndarray
    parts: tuple[str, ...]
    who: tuple[str, ...]


def frame_of_pandas(seen, several, likelihood, index):
    pandas = pytest.importorskip("pandas")
    coords = ["x", "y", "likelihood"] if likelihood else ["x", "y"]
    levels = [["net"], *([list(seen.who)] if several else []), list(seen.parts), coords]
    names = ["scorer", *(["individuals"] if several else []), "bodyparts", "coords"]
    values = np.concatenate([seen.image, seen.sure[..., None]], -1)[..., : len(coords)]
    values = (values if several else values[:1]).transpose(1, 0, 2, 3).reshape(len(seen.frames), -1)
    columns = pandas.MultiIndex.from_product(levels, names=names)
    paths = [("labeled-data", "reach2", f"img{k:04}.png") for k in seen.frames]
    rows = {
        "number": seen.frames,
        "path": ["/".join(path) for path in paths],
        "backslash": ["\\".join(path) for path in paths],
        "levels": pandas.MultiIndex.from_tuples(paths),
    }
    return pandas.DataFrame(values, columns=columns, index=rows[index])


def analysis(path, seen, dims=None, names=None):
    h5py = pytest.importorskip("h5py")
    names = seen.who if names is None else names
    scores = np.full((len(seen.who), seen.frames[-1] + 1, len(seen.parts)), np.nan)
    tracks = np.full((*scores.shape, 2), np.nan)
    tracks[:, seen.frames], scores[:, seen.frames] = seen.image, seen.sure
    tracks, scores = tracks[: len(names) or 1], scores[: len(names) or 1]
    stored = dims or ("track", "xy", "node", "frame")
    order = [("track", "frame", "node", "xy").index(name) for name in stored]
    with h5py.File(path, "w") as file:
        file.create_dataset("track_names", data=[np.bytes_(name) for name in names])
        file.create_dataset("node_names", data=[np.bytes_(name) for name in seen.parts])
        file.create_dataset("tracks", data=tracks.transpose(order), compression="gzip")
        flat = [("track", "frame", "node").index(name) for name in stored if name != "xy"]
        file.create_dataset("point_scores", data=scores.transpose(flat), compression="gzip")
        file.create_dataset("track_occupancy", data=np.isfinite(tracks).any((2, 3)).T.astype(np.uint8))
        if dims:
            file["tracks"].attrs["dims"] = json.dumps(dims)


def slp(path, seen, tracked=True, labelled=()):
    """labelled: positions of frames that have an instance by hand too, 5 px beside the predicted one."""
    h5py = pytest.importorskip("h5py")
    point = [("x", "f8"), ("y", "f8"), ("visible", "?"), ("complete", "?")]
    instance = [
        ("instance_id", "i8"), ("instance_type", "u1"), ("frame_id", "u8"), ("skeleton", "u4"), ("track", "i4"),
        ("from_predicted", "i8"), ("score", "f4"), ("point_id_start", "u8"), ("point_id_end", "u8"),
        ("tracking_score", "f4"),
    ]  # fmt: skip
    frames, instances, points, predicted = [], [], [], []
    for t, number in enumerate(seen.frames):
        first = len(instances)
        for who in range(2 if tracked else 1):
            kinds = (1,) if t not in labelled else (0, 1) if who == 0 else (1, 0)  # either may come first
            for kind in kinds:
                of = (points, predicted)[kind]
                start = len(of)
                for (x, y), score in zip(seen.image[who, t], seen.sure[who, t]):
                    by_hand = (x + 5, y + 5, np.isfinite(x), True)
                    of.append((x, y, np.isfinite(x), False, score) if kind else by_hand)
                track = who if tracked else -1
                instances.append((len(instances), kind, t, 0, track, -1, 0.5, start, len(of), np.nan))
        frames.append((t, 0, number, first, len(instances)))
    # the skeleton has an order of its own
    nodes = [{"name": name, "weight": 1.0} for name in reversed(seen.parts)]
    skeleton = {
        "directed": True,
        "graph": {"name": "arm"},
        "links": [],
        "nodes": [{"id": k} for k in reversed(range(len(nodes)))],
    }
    with h5py.File(path, "w") as file:
        file.create_group("metadata").attrs["format_id"] = 1.2
        told = {"version": "2.0.0", "skeletons": [skeleton], "nodes": nodes, "videos": [], "tracks": []}
        file["metadata"].attrs["json"] = np.bytes_(json.dumps(told))
        file["tracks_json"] = [np.bytes_(json.dumps([0, name])) for name in (seen.who if tracked else ())]
        if not tracked:
            del file["tracks_json"]
            file.create_dataset("tracks_json", (0,), h5py.string_dtype())
        file["videos_json"] = [np.bytes_(json.dumps({"backend": {"filename": "a.mp4"}}))]
        heads = [("frame_id", "u8"), ("video", "u4"), ("frame_idx", "u8")]
        heads += [("instance_id_start", "u8"), ("instance_id_end", "u8")]
        for name, rows, kind in (
            ("frames", frames, heads), ("instances", instances, instance), ("points", points, point),
            ("pred_points", predicted, [*point, ("score", "f8")]),
        ):  # fmt: skip
            file.create_dataset(name, data=np.array(rows, kind))


def sleap_csv(path, seen, tracks=None, empty=False):
    tracks = seen.who if tracks is None else tracks
    heads = ["track", "frame_idx", "instance.score"]
    heads += [f"{part}.{what}" for part in sorted(seen.parts) for what in ("score", "x", "y")]
    lines = [",".join(heads)]
    for t, number in enumerate(seen.frames):
        for who, name in enumerate(tracks):
            cells = [name, str(number), "0.5"]
            for k in np.argsort(seen.parts):
                x, y = seen.image[who, t, k]
                cells += [repr(float(seen.sure[who, t, k])), *("" if np.isnan(v) else repr(float(v)) for v in (x, y))]
            lines.append(",".join(cells))
        if empty and number == 1:
            lines += [f",{k}," + "," * (len(heads) - 3) for k in (2, 3)]
    path.write_text("\n".join(lines) + "\n")
