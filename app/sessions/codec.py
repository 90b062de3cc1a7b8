"""A session's history as bytes and back, to the last bit. Nothing in the bytes is ever run.

Objects are listed once, children first, however many snapshots share them; a value is a scalar, or the index of an
object in a list of one. Dataclasses are kept by their fields: those of the loop, and those that a transfer or servo
says it is `stored` as.
"""

import dataclasses
import re
from collections.abc import Sequence
from enum import Enum
from functools import cache

import msgspec
import numpy as np
import zstandard

from viewimit.estimation.rectification import RectifiedTransfer
from viewimit.estimation.transfers import TRANSFERS
from viewimit.estimation.views import FourViews
from viewimit.geometry.rectification import Rectification
from viewimit.loop.self_calibration import Body, SelfCalibration
from viewimit.loop.settings import OWN, Settings
from viewimit.loop.snapshot import Snapshot
from viewimit.servo import SERVOS, ServoStatus
from viewimit.servo.observation import Visit

from .kinds import fields_of, require_fields

MOST_BYTES = 8 << 20  # of a part, unpacked
SCALARS = (type(None), bool, int, float, str)
KINDS = "biuf"  # of arrays: numbers and truth values, no objects
DTYPE = re.compile(f"[<>|][{KINDS}][0-9]{{1,2}}")
OF_THE_LOOP = (Snapshot, FourViews, Rectification, RectifiedTransfer, SelfCalibration, Body, Visit)
ARRAY, SCALAR, STATUS, MEMBER, TUPLE, SETTINGS = "array", "scalar", "status", "member", "tuple", "settings"


def encode(snapshots: Sequence[Snapshot]) -> bytes:
    """Raises TypeError for what nobody has said how to store."""
    if any(OWN in (one.settings.transfer, one.settings.servo) for one in snapshots):
        raise TypeError("cannot keep it: it runs a transfer or a servo of your own, which no file can hold")
    packer = _Packer()
    values = [packer.value(one) for one in snapshots]
    try:
        packed = msgspec.msgpack.encode((packer.objects, values))
    except (OverflowError, msgspec.MsgspecError) as error:  # an integer beyond 64 bits, say
        raise TypeError(f"cannot keep it: {error}") from None
    if len(packed) > MOST_BYTES:
        raise TypeError(f"{len(snapshots)} of its moments take more than {MOST_BYTES >> 20} MB")
    return zstandard.compress(packed, 3)


def decode(data: bytes) -> list[Snapshot]:
    """Raises ValueError for what `encode` has not made."""
    return parsed(unpacked(data))


def unpacked(data: bytes, most: int = MOST_BYTES) -> bytes:
    """Raises ValueError for what is not packed, or takes more than so many bytes: no more are ever made of it."""
    try:
        with zstandard.ZstdDecompressor(max_window_size=MOST_BYTES).stream_reader(data) as reader:
            found = reader.read(most + 1)
    except zstandard.ZstdError as error:
        raise ValueError(f"no history of this version: {error!r}") from None
    if len(found) > most:
        raise ValueError(f"it unpacks to more than {most} bytes")
    return found


def parsed(plain: bytes) -> list[Snapshot]:
    """Of what `unpacked` gives. Raises ValueError for what `encode` has not packed."""
    try:
        listed, values = msgspec.msgpack.decode(plain)
        objects: list = []
        classes = _classes()
        for one in listed:
            objects.append(_object(one, objects, classes))
        moments = [_value(one, objects) for one in values]
    except (msgspec.MsgspecError, LookupError, TypeError, AttributeError, OverflowError, RecursionError) as error:
        raise ValueError(f"no history of this version: {error!r}") from None
    if not all(isinstance(one, Snapshot) for one in moments):
        raise ValueError("no history of this version: what is in it are no moments")
    return moments


class _Packer:
    def __init__(self):
        self.objects: list = []
        self._classes = _classes()
        self._index: dict[int, int] = {}
        self._alive: list = []  # what is named by its id must not be gone before the end

    def value(self, one):
        if type(one) in SCALARS:
            return one
        if id(one) not in self._index:
            listed = self._listed(one)
            self._alive.append(one)
            self._index[id(one)] = len(self.objects)
            self.objects.append(listed)
        return [self._index[id(one)]]

    def _listed(self, one) -> list:
        if isinstance(one, np.ndarray):
            if one.dtype.kind not in KINDS:
                raise TypeError(f"cannot keep an array of {one.dtype}")
            return [ARRAY, one.dtype.str, one.shape, one.tobytes()]
        if isinstance(one, np.generic):
            return [SCALAR, one.dtype.str, one.tobytes()]
        if type(one) is ServoStatus:
            return [STATUS, one.value]
        if isinstance(one, Enum) and self._classes.get(type(one).__name__) is type(one):
            return [MEMBER, type(one).__name__, one.value]
        if type(one) is tuple:
            return [TUPLE, [self.value(item) for item in one]]
        if isinstance(one, Settings):
            return [SETTINGS, msgspec.to_builtins(one)]
        if self._classes.get(type(one).__name__) is not type(one):
            raise TypeError(f"cannot keep a {type(one).__name__}")
        fields = _fields(one)
        try:
            require_fields(type(one), fields)
        except ValueError as error:  # which nobody could go on with
            raise TypeError(f"cannot keep it: {error}") from None
        return [type(one).__name__, {name: self.value(item) for name, item in fields.items()}]


def _classes() -> dict[str, type]:
    """What may be kept, by name. Raises TypeError if two classes have one name."""
    found: dict[str, type] = {kind.__name__: kind for kind in OF_THE_LOOP}
    stored = [method.stored for method in TRANSFERS.values()] + [servo.stored for servo in SERVOS.values()]
    for kind in (kind for kinds in stored for kind in kinds):
        if found.setdefault(kind.__name__, kind) is not kind:
            raise TypeError(f"two classes named {kind.__name__} are stored: rename one")
    return found


def _fields(one) -> dict:
    """What of an object is kept."""
    kind: type = type(one)
    return {name: getattr(one, name) for name in _names(kind)}


@cache  # thousands of objects a session are of few kinds, whose fields take longer to list than to pack
def _names(kind: type) -> tuple[str, ...]:
    return tuple(field.name for field in dataclasses.fields(kind))


def _value(one, objects: list):
    return objects[one[0]] if isinstance(one, list) else one


def _object(listed: list, objects: list, classes: dict[str, type]):
    kind, *content = listed
    if kind == ARRAY:
        return np.frombuffer(content[2], _dtype(content[0])).reshape(content[1]).copy()
    if kind == SCALAR:
        return np.frombuffer(content[1], _dtype(content[0]))[0]
    if kind == STATUS:
        return ServoStatus(content[0])
    if kind == MEMBER:
        return classes[content[0]](content[1])
    if kind == TUPLE:
        return tuple(_value(item, objects) for item in content[0])
    if kind == SETTINGS:
        return msgspec.convert(content[0], Settings)
    fields = {name: _value(item, objects) for name, item in content[0].items()}
    for name in fields.keys() & fields_of(classes[kind], ServoStatus):
        fields[name] = ServoStatus(fields[name]) if fields[name] else None  # earlier versions kept strings, "" for None
    require_fields(classes[kind], fields)
    return classes[kind](**fields)


def _dtype(name: str) -> np.dtype:
    if not DTYPE.fullmatch(name):
        raise ValueError(f"an array of {name[:40]}")
    return np.dtype(name)
