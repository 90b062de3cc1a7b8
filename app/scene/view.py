"""The default camera of a page's 3-D scene: where it is put, and when anew."""

import math
from collections import deque
from collections.abc import Callable, Iterable, Sequence

import numpy as np
from numpy.typing import NDArray
from viser import ClientHandle

from viewimit.simulation.scene_geometry import BELOW, FOV, fit_view

SAME_SHAPE = 0.01  # of an aspect: viser draws with fewer pixels when it is slow, and rounds their number
DOCKED_WITHIN = 3.0  # s
UNTOUCHED = 0.01  # m that a camera may be off a place where the page put it
NUDGE = 1e-3  # m: viser sends no place that equals the one that the browser told last, which may no longer be true
LATELY = 8  # such places: the browser may tell of an earlier one while the window's edge is dragged
BEFORE = (-5.0, 0.0, 0.0), (3.0, 3.0, 3.0)  # m, where three.js and then viser put a camera that nobody has put anywhere


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
        position, target = fit_view(landmarks, self._aspect or 1.0, BELOW)
        camera.fov = float(FOV)
        for aside in (NUDGE, 0.0):
            camera.position, camera.look_at = position + aside, target + aside
        self._places.append(position)

    @property
    def astray(self) -> bool:
        """Whether a camera that was put somewhere is told to be where viser had it: it had none yet to put there."""
        return self._aspect is not None and self._at(BEFORE)

    def follow(self, landmarks: Callable[[], NDArray]) -> None:
        """Fit a camera that is where the page put it to a canvas of another shape than before, or one that went
        astray."""
        aspect, astray = self.aspect, self.astray
        if aspect is None or (same_shape(aspect, self._aspect) and not astray):
            return
        self._aspect = aspect
        if astray or self._at((*BEFORE, *self._places)):
            self.fit(landmarks())

    def forget(self) -> None:
        """What was fitted is gone: the next `follow` fits anew."""
        self._aspect = None

    def _at(self, places: Iterable[Sequence[float] | NDArray]) -> bool:
        """Whether the camera is at one of places (3,) m."""
        here = self._client.camera.position
        return any(math.dist(here, place) < UNTOUCHED for place in places)


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
