"""What is kept of a page, and its checks when it comes back: a store may hold what no page has written."""

from dataclasses import dataclass
from typing import Annotated

import msgspec
import numpy as np

from viewimit import __version__
from viewimit.loop.history import MAX_HISTORY
from viewimit.loop.script import Log
from viewimit.loop.settings import OWN, Settings
from viewimit.loop.snapshot import Snapshot

from . import codec

CHUNK = 32  # motions a part
HEAD = "head"
MOST_SPEED = 1_000.0  # motions a second
MOST_BYTES = 16 << 20  # of a session, as it is kept
MOST_UNPACKED = 64 << 20  # bytes of it

Length = Annotated[int, msgspec.Meta(ge=1, le=MAX_HISTORY + 1)]
Index = Annotated[int, msgspec.Meta(ge=0, le=MAX_HISTORY)]
Speed = Annotated[float, msgspec.Meta(ge=0, le=MOST_SPEED)]  # NaN is neither


class SavedPage(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A page but for its history. begun: what the server was started with; motion: a recorded one, as a file has it;
    offered: whether the tour is; log: how the session came to where it is."""

    version: str = __version__
    begun: Settings
    cursor: Index
    length: Length
    preset: str
    speed: Speed
    chosen: Index | None
    show: dict[str, bool]
    dark: bool | None
    motion: bytes | None
    offered: bool = False
    log: Log | None = None


@dataclass(frozen=True, eq=False)
class SavedSession:
    """All that is kept of a page, at one moment."""

    head: SavedPage
    history: tuple[Snapshot, ...]


def decoded(parts: dict[str, bytes], begun: Settings, unpacked: int = MOST_UNPACKED) -> SavedSession | None:
    """None without a session that goes on from these settings. unpacked: bytes that all parts may take together.

    Raises ValueError for parts that do not fit, or that hold what no session has.
    """
    if HEAD not in parts:
        return None
    if not all(isinstance(data, bytes) for data in parts.values()):
        raise ValueError("a part of it is no bytes")
    try:
        head = msgspec.msgpack.decode(parts[HEAD], type=SavedPage)
    except msgspec.MsgspecError as error:
        raise ValueError(f"it is of another version: {error}") from None
    if head.version != __version__ or head.begun != begun:
        return None
    names = [str(k) for k in range(chunks(head.length))]
    if not parts.keys() >= set(names):
        raise ValueError("a part of it is missing")
    history: list[Snapshot] = []
    for name in names:
        plain = codec.unpacked(parts[name], min(unpacked, codec.MOST_BYTES))
        unpacked -= len(plain)
        moments = codec.parsed(plain)
        if len(moments) > CHUNK:
            raise ValueError(f"more than {CHUNK} moments in a part")
        history += moments
    if len(history) != head.length or head.cursor >= head.length or history[head.cursor].motion != head.cursor:
        raise ValueError("its parts are of different moments")
    _require_moments(history)
    return SavedSession(head, tuple(history))


def chunks(length: int) -> int:
    """Parts that so many moments take."""
    return -(-length // CHUNK)


def _require_moments(history: list[Snapshot]) -> None:
    """Raises ValueError for a moment out of its order, or arrays that are not of one arm and one set of points."""
    joints, points = history[0].theta.shape, history[0].views.demo.shape
    if len(joints) != 1 or len(points) != 2 or points[1] != 4:
        raise ValueError("a posture and points have other dimensions")
    for k, moment in enumerate(history):
        if not 0 <= moment.motion <= k or history[moment.motion].motion != moment.motion:
            raise ValueError(f"moment {k} is after {moment.motion} motions")
        if OWN in (moment.settings.transfer, moment.settings.servo):
            raise ValueError(f"moment {k}: it runs a transfer or a servo that only its author has")
        views = moment.views
        on_its_way = () if moment.target is None else (moment.target,)
        postures = moment.theta, moment.theta_demo, moment.commanded, moment.moved, *on_its_way
        if any(one.shape != joints or not np.isfinite(one).all() for one in postures):
            raise ValueError(f"moment {k}: postures are not finite angles of the same joints")
        if on_its_way and moment.servo_state is None:
            raise ValueError(f"moment {k}: no servo has sent the arm to where it is on its way")
        images = views.demo, views.own, views.visible
        if any(one.shape != points for one in images) or views.visible.dtype != bool:
            raise ValueError(f"moment {k}: images are not of the same points")
        if not isinstance(moment.servo_state, (type(None), *moment.servo.stored)):
            raise ValueError(f"moment {k}: its servo has another state than {type(moment.servo_state).__name__}")
