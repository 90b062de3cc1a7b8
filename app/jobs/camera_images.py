"""Camera images are rendered beside the server: one process for all sessions that look with pictures.

It begins with the first of them, answers them in turn, and ends when none has looked with pictures for a while.
"""

import contextlib
import itertools
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

from . import camera_child
from .experiments import begin, end

UNUSED_S = 10.0  # after which it ends; to begin takes 2 s
ANSWERS_WITHIN_S = 30.0  # else it hangs


class CameraLost(Exception):
    """The process has ended, and with it the eyes that it had."""


class CameraProcess:
    """open → a key for `ask`; close; stop. For any thread; `ask` and `open` block until they are answered.

    unused_s: without any session, after which the process ends; work: what runs in it.
    """

    def __init__(self, unused_s: float = UNUSED_S, work: Callable[[Connection], None] = camera_child.work):
        self._unused_s, self._work = unused_s, work
        self._turn = threading.RLock()  # held until an answer is there
        self._sending = threading.Lock()
        self._used: set[int] = set()
        self._next_key = itertools.count()
        self._process: BaseProcess | None = None
        self._connection: Any = None  # a Connection; on Windows a PipeConnection
        self._stopped = False

    @property
    def running(self) -> bool:
        process = self._process
        return process is not None and process.is_alive()

    def open(self, scene: Scene, key: int | None = None) -> tuple[int, float]:
        """Eyes for a scene, instead of those that a key has → key, noise_px. Raises CameraLost."""
        with self._turn:
            new = key is None or key not in self._used
            if key is None or new:
                key = next(self._next_key)
                if not self.running and not self._stopped:
                    self._end()
                    self._process, self._connection = begin(self._work, "viewimit-camera")
                self._used.add(key)
            try:
                return key, self.ask(key, "open", scene)[0]
            except BaseException:
                if new:
                    self.close(key)
                raise

    def ask(self, key: int, what: str, *arguments) -> tuple:
        """What the eyes of this key answer, and the pictures that they took for it, as JPEG.

        Raises ValueError, RuntimeError as they do, CameraLost.
        """
        with self._turn:
            if key not in self._used or self._stopped:
                raise CameraLost("the process of the camera images has ended")
            try:
                connection = self._send(key, what, *arguments)
                if not connection.poll(ANSWERS_WITHIN_S):
                    raise EOFError
                kind, *content = connection.recv()
            except (EOFError, OSError):
                self._end()
                raise CameraLost("the process of the camera images has ended unexpectedly") from None
        if kind == "refused":
            raise ValueError(content[0])
        if kind == "failed":
            raise RuntimeError(content[0])
        return tuple(content)

    def close(self, key: int) -> None:
        """Give up what the key has; returns at once."""
        if key not in self._used:
            return
        self._used.discard(key)
        with contextlib.suppress(OSError):  # it has ended meanwhile
            self._send(key, "close")
        if not self._used:
            timer = threading.Timer(self._unused_s, self._end_if_unused)
            timer.daemon = True
            timer.start()

    def stop(self) -> None:
        """End it, even while somebody waits for an answer."""
        self._stopped = True
        process = self._process
        if process is not None and process.is_alive():
            process.kill()
        with self._turn:
            self._end()

    def _send(self, *message) -> Any:
        """→ where the answer comes from"""
        with self._sending:
            if self._connection is None:
                raise BrokenPipeError
            self._connection.send(message)
            return self._connection

    def _end_if_unused(self) -> None:
        with self._turn:
            if not self._used:
                self._end()

    def _end(self) -> None:
        self._used.clear()
        with self._sending:
            if self._connection is not None:
                self._connection.close()
                self._connection = None
        if self._process is not None:
            end(self._process)
            self._process = None


# What one session of a page looks with: projected points here, or pictures in the process of the camera images.

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

    def __init__(self, process: CameraProcess):
        self._process = process
        self._key: int | None = None

    def __call__(self, sensor: str, scene: Scene, points: int) -> SimulatedEyes:
        """As `open_eyes`. Raises ValueError as `require_eyes` and `CameraProcess.open`, and for images of more than
        MOST_PX; CameraLost."""
        if sensor == "projected":
            eyes = open_eyes(sensor, scene, points)
            self.close()
            return eyes
        require_eyes(sensor, scene)
        width, height = scene.head.image
        if width * height > MOST_PX:
            refusal = "camera images of {width} × {height} px are too large for a page: 1280 × 720 are the most"
            raise ValueError(refusal.format(width=width, height=height))
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
