"""A landscape as a file: .npz and .csv hold the data in degrees and px², .svg and .png the page's drawing of it."""

from pathlib import Path
from typing import Any

import numpy as np

from ..analysis.landscape import Landscape
from ..drawing.export import figures
from ..drawing.landscape import LandscapePicture
from ..drawing.plots import describe_settings
from ..loop.snapshot import Snapshot
from ..simulation.scene import Scene

PICTURES, TABLES = (".png", ".svg"), (".npz", ".csv")
TITLE = "E over the postures of the learner"


def require_format(path: Path) -> None:
    """Raises ValueError for an extension that is not written, or a PNG without what renders it."""
    suffix = path.suffix.lower()
    if suffix not in TABLES + PICTURES:
        raise ValueError(f"{path}: unknown extension {suffix!r}; there are {', '.join(TABLES + PICTURES)}")
    if suffix == ".png":
        figures.require_renderer(path, ".svg")


def write(path: Path, landscape: Landscape, scene: Scene, snapshot: Snapshot) -> None:
    """Write by extension. snapshot: the moment whose demonstrator and settings it is of. Raises OSError."""
    first, second = (np.degrees(axis) for axis in landscape.axes)
    names = [f"theta{joint}_deg" for joint in scene.moving_joints]
    if path.suffix.lower() == ".npz":
        columns: dict[str, Any] = dict(zip(names, (first, second)))
        with path.open("wb") as file:  # numpy would add the extension to a name that ends in .NPZ
            np.savez(file, E=landscape.E, demonstrator_deg=np.degrees(snapshot.theta_demo), **columns)
    elif path.suffix.lower() == ".csv":
        rows = np.stack([*np.meshgrid(first, second, indexing="ij"), landscape.E], -1).reshape(-1, 3)
        np.savetxt(path, rows, "%.10g", ",", header=",".join([*names, "E_px2"]), comments="")
    else:
        picture = LandscapePicture(landscape, scene, snapshot, contours="E in px²")
        drawing = picture.draw_alone(snapshot.settings)
        figures.write(path, figures.standalone(drawing, TITLE, describe_settings(snapshot.settings)))
