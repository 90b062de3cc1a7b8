"""What runs in processes beside the server: camera images, an experiment, a basin of attraction, a PNG.

Nothing of viser is loaded. A process for an experiment or a basin carries out one request (name, settings, options),
and sends changes of its `Run`.
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

CAMERA_NICENESS, PNG_NICENESS, EXPERIMENT_NICENESS = 1, 5, 10  # drawing the pages goes first
TELLS_EVERY = 0.25  # s
MOST_BYTES = 64 << 20  # of the zip
PNG_WITHIN = 60.0  # s


def stand_back(niceness: int) -> None:
    """Leave Ctrl+C and a closed terminal to the server, which ends this process; let that go first; use one thread. To
    be called before numpy is loaded."""
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


QUALITY = 80  # of a JPEG: about 7 kB each
MOST_SCENES = 4  # whose eyes are kept
UNUSED_S = 120.0  # after which it ends; to begin takes 2 s


def look_at_scenes(connection: Connection) -> None:
    """Render camera images. It receives (scene, postures of both arms by pair of views, pair, posture of the arm that
    is looked at) and answers ("answer", image points, the two pictures as JPEG, postures afterwards), ("refused", why)
    for what cannot be, or ("failed", why) for a fault. It ends with the server, or when nobody looks for a while."""
    stand_back(CAMERA_NICENESS)  # received messages load numpy
    from viewimit.simulation.rendering import RenderedEyes

    answer_looks(connection, RenderedEyes, UNUSED_S)


def answer_looks(connection: Connection, make_eyes: Callable[[Any], Any], unused_s: float) -> None:
    """Answer until none has asked for `unused_s`. make_eyes(scene) → eyes as `RenderedEyes`."""
    made: list[tuple] = []  # scenes and their eyes
    try:
        while connection.poll(unused_s):
            connection.send(_looked(made, make_eyes, *connection.recv()))
    except (EOFError, ConnectionError):
        pass  # the server is gone


def _looked(made: list[tuple], make_eyes: Callable, scene, theta: dict, pair: str, posture) -> tuple:
    try:
        eyes = next((eyes for known, eyes in made if known == scene), None)
        if eyes is None:
            eyes = make_eyes(scene)
            made[:] = [*made[1 - MOST_SCENES :], (scene, eyes)]
        eyes.theta = theta
        images = (eyes.demo_images if pair == "lr" else eyes.own_images)(posture)
        return "answer", images, tuple(_jpeg(eyes.pictures[view]) for view in pair), eyes.theta
    except ValueError as error:
        return "refused", str(error)
    except Exception as error:  # any fault is sent to the session that asked
        traceback.print_exc()
        return "failed", f"{type(error).__name__}: {error}"


def _jpeg(picture) -> bytes:
    """picture: (height, width, 3) uint8 red, green, blue."""
    from PIL import Image

    packed = io.BytesIO()
    Image.fromarray(picture).save(packed, "JPEG", quality=QUALITY)
    return packed.getvalue()


if __name__ == "__main__":
    stand_back(PNG_NICENESS)
    from viewimit.drawing.export.figures import as_png

    sys.stdout.buffer.write(as_png(sys.stdin.buffer.read().decode()))
