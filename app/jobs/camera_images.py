"""Camera images are rendered beside the server: one process for all sessions that look with pictures. It begins with
the first look, answers one after the other, and ends when nobody has looked for a while. A look says all that its
pictures depend on, so that a process that is lost is replaced by another."""

import threading
from collections import OrderedDict
from collections.abc import Callable
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Any

import numpy as np
from numpy.typing import NDArray

from viewimit.loop.snapshot import Snapshot
from viewimit.simulation.eyes import SimulatedEyes, open_eyes, require_eyes
from viewimit.simulation.robot import load_markers
from viewimit.simulation.scene import Scene
from viewimit.simulation.world import World

from . import child
from .experiments import begin, end

ANSWERS_WITHIN_S = 30.0  # else it hangs


class CameraLost(Exception):
    """There is no process that renders."""


class CameraProcess:
    """For any thread; `look` blocks until it is answered. work: what runs in the process."""

    def __init__(self, work: Callable[[Connection], None] = child.look_at_scenes):
        self._work, self._turn = work, threading.Lock()  # held until an answer is there
        self._process: BaseProcess | None = None
        self._connection: Any = None  # a Connection; on Windows a PipeConnection
        self._stopped = False

    @property
    def running(self) -> bool:
        process = self._process
        return process is not None and process.is_alive()

    def look(self, scene: Scene, theta: dict[str, NDArray], pair: str, posture: NDArray) -> tuple:
        """Return image points, pictures and postures, as `child` says. Raises ValueError, RuntimeError as it
        tells; CameraLost if two processes in turn have ended, or one hangs."""
        with self._turn:
            try:
                kind, *content = self._ask(scene, theta, pair, posture)
            except (EOFError, OSError):  # it was killed, or has just ended as nobody looked
                self._end()
                try:
                    kind, *content = self._ask(scene, theta, pair, posture)
                except (EOFError, OSError):
                    self._end()
                    raise CameraLost("the process of the camera images has ended unexpectedly") from None
        if kind == "refused":
            raise ValueError(content[0])
        if kind == "failed":
            raise RuntimeError(content[0])
        return tuple(content)

    def stop(self) -> None:
        """End it, even while somebody waits for an answer."""
        self._stopped = True
        process = self._process
        if process is not None and process.is_alive():
            process.kill()
        with self._turn:
            self._end()

    def _ask(self, *look: Any) -> tuple:
        if self._stopped:
            raise CameraLost("the camera images have ended with the server")
        if not self.running:
            self._end()
            self._process, self._connection = begin(self._work, "viewimit-camera")
        self._connection.send(look)
        if not self._connection.poll(ANSWERS_WITHIN_S):
            self._end()
            raise CameraLost("the process of the camera images does not answer")
        return self._connection.recv()

    def _end(self) -> None:
        (process, self._process), (connection, self._connection) = (self._process, None), (self._connection, None)
        if connection is not None:
            connection.close()
        if process is not None:
            end(process)


MOST_PX = 1280 * 720  # of an image: a look takes 0.1 s then, for which all others wait
MOST_LOOKS = 60  # whose pictures are kept, of a session: 1 MB


class RemoteEyes(SimulatedEyes):
    """Eyes in another process. Each look blocks until its pictures are there, which are kept for a while. look: as
    `CameraProcess.look`."""

    def __init__(self, look: Callable[..., tuple], scene: Scene):
        from viewimit.simulation.rendering import NOISE_PX

        self._remote, self._scene, self.noise_px = look, scene, NOISE_PX
        self.world = World(scene, body=load_markers(scene.robot).body)
        rest = np.radians(scene.posture_deg)[scene.moving]
        self._theta = {"lr": rest, "LR": rest}  # where each arm was seen last
        self._looks: OrderedDict[tuple, dict[str, bytes]] = OrderedDict()
        self._lock = threading.Lock()  # of the looks: one thread looks, another draws

    def demo_images(self, theta) -> tuple[NDArray, NDArray]:
        return self._look("lr", theta)

    def own_images(self, theta) -> tuple[NDArray, NDArray]:
        return self._look("LR", theta)

    def pictures(self, moment: Snapshot) -> dict[str, bytes]:
        """JPEGs by view, of those that are still kept."""
        with self._lock:
            looks = [self._looks.get(_look_key(*look), {}) for look in _looks_of(moment)]
        return {view: picture for look in looks for view, picture in look.items()}

    def retake(self, moment: Snapshot) -> None:
        """Take the pictures of a moment whose pictures are not kept any more."""
        for pair, theta in _looks_of(moment):
            if _look_key(pair, theta) not in self._looks:
                self._look(pair, theta)

    def _look(self, pair: str, theta) -> tuple[NDArray, NDArray]:
        theta = np.array(theta, float)
        images, pictures, self._theta = self._remote(self._scene, self._theta, pair, theta)
        with self._lock:
            self._looks[_look_key(pair, theta)] = dict(zip(pair, pictures))
            while len(self._looks) > MOST_LOOKS:
                self._looks.popitem(last=False)
        return images


def eyes_beside(process: CameraProcess) -> Callable[[str, Scene, int], SimulatedEyes]:
    """Return what opens a session's eyes, as `open_eyes` does, but with pictures of that process, of MOST_PX at
    most."""

    def opened(sensor: str, scene: Scene, points: int) -> SimulatedEyes:
        if sensor == "projected":
            return open_eyes(sensor, scene, points)
        require_eyes(sensor, scene)
        width, height = scene.head.image
        if width * height > MOST_PX:
            raise ValueError(
                f"camera images of {width} × {height} px are too large for a page: 1280 × 720 are the most"
            )
        return RemoteEyes(process.look, scene)

    return opened


def _looks_of(moment: Snapshot) -> tuple[tuple[str, NDArray], ...]:
    return ("lr", moment.theta_demo), ("LR", moment.theta)


def _look_key(pair: str, theta: NDArray) -> tuple[str, bytes]:
    return pair, theta.tobytes()
