"""What runs in processes beside the server: an experiment, a basin of attraction, a PNG. Nothing of viser is here.

A process of the first two carries out one request (name, settings, options), and sends changes of its `Run` by name.
"""

import io
import subprocess
import sys
import time
import traceback
import zipfile
from collections.abc import Callable
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from viewimit.geometry import limit_blas_threads
from viewimit.processes import ignore_interrupts, lower_priority

EXPERIMENT_NICENESS, PNG_NICENESS = 10, 5  # sessions go first
TELLS_EVERY = 0.25  # s
MOST_BYTES = 64 << 20  # of the zip
PNG_WITHIN = 60.0  # s


def stand_back(niceness: int) -> None:
    """Leave Ctrl+C and a closed terminal to the server, which ends this process; let that go first; use one thread.

    To be called before numpy is loaded.
    """
    ignore_interrupts()
    lower_priority(niceness)
    limit_blas_threads(override=True)


def carry_out_experiment(connection: Connection, folder: str) -> None:
    """Run an experiment of EXPERIMENTS. folder: for its files."""
    _answer(connection, partial(_run_experiment, Path(folder)))


def carry_out_basin(connection: Connection, folder: str) -> None:
    """Find from where the learner arrives with the settings."""
    _answer(connection, _find_basin)


def _answer(connection: Connection, carry_out: Callable) -> None:
    stand_back(EXPERIMENT_NICENESS)  # received messages load numpy
    tell = lambda **news: connection.send(news)
    try:
        carry_out(tell, *connection.recv())
    except (BrokenPipeError, ConnectionError):
        pass  # the server is gone
    except Exception as error:  # any fault is sent to the page that asked
        if not isinstance(error, ValueError):
            traceback.print_exc()
        why = str(error) if isinstance(error, ValueError) else f"{type(error).__name__}: {error}"
        tell(state="failed", problem=why)


def _run_experiment(folder: Path, tell: Callable[..., None], name: str, settings, options: dict) -> None:
    from viewimit.experiments import EXPERIMENTS
    from viewimit.experiments.experiment import write

    experiment = EXPERIMENTS[name]
    result = experiment.run(settings, Progress(tell, experiment.figure).tell, **options)
    if experiment.imitation is not None:
        tell(imitation=experiment.imitation(result))
    tell(state="writing", share=1.0, figure=experiment.figure(result), claims=tuple(result.claims))
    tell(state="done", archive=_zipped(write(name, experiment, result, folder)))


def _find_basin(tell: Callable[..., None], _name: str, settings, _options: dict) -> None:
    from viewimit.analysis.convergence import find_basin
    from viewimit.simulation.scene import load_scene

    from ..drawing.landscapes import draw_basin

    scene = load_scene(settings.scene, settings.robot, settings.joints, body_points=settings.body_points)
    draw = partial(draw_basin, scene)
    tell(state="done", share=1.0, figure=draw(find_basin(settings, Progress(tell, draw).tell)))


class Progress:
    """What a computation tells while it runs, no more often than a page can show it: its share, and a figure of the
    newest result that is not drawn yet. Finished work is drawn at the end in any case."""

    def __init__(self, tell: Callable[..., None], draw: Callable[[Any], str]):
        self._tell, self._draw = tell, draw
        self._told_at, self._undrawn = -TELLS_EVERY, None

    def tell(self, share: float, partial) -> None:
        self._undrawn = self._undrawn if partial is None else partial
        now = time.monotonic()
        if now - self._told_at < TELLS_EVERY:
            return
        self._told_at, news = now, dict[str, Any](share=float(share))
        if share < 1 and self._undrawn is not None:
            news["figure"], self._undrawn = self._draw(self._undrawn), None
        self._tell(**news)


def _zipped(paths: list[Path]) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in paths:
            archive.write(path, path.name)
    if buffer.tell() > MOST_BYTES:
        size = buffer.tell() >> 20
        raise ValueError(f"the files take {size} MB, more than the {MOST_BYTES >> 20} MB a page is sent")
    return buffer.getvalue()


def render(picture: str) -> bytes:
    """Return a standalone SVG as PNG, at print size, made in a process of its own. Raises ValueError if that fails."""
    ask = [sys.executable, "-m", __name__]
    try:
        return subprocess.run(ask, input=picture.encode(), stdout=-1, check=True, timeout=PNG_WITHIN).stdout
    except (subprocess.TimeoutExpired, subprocess.CalledProcessError):
        raise ValueError("the PNG could not be made; save it as SVG") from None


if __name__ == "__main__":
    stand_back(PNG_NICENESS)
    from viewimit.drawing.export.figures import as_png

    sys.stdout.buffer.write(as_png(sys.stdin.buffer.read().decode()))
