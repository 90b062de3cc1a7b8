"""HDF5 files, by h5py, which is an extra."""

import importlib.util
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from ..files import MEGABYTE, MOST_ARRAYS, require_file

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
