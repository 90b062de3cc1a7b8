"""What runs in an experiment's own process: the experiment, its figure, its files. Nothing of viser is loaded here.

It sends tuples: ("share", share done), ("figure", html), ("imitation", it), ("found", html, claims), ("files", zip),
("failed", why).
"""

import io
import time
import traceback
import zipfile
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from .child import stand_back

NICENESS = 10  # sessions go first
SHARE_EVERY, FIGURE_EVERY = 0.1, 0.25  # s at least between two of a kind
MOST_BYTES = 64 << 20  # of the zip


def work(connection: Connection, folder: str) -> None:
    """Carry out the one request (name, settings, options) that comes through the connection. folder: for the files."""
    answer(connection, lambda name, settings, options: _carry_out(connection, name, settings, options, Path(folder)))


def answer(connection: Connection, carry_out: Callable[[str, Any, dict], None]) -> None:
    """What a process does: carry_out(name, settings, options), or say why not."""
    stand_back(NICENESS)  # received messages load numpy
    try:
        carry_out(*connection.recv())
    except (BrokenPipeError, ConnectionError):
        pass  # the server is gone
    except Exception as error:  # any fault is sent to the page that asked
        if not isinstance(error, ValueError):
            traceback.print_exc()
        connection.send(("failed", _why(error)))


def _carry_out(connection: Connection, name: str, settings, options: dict, folder: Path) -> None:
    from viewimit.experiments import EXPERIMENTS
    from viewimit.experiments.experiment import write

    experiment = EXPERIMENTS[name]
    progress = Progress(connection.send, experiment.figure)
    result = experiment.run(settings, progress.tell, **options)
    if experiment.imitation is not None:
        connection.send(("imitation", experiment.imitation(result)))
    connection.send(("found", experiment.figure(result), tuple(result.claims)))
    connection.send(("files", _zipped(write(name, experiment, result, folder))))


class Progress:
    """What an experiment tells while it runs, no more often than a page can show it.

    A result that came too soon after another is drawn later, unless a newer one comes. Of finished work only the
    share is sent: it is drawn at the end in any case.
    """

    def __init__(self, send: Callable, draw: Callable[[Any], str], clock: Callable[[], float] = time.monotonic):
        self._send, self._draw, self._clock = send, draw, clock
        self._share_at = self._figure_at = -1e9
        self._undrawn = None

    def tell(self, share: float, partial) -> None:
        now = self._clock()
        if partial is not None:
            self._undrawn = partial
        if now - self._share_at >= SHARE_EVERY:
            self._share_at = now
            self._send(("share", float(share)))
        if share < 1 and self._undrawn is not None and now - self._figure_at >= FIGURE_EVERY:
            self._figure_at = now
            drawn, self._undrawn = self._draw(self._undrawn), None
            self._send(("figure", drawn))


def _zipped(paths: list[Path]) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in paths:
            archive.write(path, path.name)
    if buffer.tell() > MOST_BYTES:
        refusal = "the files take {size} MB, more than the {most} MB a page is sent"
        raise ValueError(refusal.format(size=buffer.tell() >> 20, most=MOST_BYTES >> 20))
    return buffer.getvalue()


def _why(error: Exception) -> str:
    return str(error) if isinstance(error, ValueError) else f"{type(error).__name__}: {error}"
