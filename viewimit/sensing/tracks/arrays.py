"""Read arrays of tracks from .npz and .npy files, as CoTracker and TAPIR return them, and open HDF5 files.

CoTracker   pred_tracks (1, frames, points, 2) and pred_visibility (1, frames, points)
TAPIR       tracks (points, frames, 2) and visibles (points, frames)

An .npz file may have `names`, one for each point. The names of tracks.npy are the lines of tracks.txt beside it. If
nothing else does, the number of names tells which axis is of points.
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

from ..files import MAX_ARRAY_BYTES, MEGABYTE, TooLarge, read_npz, require_file
from .track import CERTAIN, Track, require_cells

TRACKS = ("pred_tracks", "tracks", "points")
NAMES = ("names", "point_names", "node_names")
FRAMES_FIRST = ("pred_visibility", "visibility", "visibilities", "confidence")  # CoTracker's order of axes
POINTS_FIRST = ("visibles", "occluded", "occlusions")  # TAPIR's
HIDDEN = ("occluded", "occlusions")
DAMAGED = (
    zipfile.BadZipFile, zlib.error, tokenize.TokenError, EOFError, NotImplementedError, OSError, ValueError, TypeError,
    MemoryError, RecursionError, SyntaxError,
)  # fmt: skip
SAVE = "numpy.savez(file, pred_tracks=…, pred_visibility=…, names=[…])"
MAX_HDF5_BYTES = 1024 * MEGABYTE  # of a file, which may hold pictures beside its tracks
HDF5_ERRORS = (
    MemoryError, RecursionError, OSError, RuntimeError, ValueError, TypeError, IndexError, AttributeError,
    OverflowError, ZeroDivisionError,
)  # fmt: skip


def read_arrays(path: Path) -> Track:
    """Read the arrays of one view. Raises ValueError that names the file and the array, and OSError."""
    found = _load(path)
    key = next((name for name in TRACKS if name in found), None)
    if key is None:
        raise ValueError(
            f"{path}: no array {' or '.join(TRACKS[:2])}; it has {', '.join(found) or 'none'}: save as {SAVE}"
        )
    tracks = _unbatched(found[key], 3)
    names = next((np.atleast_1d(found[name]) for name in NAMES if name in found), None)
    if tracks.ndim != 3 or tracks.shape[-1] != 2 or not np.issubdtype(tracks.dtype, np.number):
        raise ValueError(f"{path}: {key} has shape {found[key].shape}: needs (frames, points, 2) px; save as {SAVE}")
    require_cells(str(path), *tracks.shape[:2])
    visibility = next((name for name in (*FRAMES_FIRST, *POINTS_FIRST) if name in found), None)
    if _has_points_first(path, found[key], key, visibility, None if names is None else len(names)):
        tracks = tracks.swapaxes(0, 1)
    confidence = np.full(tracks.shape[:2], CERTAIN)
    if visibility is not None:
        confidence = _confidence(path, visibility, found[visibility], tracks.shape[:2])
    T, N = tracks.shape[:2]
    points = tuple(map(str, range(N) if names is None else names.tolist()))
    seen = tracks[np.isfinite(tracks).all(-1) & (confidence > 0)]
    if len(seen) and 0 <= seen.min() and seen.max() <= 1:
        raise ValueError(
            f"{path}: {key} is all in 0 … 1: multiply x by the picture's width and y by its height in pixels"
        )
    return Track(np.arange(T), points, tracks.astype(float), confidence)


def _load(path: Path) -> dict[str, NDArray[Any]]:
    require_file(path, MAX_ARRAY_BYTES)
    try:
        found = read_npz(path) if path.suffix.lower() == ".npz" else {"tracks": np.load(path)}
    except TooLarge:
        raise
    except DAMAGED:
        raise ValueError(f"{path}: not an array of numbers that numpy has saved; save as {SAVE}") from None
    beside = path.with_suffix(".txt")
    if path.suffix.lower() == ".npy" and beside.is_file():
        names = [name.strip() for name in beside.read_text("utf-8", errors="replace").splitlines()]
        found["names"] = np.array([name for name in names if name])
    return found


def _unbatched(values: NDArray[Any], dims: int) -> NDArray[Any]:
    return values[0] if values.ndim == dims + 1 and len(values) == 1 else values


def _has_points_first(path: Path, tracks: NDArray[Any], key: str, visibility: str | None, n_names: int | None) -> bool:
    """Whether the first axis is of points, by the names, the key or a batch. Raises ValueError if nothing tells."""
    first, second = _unbatched(tracks, 3).shape[:2]
    if n_names is not None and n_names not in (first, second):
        raise ValueError(f"{path}: {n_names} names, but {key} has shape {tracks.shape}: one name a point is needed")
    if n_names is not None and first != second:
        return n_names == first
    if visibility in POINTS_FIRST:
        return True
    if key == "pred_tracks" or visibility in FRAMES_FIRST or tracks.ndim == 4:
        return False
    raise ValueError(f"{path}: {key} has shape {tracks.shape}: which axis is of points? Save as {SAVE}")


def _confidence(path: Path, key: str, values: NDArray[Any], shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Confidence in 0 … 1, (frames, points)."""
    values = values[..., 0] if values.ndim > 2 and values.shape[-1] == 1 else values
    found = _unbatched(values, 2)
    found = found.swapaxes(0, 1) if key in POINTS_FIRST and found.ndim == 2 else found
    if found.shape != shape:
        raise ValueError(
            f"{path}: {key} has shape {values.shape}, which does not fit {shape[0]} frames of {shape[1]} points"
        )
    found = found.astype(float)
    if not ((found >= 0) & (found <= 1)).all():
        raise ValueError(f"{path}: {key} must be true or false or in 0 … 1, not logits: save 1 / (1 + exp(-{key}))")
    return 1 - found if key in HIDDEN else found


@contextmanager
def open_hdf5(path: Path) -> Iterator[Any]:
    """Open a file with h5py, and turn every error of reading it into ValueError.

    Damage shows as any error of h5py, numpy or json. Raises OSError, and ValueError without h5py, or for a file that
    is no HDF5 file, lacks a part that is read, or is damaged.
    """
    if importlib.util.find_spec("h5py") is None:
        raise ValueError(f"{path}: HDF5 files need h5py: pip install 'viewimit[hdf5]', or export the tracks as CSV")
    import h5py

    require_file(path, MAX_HDF5_BYTES)
    if not h5py.is_hdf5(path):
        raise ValueError(f"{path}: not an HDF5 file")
    try:
        with h5py.File(path, "r") as file:
            _require_own_data(path, file)
            yield file
    except KeyError as error:
        raise ValueError(f"{path}: it lacks what files of its kind have: {error.args[0]}") from None
    except HDF5_ERRORS as error:
        if isinstance(error, ValueError) and str(error).startswith(f"{path}:"):
            raise
        raise ValueError(f"{path}: damaged, or no file of its kind: {error}; export it again, or as CSV") from None


def _require_own_data(path: Path, group: Any) -> None:
    """Raise ValueError for links and for data in other files, which could be anybody's."""
    import h5py

    for name in group:
        if not isinstance(group.get(name, getlink=True), h5py.HardLink):
            raise ValueError(f"{path}: {group.name}: {name!r} is a link, which is not followed: export it again")
        one = group[name]
        if isinstance(one, h5py.Dataset) and (one.external or one.is_virtual):
            raise ValueError(f"{path}: {one.name} has its data in other files, which are not read: export it again")
        if isinstance(one, h5py.Group):
            _require_own_data(path, one)


def read_dataset(dataset: Any) -> NDArray[Any]:
    """Read a whole dataset. Raises ValueError for one larger than tracks are, as empty chunks can claim any size."""
    size = int(dataset.size or 0) * dataset.dtype.itemsize
    if size > MAX_ARRAY_BYTES:
        raise ValueError(f"{dataset.name} has {size / MEGABYTE:,.0f} MB, more than {MAX_ARRAY_BYTES / MEGABYTE:g}")
    return dataset[()]


def as_text(value: Any) -> str:
    """Return bytes or a string as a string."""
    return value.decode("utf-8") if isinstance(value, bytes) else str(value)
