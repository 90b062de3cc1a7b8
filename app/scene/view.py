"""The default camera of the 3-D scene: a fixed direction, fitted to what must be seen and to the canvas."""

from collections import deque
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from viser import ClientHandle

FOV = np.radians(36.0)
MARGIN = 0.93  # of the half angle that the default view fills
BELOW = 0.24  # of the canvas's height, from the bottom: what status and curves cover
SAME_SHAPE = 0.01  # of an aspect: viser draws with fewer pixels when it is slow, and rounds their number
DOCKED_WITHIN = 3.0  # s
UNTOUCHED = 0.01  # m that a camera may be off a place where the page put it
LATELY = 8  # such places: the browser may tell of an earlier one while the window's edge is dragged
AZIMUTH, ELEVATION = np.radians((-134.0, 27.0))  # from behind left: no image plate is seen edge-on


class DefaultView:
    """One page's camera, put where it shows all, until the visitor moves it."""

    def __init__(self, client: ClientHandle):
        self._client = client
        self._aspect: float | None = None  # of the canvas that was fitted last
        self._places = deque([np.array(client.camera.position)], LATELY)  # where it was found or put

    @property
    def aspect(self) -> float | None:
        """Width by height of the canvas, in whatever pixels; None while it has no size."""
        return aspect_of(self._client)

    def fit(self, landmarks: NDArray) -> None:
        """As near as the canvas allows. landmarks: (k, 3) m, what must be seen."""
        camera, self._aspect = self._client.camera, self.aspect
        position, target = fitted_view(landmarks, self._aspect or 1.0, BELOW)
        camera.fov = float(FOV)
        camera.position, camera.look_at = position, target
        self._places.append(position)

    def follow(self, landmarks: Callable[[], NDArray]) -> None:
        """Fit a camera that is where the page put it to a canvas of another shape than before."""
        aspect = self.aspect
        if aspect is None or same_shape(aspect, self._aspect):
            return
        self._aspect, here = aspect, self._client.camera.position
        if min(np.linalg.norm(here - place) for place in self._places) < UNTOUCHED:
            self.fit(landmarks())

    def forget(self) -> None:
        """What was fitted is gone: the next `follow` fits anew."""
        self._aspect = None


class Docking:
    """Panels come to stand beside a canvas that fills the window at first. What is drawn in it before is drawn twice,
    and fitted to the wrong shape. waits: whether there are panels to wait for."""

    def __init__(self, client: ClientHandle, waits: bool):
        self._client, self._waits, self._until = client, waits, np.inf
        self._aspect = aspect_of(client)

    def over(self, now: float) -> bool:
        """Whether they do, or seem never to; s of any clock."""
        if self._waits:
            self._until = min(self._until, now + DOCKED_WITHIN)
            self._waits = now < self._until and same_shape(aspect_of(self._client), self._aspect)
        return not self._waits


def aspect_of(client: ClientHandle) -> float | None:
    """Width by height of the canvas, in whatever pixels; None while it has no size."""
    width, height = client.camera.image_width, client.camera.image_height
    return width / height if min(width, height) > 0 else None


def same_shape(aspect: float | None, other: float | None) -> bool:
    if aspect is None or other is None:
        return aspect is other
    return bool(abs(np.log(aspect / other)) < SAME_SHAPE)


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
