"""Which point a click in the 3-D scene means."""

import numpy as np
from numpy.typing import NDArray

REACH = 0.02  # of the canvas's height that a click may be off: a fingertip, 12 px of 600


def picked(
    points: NDArray, radius: NDArray, origin: NDArray, direction: NDArray, fov: float, surface: float = np.inf
) -> int | None:
    """Index of the one of (k, 3) points that a click at this ray means, None if all are too far from it.

    radius: (k,) m, as they are drawn; origin (3,) m, direction (3,): the ray; fov: rad, of the canvas's height;
    surface: m from the origin, where the ray ends: what is drawn behind that is hidden.
    Of points that are drawn under the click it is the one nearest to the eye, else the one nearest to the click.
    """
    away = points - origin
    depth = away @ (direction / np.linalg.norm(direction))
    aside = np.sqrt(np.maximum((away**2).sum(-1) - depth**2, 0))
    height = 2 * np.tan(fov / 2) * np.maximum(depth, 1e-6)  # m of the canvas at that depth
    off = np.where((depth > 0) & (depth - radius <= surface), np.maximum(aside - radius, 0) / height, np.inf)
    nearest = int(np.lexsort((depth, off))[0])
    return nearest if off[nearest] <= REACH else None
