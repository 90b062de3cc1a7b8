"""What a browser may send, field by field. Whatever is not described here is refused before viser sees it.

Real numbers are bounded, which NaN and infinities are not within. Types and fields are those of viser._messages.
"""

from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta

MOST_BUT_PARTS = 1 << 14  # bytes of a message that is no part of a file: to read it takes 1.2 ms at most
Real = Annotated[float, Meta(ge=-1e5, le=1e5)]
Count = Annotated[int, Meta(ge=0, le=100_000)]
Size = Annotated[int, Meta(ge=0, le=2**53)]
Name = Annotated[str, Meta(max_length=200)]
Pair = tuple[Real, Real]
Triple = tuple[Real, Real, Real]
Quaternion = tuple[Real, Real, Real, Real]


class Refused(ValueError):
    """A message that a browser in good faith may send, when a page changes under it; it is dropped."""


class Hostile(ValueError):
    """A message that no browser sends; its connection is closed."""


class _Message(msgspec.Struct, forbid_unknown_fields=True):
    type: str


class ViewerCameraMessage(_Message):
    wxyz: Quaternion
    position: Triple
    fov: Real
    near: Real
    far: Real
    image_height: Count
    image_width: Count
    look_at: Triple
    up_direction: Triple


class GuiUpdateMessage(_Message):
    uuid: Name
    updates: dict[str, Any]


class CommandTriggerMessage(_Message):
    uuid: Name


class TransformControlsUpdateMessage(_Message):
    name: Name
    wxyz: Quaternion
    position: Triple
    owner: Name


class TransformControlsDragStartMessage(_Message):
    name: Name
    owner: Name


class TransformControlsDragEndMessage(_Message):
    name: Name
    owner: Name


class ScenePointerMessage(_Message):
    event_type: Literal["click"]
    ray_origin: Triple
    ray_direction: Triple
    screen_pos: tuple[Pair]
    modifier: None


class FileTransferStartUpload(_Message):
    source_component_uuid: Name
    transfer_uuid: Name
    filename: Name
    mime_type: Name
    part_count: Size
    size_bytes: Size


class FileTransferPart(_Message):
    source_component_uuid: Name
    transfer_uuid: Name
    part_index: Size
    content: bytes


ALLOWED = (
    ViewerCameraMessage,
    GuiUpdateMessage,
    CommandTriggerMessage,
    TransformControlsUpdateMessage,
    TransformControlsDragStartMessage,
    TransformControlsDragEndMessage,
    ScenePointerMessage,
    FileTransferStartUpload,
    FileTransferPart,
)


class _Kind(msgspec.Struct):
    type: str


_read_kind = msgspec.msgpack.Decoder(_Kind).decode
_READERS = {kind.__name__: msgspec.msgpack.Decoder(kind).decode for kind in ALLOWED}


def read(raw: bytes | str) -> msgspec.Struct:
    """A message as it came. Raises Hostile, or Refused for values out of their range."""
    if isinstance(raw, str):
        raise Hostile("text, which is no message")
    try:
        kind = _read_kind(raw).type
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise Hostile(f"a malformed message: {error}") from None
    if kind not in _READERS:
        raise Hostile(f"a message of the type {kind[:40]!r}")
    if len(raw) > MOST_BUT_PARTS and kind != FileTransferPart.__name__:
        raise Hostile(f"a {kind} of more than {MOST_BUT_PARTS} bytes")
    try:
        return _READERS[kind](raw)
    except msgspec.ValidationError as error:
        raise Refused(f"{kind}: {error}") from None
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise Hostile(f"a malformed {kind}: {error}") from None
