"""What one session of a page looks with: projected points here, or pictures in the process of the camera images."""

import threading
from collections import OrderedDict
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from viewimit.loop.snapshot import Snapshot
from viewimit.simulation.eyes import SimulatedEyes, open_eyes, require_eyes
from viewimit.simulation.robot import load_markers
from viewimit.simulation.scene import Scene
from viewimit.simulation.world import World

from .camera_images import Cameras

MOST_PX = 1280 * 720  # of an image: a look takes 0.1 s then, for which all others wait
MOST_LOOKS = 60  # whose pictures are kept, of a session: 1 MB


class RemoteEyes:
    """As `viewimit.simulation.eyes.SimulatedEyes`; each look blocks until its pictures are there, which are kept for a
    while.

    ask(what, *arguments) → value, pictures.
    """

    def __init__(self, ask: Callable, scene: Scene, noise_px: float):
        self._ask = ask
        self.world = World(scene, body=load_markers(scene.robot).body)
        self.noise_px = noise_px
        self._looks: OrderedDict[tuple, dict[str, bytes]] = OrderedDict()
        self._lock = threading.Lock()  # of the looks: one thread looks, another draws

    def demo_images(self, theta) -> tuple[NDArray, NDArray]:
        return self._look("demo_images", "lr", theta)

    def own_images(self, theta) -> tuple[NDArray, NDArray]:
        return self._look("own_images", "LR", theta)

    def pictures(self, moment: Snapshot) -> dict[str, bytes]:
        """JPEGs by view, of those that are still kept."""
        with self._lock:
            looks = [self._looks.get(_look_key(*look), {}) for look in _looks_of(moment)]
        return {view: picture for look in looks for view, picture in look.items()}

    def retake(self, moment: Snapshot) -> None:
        """Take the pictures of a moment whose pictures are not kept any more."""
        for pair, theta in _looks_of(moment):
            if _look_key(pair, theta) not in self._looks:
                (self.demo_images if pair == "lr" else self.own_images)(theta)

    def _look(self, what: str, pair: str, theta) -> tuple[NDArray, NDArray]:
        theta = np.array(theta, float)
        images, pictures = self._ask(what, theta)
        with self._lock:
            self._looks[_look_key(pair, theta)] = dict(zip(pair, pictures))
            while len(self._looks) > MOST_LOOKS:
                self._looks.popitem(last=False)
        return images


class SessionEyes:
    """Opens the eyes of one session, one after the other; close() when the session is gone."""

    def __init__(self, process: Cameras):
        self._process = process
        self._key: int | None = None

    def __call__(self, sensor: str, scene: Scene, points: int) -> SimulatedEyes:
        """As `open_eyes`. Raises ValueError as `require_eyes` and `Cameras.open`, and for images of more than
        MOST_PX; CameraLost."""
        if sensor == "projected":
            eyes = open_eyes(sensor, scene, points)
            self.close()
            return eyes
        require_eyes(sensor, scene)
        width, height = scene.head.image
        if width * height > MOST_PX:
            raise ValueError(
                f"camera images of {width} × {height} px are too large for a page: 1280 × 720 are the most"
            )
        key, noise_px = self._process.open(scene, self._key)
        self._key = key
        return RemoteEyes(lambda *request: self._process.ask(key, *request), scene, noise_px)

    def close(self) -> None:
        if self._key is not None:
            self._process.close(self._key)
            self._key = None


def _looks_of(moment: Snapshot) -> tuple[tuple[str, NDArray], ...]:
    return ("lr", moment.theta_demo), ("LR", moment.theta)


def _look_key(pair: str, theta: NDArray) -> tuple[str, bytes]:
    return pair, theta.tobytes()
