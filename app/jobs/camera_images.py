"""Camera images are rendered beside the server: one process for all sessions that look with pictures.

It begins with the first of them, answers them in turn, and ends when none has looked with pictures for a while.
"""

import contextlib
import itertools
import multiprocessing
import threading
from collections.abc import Callable
from multiprocessing.connection import Connection

from viewimit.simulation.scene import Scene

from . import camera_child

MOST_SESSIONS = 8  # that share the seven motions a second of one process
UNUSED_S = 10.0  # after which it ends; to begin takes 2 s
ANSWERS_WITHIN_S = 30.0  # else it hangs


class CameraLost(Exception):
    """The process has ended, and with it the eyes that it had."""


class CameraProcess:
    """open → a key for `ask`; close; stop. For any thread; `ask` and `open` block until they are answered.

    most: sessions; unused_s: without any, after which the process ends; work: what runs in it.
    """

    def __init__(
        self,
        most: int = MOST_SESSIONS,
        unused_s: float = UNUSED_S,
        work: Callable[[Connection], None] = camera_child.work,
    ):
        self._most, self._unused_s, self._work = most, unused_s, work
        self._turn = threading.RLock()  # held until an answer is there
        self._sending = threading.Lock()
        self._keys: set[int] = set()
        self._next_key = itertools.count()
        self._process: multiprocessing.process.BaseProcess | None = None
        self._connection: Connection | None = None
        self._stopped = False

    @property
    def running(self) -> bool:
        process = self._process
        return process is not None and process.is_alive()

    def open(self, scene: Scene, key: int | None = None) -> tuple[int, float]:
        """Eyes for a scene, in place of those that a key has → key, noise_px.

        Raises ValueError if as many sessions as there may be have some, CameraLost.
        """
        with self._turn:
            new = key is None or key not in self._keys
            if key is None or new:
                if len(self._keys) >= self._most:
                    raise ValueError(f"camera images are in use by {len(self._keys)} others: try again later")
                key = next(self._next_key)
                self._start_if_ended()
                self._keys.add(key)
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
            if key not in self._keys or self._stopped:
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
        if key not in self._keys:
            return
        self._keys.discard(key)
        with contextlib.suppress(OSError):  # it has ended meanwhile
            self._send(key, "close")
        if not self._keys:
            timer = threading.Timer(self._unused_s, self._end_if_unused)
            timer.daemon = True
            timer.start()

    def stop(self) -> None:
        """End it, whoever waits for an answer."""
        self._stopped = True
        process = self._process
        if process is not None and process.is_alive():
            process.kill()
        with self._turn:
            self._end()

    def _start_if_ended(self) -> None:
        if self.running or self._stopped:
            return
        self._end()
        context = multiprocessing.get_context("spawn")
        self._connection, theirs = context.Pipe()
        with theirs:  # the child's end; while it is open here, its loss would go unnoticed
            self._process = context.Process(target=self._work, args=(theirs,), name="viewimit-camera", daemon=True)
            self._process.start()

    def _send(self, *message) -> Connection:
        """→ where the answer comes from"""
        with self._sending:
            if self._connection is None:
                raise BrokenPipeError
            self._connection.send(message)
            return self._connection

    def _end_if_unused(self) -> None:
        with self._turn:
            if not self._keys:
                self._end()

    def _end(self) -> None:
        """It has nothing to put in order."""
        self._keys.clear()
        with self._sending:
            if self._connection is not None:
                self._connection.close()
                self._connection = None
        if self._process is not None:
            self._process.kill()
            self._process.join()
            self._process.close()
            self._process = None
