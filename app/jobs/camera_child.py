"""What runs in the process of the camera images: looks at a scene, one after the other. Nothing of viser is loaded.

It receives (scene, postures of both arms by pair of views, pair, posture of the arm that is looked at) and answers
("answer", image points, the two pictures as JPEG, postures afterwards), ("refused", why) for what cannot be, or
("failed", why) for a fault. It ends when the server is gone, or when nobody has looked for a while.
"""

import io
import traceback
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any

from .child import stand_back

NICENESS = 1  # drawing the pages goes first, experiments last
QUALITY = 80  # of a JPEG: about 7 kB each
MOST_SCENES = 4  # whose eyes are kept
UNUSED_S = 120.0  # after which it ends; to begin takes 2 s


def work(connection: Connection) -> None:
    stand_back(NICENESS)  # received messages load numpy
    from viewimit.simulation.rendering import RenderedEyes

    serve(connection, RenderedEyes, UNUSED_S)


def serve(connection: Connection, make_eyes: Callable[[Any], Any], unused_s: float) -> None:
    """Answer until none has asked for `unused_s`. make_eyes(scene) → eyes as `RenderedEyes`."""
    made: list[tuple] = []  # scenes and their eyes
    try:
        while connection.poll(unused_s):
            connection.send(_answer(made, make_eyes, *connection.recv()))
    except (EOFError, ConnectionError):
        pass  # the server is gone


def _answer(made: list[tuple], make_eyes: Callable, scene, theta: dict, pair: str, posture) -> tuple:
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
