"""What runs in the process of the camera images: looks and motions of each session that has pictures, by its key.

Sessions in the same scene share its eyes, of which only the postures last looked at are a session's own.

It receives (key, what, *arguments) and answers all but "close", in the order received: ("answer", value, pictures),
("refused", why) for what cannot be, ("failed", why) for a fault. Nothing of viser is loaded here.
"""

import io
import traceback
from collections.abc import Callable
from multiprocessing.connection import Connection

from .child import stand_back

NICENESS = 1  # drawing the pages goes first, experiments last
QUALITY = 80  # of a JPEG: about 7 kB each
MOST_SCENES = 4
LOOKS = {"demo_images": "lr", "own_images": "LR"}


def work(connection: Connection) -> None:
    """Serve until the other end is closed."""
    stand_back(NICENESS)  # received messages load numpy
    try:
        _serve(connection)
    except (EOFError, ConnectionError):
        pass  # the server is gone


def _serve(connection: Connection) -> None:
    from viewimit.simulation.rendering import RenderedEyes

    answer = answering(RenderedEyes)
    while True:
        reply = answer(*connection.recv())
        if reply is not None:
            connection.send(reply)


def answering(make_eyes: Callable) -> Callable:
    """answer(key, what, *arguments) → the reply, None for nothing. make_eyes(scene) → eyes as `RenderedEyes`."""
    scenes = Scenes(make_eyes)
    sessions: dict[int, tuple] = {}  # scene, and postures last looked at

    def carry_out(key: int, what: str, *arguments) -> tuple:
        if what == "open":
            eyes = scenes.eyes(*arguments)
            sessions[key] = *arguments, dict(eyes.rest)
            return "answer", eyes.noise_px, ()
        scene, theta = sessions[key]
        eyes = scenes.eyes(scene)
        eyes.theta = theta
        value = getattr(eyes, what)(*arguments)
        return "answer", value, tuple(_jpeg(eyes.pictures[view]) for view in LOOKS.get(what, ""))

    def answer(key: int, what: str, *arguments) -> tuple | None:
        if what == "close":
            sessions.pop(key, None)
            return None
        try:
            return carry_out(key, what, *arguments)
        except ValueError as error:
            return "refused", str(error)
        except Exception as error:  # any fault is sent to the session that asked
            traceback.print_exc()
            return "failed", f"{type(error).__name__}: {error}"

    return answer


class Scenes:
    """Eyes of the scenes that were looked at last; those of others are made again when they are needed again."""

    def __init__(self, make_eyes: Callable):
        self._make_eyes = make_eyes
        self._made: list[tuple] = []  # scenes and their eyes, the latest last

    def eyes(self, scene):
        found = next((made for made in self._made if made[0] == scene), None)
        if found is None:
            del self._made[: max(len(self._made) + 1 - MOST_SCENES, 0)]
            found = scene, self._make_eyes(scene)
        else:
            self._made.remove(found)
        self._made.append(found)
        return found[1]


def _jpeg(picture) -> bytes:
    """picture: (height, width, 3) uint8 red, green, blue."""
    from PIL import Image

    packed = io.BytesIO()
    Image.fromarray(picture).save(packed, "JPEG", quality=QUALITY)
    return packed.getvalue()
