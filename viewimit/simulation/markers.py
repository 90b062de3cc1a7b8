"""Coloured balls on an arm, by which a camera finds its body points: TOML files in assets/markers.

A ball looks like a disc from everywhere, and the middle of that disc is where its own middle is seen.
"""

from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..assets import ROOT
from ..sensing.files import parse_toml, read_toml
from .robot import BodyPoints

THIRDS = np.radians([0.0, 120.0, 240.0])
GREY, CHROMA = 0.5, 0.5  # the circle of hues that touches all six faces of the cube of colours


class Markers(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """radius: m; balls: [link, x, y, z, hue], its middle in that link's frame, m, and its hue, degrees."""

    radius: float
    balls: tuple[tuple[int, float, float, float, float], ...]

    @property
    def body(self) -> BodyPoints:
        rows = np.array(self.balls, float).reshape(-1, 5)
        return BodyPoints(rows[:, 0].astype(int), rows[:, 1:4])

    @property
    def hue_deg(self) -> NDArray:
        """(N,)"""
        return np.array(self.balls, float).reshape(-1, 5)[:, 4]


def colours(hue_deg: ArrayLike) -> NDArray:
    """(N,) degrees → (N, 3) red, green, blue in 0 … 1, of equal chroma: hue h is towards cos(h - 0°, 120°, 240°)."""
    return GREY + CHROMA * np.cos(np.radians(np.asarray(hue_deg))[..., None] - THIRDS)


def marker_names() -> list[str]:
    """Robots with markers, by name."""
    return sorted(path.stem for path in (ROOT / "markers").glob("*.toml"))


def load_markers(name: str | Path) -> Markers:
    """Of a shipped robot by name, or a TOML file by path. Raises ValueError that names the file and the field."""
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
