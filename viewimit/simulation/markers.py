"""Coloured balls that mark body points on an arm: TOML files in assets/markers.

A ball looks like a disc from every side, and the centre of the disc is the image of the centre of the ball.
"""

from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..assets import ROOT
from ..sensing.files import parse_toml, read_toml
from .robot import BodyPoints

THIRDS = np.radians([0.0, 120.0, 240.0])
GREY, CHROMA = 0.5, 0.5  # the circle of hues that touches all six faces of the RGB cube


class Markers(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The balls on one arm."""

    radius: float  # m
    balls: tuple[tuple[int, float, float, float, float], ...]  # link, x, y, z in its frame [m], hue [deg]

    @property
    def body(self) -> BodyPoints:
        """Centres of the balls."""
        rows = np.array(self.balls, float).reshape(-1, 5)
        return BodyPoints(rows[:, 0].astype(int), rows[:, 1:4])

    @property
    def hue_deg(self) -> NDArray[np.float64]:
        """(N,) hues [deg]."""
        return np.array(self.balls, float).reshape(-1, 5)[:, 4]


def colours(hue_deg: ArrayLike) -> NDArray[np.float64]:
    """Return colours of equal chroma, towards cos(hue - (0°, 120°, 240°)): (N,) deg -> (N, 3) RGB in 0 … 1."""
    return GREY + CHROMA * np.cos(np.radians(np.asarray(hue_deg))[..., None] - THIRDS)


def marker_names() -> list[str]:
    """Return the names of the shipped robots with markers."""
    return sorted(path.stem for path in (ROOT / "markers").glob("*.toml"))


def load_markers(name: str | Path) -> Markers:
    """Read the markers of a shipped robot, or a TOML file. Raises ValueError that names the file and the field."""
    path = Path(name)
    if path.suffix.lower() != ".toml":
        path = ROOT / "markers" / f"{name}.toml"
    if not path.is_file():
        names = ", ".join(marker_names())
        raise ValueError(f"no markers {str(name)!r}; there are {names}, or the path of a .toml file")
    try:
        markers = parse_toml(read_toml(path), Markers)
    except (msgspec.DecodeError, msgspec.ValidationError, ValueError) as error:
        raise ValueError(f"{path}: {error}") from None
    if not markers.radius > 0 or not np.isfinite(np.array(markers.balls, float)).all():
        raise ValueError(f"{path}: radius must be positive, and all numbers finite")
    if len(set(markers.hue_deg.tolist())) < len(markers.balls):
        raise ValueError(f"{path}: two balls have the same hue")
    return markers
