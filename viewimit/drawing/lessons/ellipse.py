"""The ellipse in which a recovered point lies if pixels are off."""

import numpy as np
from numpy.typing import NDArray


def draw_ellipse(at: NDArray, half_axes: NDArray, direction: float) -> str:
    """at, half_axes: (2,) units of the drawing, the longer one first; direction: rad, of that."""
    x, y = at.tolist()
    a, b = half_axes.tolist()
    turn = float(np.degrees(direction))
    return (
        f'<ellipse class="vi-spread vi-spread-large" rx="{a:.1f}" ry="{b:.1f}"'
        f' transform="translate({x:.1f} {y:.1f})rotate({turn:.1f})"/>'
    )
