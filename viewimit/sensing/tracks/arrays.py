"""Read arrays of tracks from .npz and .npy files, as CoTracker and TAPIR return them, and open HDF5 files.

CoTracker   pred_tracks (1, frames, points, 2) and pred_visibility (1, frames, points)
TAPIR       tracks (points, frames, 2) and visibles (points, frames)

An .npz file may have `names`, one for each point. The names of tracks.npy are the lines of tracks.txt beside it. If
nothing else does, the number of names tells which axis is of points.
"""

import importlib.util
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..files import DAMAGED, MAX_ARRAY_BYTES, MEGABYTE, TooLarge, read_npz, require_file
from .columns import SEEN, Meaning, as_numbers, meaning_of, name_unread, refuse, require_pixel_unit
from .numbering import FrameLabels
from .track import Track, require_cells, with_seen

TRACKS = ("pred_tracks", "tracks", "points")
NAMES = ("names", "point_names", "node_names")
FRAMES_FIRST = ("pred_visibility", "visibility", "visibilities", "confidence")  # CoTracker's order of axes
POINTS_FIRST = ("visibles", "occluded", "occlusions")  # TAPIR's
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
    refuse(str(path), found)
    about = [name for name, values in found.items() if meaning_of(name) in SEEN and values.ndim > 1]
    points_first = _has_points_first(path, found[key], key, about, None if names is None else len(names))
    given = tracks.shape[:2]
    tracks = tracks.swapaxes(0, 1) if points_first else tracks
    T, N = tracks.shape[:2]
    numbers, frames = _numbers_of_frames(found, T)
    units = [name for name in found if meaning_of(name) is Meaning.UNIT]
    for name in units:
        require_pixel_unit(f"{path}: {name}", str(found[name].ravel()[0]) if found[name].size else "")
    unread = [name for name in found if name not in (key, *NAMES, *about, numbers, *units)]
    points = tuple(map(as_text, range(N) if names is None else names.tolist()))
    order = np.argsort(frames, kind="stable")
    image, unread_words = tracks[order].astype(float), name_unread("array", unread)
    track = Track(frames[order], points, image, np.zeros((T, N)), unread=unread_words)
    seen = [(meaning_of(one), _about_points(path, one, found[one], given, points_first)[order]) for one in about]
    return with_seen(str(path), track, seen)


def _numbers_of_frames(found: dict[str, NDArray[Any]], T: int) -> tuple[str, NDArray[np.uint64]]:
    """The array that numbers the frames and what it says; without one, "" and 0 to T - 1."""
    for name, values in found.items():
        if meaning_of(name) not in (Meaning.FRAME, Meaning.PICTURE) or values.shape != (T,):
            continue
        labels = FrameLabels()
        try:
            at = [labels.add(str(value)) for value in values.tolist()]
        except ValueError:
            continue
        frames = labels.numbers()[at]
        if len(np.unique(frames)) == T:
            return name, frames
    return "", np.arange(T, dtype=np.uint64)


def _load(path: Path) -> dict[str, NDArray[Any]]:
    require_file(path, MAX_ARRAY_BYTES)
    try:
        found = read_npz(path) if path.suffix.lower() == ".npz" else {"tracks": np.load(path)}
    except TooLarge:
        raise
    except (*DAMAGED, OSError):
        raise ValueError(f"{path}: not an array of numbers that numpy has saved; save as {SAVE}") from None
    beside = path.with_suffix(".txt")
    if path.suffix.lower() == ".npy" and beside.is_file():
        names = [name.strip() for name in beside.read_text("utf-8", errors="replace").splitlines()]
        found["names"] = np.array([name for name in names if name])
    return found


def _unbatched(values: NDArray[Any], dims: int) -> NDArray[Any]:
    return values[0] if values.ndim == dims + 1 and len(values) == 1 else values


def _has_points_first(path: Path, tracks: NDArray[Any], key: str, about: Sequence[str], n_names: int | None) -> bool:
    """Whether the first axis is of points, by the names, the key or a batch. Raises ValueError if nothing tells."""
    first, second = _unbatched(tracks, 3).shape[:2]
    if n_names is not None and n_names not in (first, second):
        raise ValueError(f"{path}: {n_names} names, but {key} has shape {tracks.shape}: one name a point is needed")
    if n_names is not None and first != second:
        return n_names == first
    if set(about) & set(POINTS_FIRST):
        return True
    if key == "pred_tracks" or set(about) & set(FRAMES_FIRST) or tracks.ndim == 4:
        return False
    raise ValueError(f"{path}: {key} has shape {tracks.shape}: which axis is of points? Save as {SAVE}")


def _about_points(
    path: Path, key: str, values: NDArray[Any], shape: tuple[int, ...], points_first: bool
) -> NDArray[np.float64]:
    """What an array says of whether points are seen, (frames, points). shape: of the tracks, in the file's order."""
    values = values[..., 0] if values.ndim > 2 and values.shape[-1] == 1 else values
    found = as_numbers(f"{path}: {key}", meaning_of(key), _unbatched(values, 2))
    if found.shape not in (shape, shape[::-1]):
        T, N = shape[::-1] if points_first else shape
        raise ValueError(f"{path}: {key} has shape {values.shape}, which does not fit {T} frames of {N} points")
    return found.T if points_first == (found.shape == shape) else found


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
