"""Where the 3-D scene is looked at from: a fixed direction, fitted to what must be seen and to the canvas."""

import numpy as np
from numpy.typing import NDArray

FOV = np.radians(36.0)
MARGIN = 0.93  # of the half angle that the default view fills
BELOW = 0.24  # of the canvas's height, from the bottom: what status and curves cover
AZIMUTH, ELEVATION = np.radians((-134.0, 27.0))  # from behind left: no image plate is seen edge-on


def looking() -> NDArray:
    """R_world_camera (3, 3) of the default view: right, down, forward."""
    forward = -np.array([np.cos(ELEVATION) * np.cos(AZIMUTH), np.cos(ELEVATION) * np.sin(AZIMUTH), np.sin(ELEVATION)])
    right = np.cross(forward, [0, 0, 1.0])
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(forward, right), forward], axis=-1)


def fitted_view(points: NDArray, aspect: float, below: float) -> tuple[NDArray, NDArray]:
    """Position and target of a camera from AZIMUTH, ELEVATION and FOV that just holds (k, 3) points.

    below: share of the height, from the bottom, that stays free. Each side of the frame is a plane through the
    eye, with a slope per depth; along its normal the points give one bound, and opposite bounds meet at the eye.
    """
    right, down, forward = looking().T
    up, backward = -down, -forward
    tan = np.tan(FOV / 2)
    x, y, z = points @ right, points @ up, points @ backward
    eye = []
    for coordinate, low_slope, high_slope in (
        (x, tan * aspect * MARGIN, tan * aspect * MARGIN),
        (y, tan * (1 - 2 * below) * MARGIN, tan * MARGIN),
    ):
        high, low = np.max(coordinate + high_slope * z), np.min(coordinate - low_slope * z)
        distance = (high - low) / (high_slope + low_slope)
        eye.append((distance, high_slope, low_slope, high, low))
    distance = max(eye[0][0], eye[1][0])
    centres = []  # of the room that is left where the other direction decides the distance
    for _, high_slope, low_slope, high, low in eye:
        centres.append((high - high_slope * distance + low + low_slope * distance) / 2)
    position = centres[0] * right + centres[1] * up + distance * backward
    depth = distance - np.mean(z)
    return position, position - depth * backward
