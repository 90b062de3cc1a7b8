"""Arrays of tracks, .npz and .npy, as CoTracker and TAPIR give them; points named by a list.

CoTracker   pred_tracks (1, frames, points, 2) and pred_visibility (1, frames, points)
TAPIR       tracks (points, frames, 2) and visibles (points, frames)

An .npz may have `names`, one a point; beside tracks.npy they stand in tracks.txt, a line each. They also tell which
axis is of points, where that is not known otherwise.
"""

import importlib.util
import tokenize
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..files import MEGABYTE, MOST_ARRAYS, TooLarge, read_npz, require_file
from .track import CERTAIN, Track, require_cells

TRACKS = ("pred_tracks", "tracks", "points")
NAMES = ("names", "point_names", "node_names")
FRAMES_FIRST = ("pred_visibility", "visibility", "visibilities", "confidence")  # CoTracker's order
POINTS_FIRST = ("visibles", "occluded", "occlusions")  # TAPIR's
HIDDEN = ("occluded", "occlusions")
DAMAGED = (
    zipfile.BadZipFile, zlib.error, tokenize.TokenError, EOFError, NotImplementedError, OSError, ValueError, TypeError,
    MemoryError, RecursionError, SyntaxError,
)  # fmt: skip
SAVE = "numpy.savez(file, pred_tracks=…, pred_visibility=…, names=[…])"


def read_arrays(path: Path) -> Track:
    """Raises ValueError that names the file and the array; OSError."""
    found = _loaded(path)
    key = next((name for name in TRACKS if name in found), None)
    if key is None:
        raise ValueError(
            f"{path}: no array {' or '.join(TRACKS[:2])}; it has {', '.join(found) or 'none'}: save as {SAVE}"
        )
    tracks, names = (
        _unbatched(found[key], 3),
        next((np.atleast_1d(found[name]) for name in NAMES if name in found), None),
    )
    if tracks.ndim != 3 or tracks.shape[-1] != 2 or not np.issubdtype(tracks.dtype, np.number):
        raise ValueError(f"{path}: {key} has shape {found[key].shape}: needs (frames, points, 2) px; save as {SAVE}")
    require_cells(str(path), *tracks.shape[:2])
    sight = next((name for name in (*FRAMES_FIRST, *POINTS_FIRST) if name in found), None)
    if _points_first(path, found[key], key, sight, None if names is None else len(names)):
        tracks = tracks.swapaxes(0, 1)
    sure = np.full(tracks.shape[:2], CERTAIN)
    if sight is not None:
        sure = _confidence(path, sight, found[sight], tracks.shape[:2])
    T, N = tracks.shape[:2]
    points = tuple(map(str, range(N) if names is None else names.tolist()))
    seen = tracks[np.isfinite(tracks).all(-1) & (sure > 0)]
    if len(seen) and 0 <= seen.min() and seen.max() <= 1:
        raise ValueError(
            f"{path}: {key} is all in 0 … 1: multiply x by the picture's width and y by its height in pixels"
        )
    return Track(np.arange(T), points, tracks.astype(float), sure)


def _loaded(path: Path) -> dict[str, NDArray]:
    require_file(path, MOST_ARRAYS)
    try:
        found = _arrays(path)
    except TooLarge:
        raise
    except DAMAGED:
        raise ValueError(f"{path}: not an array of numbers that numpy has saved; save as {SAVE}") from None
    beside = path.with_suffix(".txt")
    if path.suffix.lower() == ".npy" and beside.is_file():
        names = [name.strip() for name in beside.read_text("utf-8", errors="replace").splitlines()]
        found["names"] = np.array([name for name in names if name])
    return found


def _arrays(path: Path) -> dict[str, NDArray]:
    """Raises any of DAMAGED."""
    return read_npz(path) if path.suffix.lower() == ".npz" else {"tracks": np.load(path)}


def _unbatched(values: NDArray, dims: int) -> NDArray:
    return values[0] if values.ndim == dims + 1 and len(values) == 1 else values


def _points_first(path: Path, tracks: NDArray, key: str, sight: str | None, names: int | None) -> bool:
    """Whether the first axis is of points: as its names, its key or a batch say. Raises ValueError if nothing does."""
    first, second = _unbatched(tracks, 3).shape[:2]
    if names is not None and names not in (first, second):
        raise ValueError(f"{path}: {names} names, but {key} has shape {tracks.shape}: one name a point is needed")
    if names is not None and first != second:
        return names == first
    if sight in POINTS_FIRST:
        return True
    if key == "pred_tracks" or sight in FRAMES_FIRST or tracks.ndim == 4:
        return False
    raise ValueError(f"{path}: {key} has shape {tracks.shape}: which axis is of points? Save as {SAVE}")


def _confidence(path: Path, key: str, values: NDArray, shape: tuple[int, ...]) -> NDArray:
    """(frames, points) in 0 … 1."""
    values = values[..., 0] if values.ndim > 2 and values.shape[-1] == 1 else values
    sure = _unbatched(values, 2)
    sure = sure.swapaxes(0, 1) if key in POINTS_FIRST and sure.ndim == 2 else sure
    if sure.shape != shape:
        raise ValueError(
            f"{path}: {key} has shape {values.shape}, which does not fit {shape[0]} frames of {shape[1]} points"
        )
    sure = sure.astype(float)
    if not ((sure >= 0) & (sure <= 1)).all():
        raise ValueError(f"{path}: {key} must be true or false or in 0 … 1, not logits: save 1 / (1 + exp(-{key}))")
    return 1 - sure if key in HIDDEN else sure


# HDF5 files, by h5py, which is an extra.

MOST_BYTES = 1024 * MEGABYTE  # of a file, which may hold pictures beside its tracks
HDF5_ERRORS = (
    MemoryError, RecursionError, OSError, RuntimeError, ValueError, TypeError, IndexError, AttributeError,
    OverflowError, ZeroDivisionError,
)  # fmt: skip


@contextmanager
def opened(path: Path) -> Iterator[Any]:
    """The file as h5py has it. Raises OSError, ValueError without h5py or for what is no HDF5 file, or one that lacks
    what was read of it, or is damaged, which shows as any error of h5py, numpy or json."""
    if importlib.util.find_spec("h5py") is None:
        raise ValueError(f"{path}: HDF5 files need h5py: pip install 'viewimit[hdf5]', or export the tracks as CSV")
    import h5py

    require_file(path, MOST_BYTES)
    if not h5py.is_hdf5(path):
        raise ValueError(f"{path}: not an HDF5 file")
    try:
        with h5py.File(path, "r") as file:
            yield file
    except KeyError as error:
        raise ValueError(f"{path}: it lacks what files of its kind have: {error.args[0]}") from None
    except HDF5_ERRORS as error:
        if isinstance(error, ValueError) and str(error).startswith(f"{path}:"):
            raise
        raise ValueError(f"{path}: damaged, or no file of its kind: {error}; export it again, or as CSV") from None


def values(dataset: Any) -> NDArray:
    """All of a dataset. Raises ValueError for one that says to be larger than tracks are: its chunks may be empty."""
    size = int(dataset.size or 0) * dataset.dtype.itemsize
    if size > MOST_ARRAYS:
        raise ValueError(f"{dataset.name} has {size / MEGABYTE:,.0f} MB, more than {MOST_ARRAYS / MEGABYTE:g}")
    return dataset[()]


def text(value: Any) -> str:
    """Of bytes or a string."""
    return value.decode("utf-8") if isinstance(value, bytes) else str(value)
