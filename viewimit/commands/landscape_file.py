"""A landscape as a file: .npz and .csv hold the data in degrees and px², .png and .svg a picture (matplotlib)."""

import importlib.util
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..analysis.landscape import Landscape

PICTURES, TABLES = (".png", ".svg"), (".npz", ".csv")
LEVELS = 24


def require_format(path: Path) -> None:
    """Raises ValueError for an extension that is not written, or a picture without matplotlib."""
    suffix = path.suffix.lower()
    if suffix not in TABLES + PICTURES:
        raise ValueError(f"{path}: unknown extension {suffix!r}; there are {', '.join(TABLES + PICTURES)}")
    if suffix in PICTURES and importlib.util.find_spec("matplotlib") is None:
        raise ValueError(f"{path}: {suffix} needs matplotlib: python -m pip install matplotlib")


def write(path: Path, landscape: Landscape, joints: tuple[int, int], theta_demo: NDArray) -> None:
    """Write by extension. joints: numbers from 1; theta_demo: (2,) rad. Raises OSError if that cannot be."""
    first, second = (np.degrees(axis) for axis in landscape.axes)
    names = [f"theta{joint}_deg" for joint in joints]
    if path.suffix.lower() == ".npz":
        columns = dict(zip(names, (first, second)))
        np.savez(path, E=landscape.E, demonstrator_deg=np.degrees(theta_demo), **columns)
    elif path.suffix.lower() == ".csv":
        rows = np.stack([*np.meshgrid(first, second, indexing="ij"), landscape.E], -1).reshape(-1, 3)
        np.savetxt(path, rows, "%.10g", ",", header=",".join([*names, "E_px2"]), comments="")
    else:
        _draw(path, landscape, joints, np.degrees(theta_demo))


def _draw(path: Path, landscape: Landscape, joints: tuple[int, int], demo_deg: NDArray) -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.4, 4.8), layout="constrained")
    axes = figure.subplots()
    first, second = (np.degrees(axis) for axis in landscape.axes)
    height = np.log10(np.maximum(landscape.E, np.finfo(float).tiny)).T
    shape = axes.contourf(first, second, np.ma.masked_invalid(height), LEVELS, cmap="cividis")
    figure.colorbar(shape, label="log₁₀ E (px²)")
    axes.plot(*np.degrees(landscape.minimum), "o", color="#E69F00", markeredgecolor="black", label="minimum")
    axes.plot(*demo_deg, "x", color="white", markersize=9, markeredgewidth=2, label="demonstrator")
    axes.set(xlabel=f"θ{joints[0]} (°)", ylabel=f"θ{joints[1]} (°)")
    axes.legend()
    figure.savefig(path, dpi=150)
