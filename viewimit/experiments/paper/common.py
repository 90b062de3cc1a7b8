"""What the paper's figures share: progress, grids of postures, marks and legends."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...drawing import svg
from ...drawing.theme import OBSERVED

Progress = Callable[[float, Any], None]  # receives the share done, and the result so far or None


def no_progress(share: float, partial: Any) -> None:
    """Show nothing."""


def grid_rows(*axes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the points of a grid, (K, m), the last axis changing fastest."""
    return np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, len(axes))


def demonstrator_mark(place: NDArray[np.float64]) -> str:
    """Draw the diamond of the demonstrator's posture at (x, y) px."""
    return f'<path class="vi-seen" d="{svg.diamonds(place[None], OBSERVED + 1)}"/>'


def legend_marks(cross: float) -> list[tuple[str, str]]:
    """Return the marks on a map of E, each with its words. cross: size of the mark of the minimum, px."""
    here = np.array([8, 0])
    return [
        (demonstrator_mark(here), "demonstrator"),
        (svg.cross(here, cross), "smallest E"),
        (svg.saltire(here), "the paper's"),
    ]


def legend_entry(x: float, y: float, mark: str, words: str, gap: float = 25) -> str:
    """Draw a legend's entry at (x, y) px; gap: px from the mark to the words."""
    return f'<g transform="translate({x:.1f} {y})">{mark}{svg.text(gap, 4, words, "vi-2nd")}</g>'
