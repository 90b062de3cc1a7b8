"""The message guard: what a browser may send, field by field, and what its own page has. Messages that are not
described here are refused before viser sees it. Real numbers are bounded, which NaN and infinities are not within.
Types and fields are those of viser._messages."""

import asyncio
import math
import weakref
from collections.abc import Callable
from typing import Annotated, Any, Literal

import msgspec
import viser
from msgspec import Meta

from .. import viser_private
from ..panels.actions import LABEL as ACTIONS_LABEL
from ..panels.actions import read_message

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


Gizmo = TransformControlsUpdateMessage | TransformControlsDragStartMessage | TransformControlsDragEndMessage


class _Kind(msgspec.Struct):
    type: str


_read_kind = msgspec.msgpack.Decoder(_Kind).decode
_READERS = {kind.__name__: msgspec.msgpack.Decoder(kind).decode for kind in _Message.__subclasses__()}


def read(raw: bytes | str) -> _Message:
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


MOST_BYTES = 4 << 20  # of one upload
PART = 524_288  # bytes that the page sends at once
MOST_UPLOADS = 1  # at a time
UPLOAD_WITHIN = 60.0  # s
MOST_TEXT = 2_000  # characters
SLACK = 1e-6  # of a range: rounding in the browser
UNIT = 1e-3  # that a direction's length may be off 1


class MessageValidator:
    """Checks messages against the client's own page. `admit` raises Refused or Hostile. belongs_to_another(uuid):
    whether some other client has such a widget."""

    def __init__(self, client: viser.ClientHandle, belongs_to_another: Callable[[str], bool]):
        self._client, self._belongs_to_another = client, belongs_to_another
        self._uploads = Uploads(lambda transfer: viser_private.drop_upload(client, transfer))
        self._checks: dict[type[_Message], Callable[[Any], None]] = {
            ViewerCameraMessage: lambda message: None,
            GuiUpdateMessage: self._check_update,
            CommandTriggerMessage: self._check_command,
            TransformControlsUpdateMessage: self._check_gizmo,
            TransformControlsDragStartMessage: self._check_gizmo,
            TransformControlsDragEndMessage: self._check_gizmo,
            ScenePointerMessage: self._check_click,
            FileTransferStartUpload: self._check_upload,
            FileTransferPart: self._uploads.add,
        }

    def admit(self, message: _Message) -> None:
        self._checks[type(message)](message)

    def _check_update(self, message: GuiUpdateMessage) -> None:
        widget = self._own(message.uuid)
        if set(message.updates) != {"value"}:
            raise Hostile(f"other fields of a widget than its value: {', '.join(message.updates)[:80]}")
        check = _CHECKS.get(type(widget))
        if check is None:
            raise Hostile(f"a value for a {type(widget).__name__}, which takes none")
        try:
            if widget.disabled:
                raise Refused("a value for a widget that is disabled")
            check(widget, message.updates["value"])
        except Refused:
            viser_private.push_value(self._client, widget)  # else the browser would go on showing the refused value
            raise

    def _check_command(self, message: CommandTriggerMessage) -> None:
        if message.uuid not in viser_private.own(self._client).commands:
            raise Refused("a command that this page does not have")

    def _check_gizmo(self, message: Gizmo) -> None:
        if message.name not in viser_private.own(self._client).gizmos:
            raise Refused("a handle in the scene that this page does not have")

    def _check_click(self, message: ScenePointerMessage) -> None:
        if not math.isclose(math.hypot(*message.ray_direction), 1, abs_tol=UNIT):
            raise Refused("a click along no direction")

    def _check_upload(self, message: FileTransferStartUpload) -> None:
        if not isinstance(self._own(message.source_component_uuid), viser.GuiUploadButtonHandle):
            raise Hostile("an upload to what takes none")
        self._uploads.begin(message)

    def _own(self, uuid: str):
        widget = viser_private.own(self._client).widgets.get(uuid)
        if widget is None and self._belongs_to_another(uuid):
            raise Hostile("a widget of another client")
        if widget is None:
            raise Refused("a widget that this page does not have")
        return widget


class Uploads:
    """A client's unfinished uploads: few, small, and not for ever. drop(transfer): forgets what has come of one."""

    def __init__(self, drop: Callable[[str], None]):
        self._drop = drop
        self._going_on: dict[str, tuple[FileTransferStartUpload, set[int]]] = {}
        self._refused: str | None = None  # transfer whose parts are still on their way

    def begin(self, message: FileTransferStartUpload) -> None:
        self._refused = message.transfer_uuid
        if message.size_bytes > MOST_BYTES:
            raise Refused(f"an upload of {message.size_bytes} bytes; at most {MOST_BYTES} are taken")
        if message.part_count != math.ceil(message.size_bytes / PART):
            raise Hostile(f"an upload of {message.size_bytes} bytes in {message.part_count} parts")
        if len(self._going_on) >= MOST_UPLOADS:
            raise Refused("an upload while another is unfinished")
        if message.transfer_uuid in self._going_on:
            raise Hostile("an upload that has begun already")
        self._refused = None
        if message.part_count:
            self._going_on[message.transfer_uuid] = message, set()
            asyncio.get_running_loop().call_later(
                UPLOAD_WITHIN, _end, weakref.WeakMethod(self.end), message.transfer_uuid
            )

    def add(self, part: FileTransferPart) -> None:
        if part.transfer_uuid not in self._going_on:
            was_refused = part.transfer_uuid == self._refused
            raise Refused("a part of an upload that was refused" if was_refused else "a part of no upload")
        begun, parts = self._going_on[part.transfer_uuid]
        if part.part_index >= begun.part_count or part.part_index in parts:
            raise Hostile(f"part {part.part_index} of {begun.part_count} of an upload")
        last = part.part_index == begun.part_count - 1
        expected = begun.size_bytes - PART * (begun.part_count - 1) if last else PART
        if len(part.content) != expected or part.source_component_uuid != begun.source_component_uuid:
            raise Hostile("a part of an upload that is not as announced")
        parts.add(part.part_index)
        if len(parts) == begun.part_count:
            del self._going_on[part.transfer_uuid]

    def end(self, transfer: str) -> None:
        """Drop an upload whose time is over."""
        if self._going_on.pop(transfer, None) is not None:
            self._drop(transfer)


def _end(end: weakref.WeakMethod, transfer: str) -> None:
    """End an upload of a client that is still there; the clock holds no client alive."""
    if (there := end()) is not None:
        there(transfer)


def _shown(value) -> str:
    """For the log. A nested value may be too deep to be written."""
    return repr(value)[:42] if isinstance(value, (str, int, float, type(None))) else f"a {type(value).__name__}"


def _check_number(widget, value) -> None:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise Refused(f"{_shown(value)}, which is no number")
    low = -math.inf if widget.min is None else widget.min
    high = math.inf if widget.max is None else widget.max
    slack = SLACK * max(1.0, abs(value))
    if not low - slack <= value <= high + slack:
        raise Refused(f"{value:.10g}, which is not between {low:g} and {high:.10g}")


def _check_option(widget, value) -> None:
    if not isinstance(value, str) or value not in widget.options:
        raise Refused(f"{_shown(value)}, which is none of the options")


def _check_switch(widget, value) -> None:
    if not isinstance(value, bool):
        raise Refused(f"{_shown(value)}, which is neither true nor false")


def _check_text(widget, value) -> None:
    if getattr(widget, "label", None) == ACTIONS_LABEL and isinstance(value, str):
        try:
            read_message(value)
        except ValueError as error:
            raise Refused(f"actions that make no sense: {str(error)[:80]}") from None
    elif not isinstance(value, str) or len(value) > MOST_TEXT:
        raise Refused(f"{_shown(value)}, which is no text of at most {MOST_TEXT} characters")


_CHECKS: dict[type, Callable] = {
    viser.GuiSliderHandle: _check_number,
    viser.GuiNumberHandle: _check_number,
    viser.GuiDropdownHandle: _check_option,
    viser.GuiButtonGroupHandle: _check_option,
    viser.GuiCheckboxHandle: _check_switch,
    viser.GuiButtonHandle: _check_switch,
    viser.GuiTextHandle: _check_text,
}
