"""Links to a run: a query that is read from left to right, such as `?demo=45,-90&steps=8&noise=0.5&steps=4`.

What stands before the first `steps` is what the session begins with; each later field is a change at that moment.
Postures and other numbers come back to the last bit. What such a query cannot say, as points that were placed by hand,
is in its field `x`: JSON, deflated, in base 64. Links are read as hostile input, within bounds.
"""

import base64
import binascii
import math
import zlib
from collections.abc import Iterator, Sequence
from itertools import chain
from typing import Any
from urllib.parse import parse_qsl, quote_plus

import msgspec
import numpy as np

from .arm_and_eyes import to_degrees
from .script import (
    MAX_ACTIONS,
    Action,
    Begin,
    Calibrate,
    ChangeSettings,
    ClearCalibration,
    Looks,
    MoveDemonstrator,
    Script,
    Steps,
)
from .settings import Settings

MAX_LINK = 14_000  # characters: with what carries it, one message of the page
MAX_UNPACKED = 256_000  # bytes of JSON
MAX_CHANGES = 100  # restarts and changes of settings, each of which is validated
FIELDS = {  # words of a link: fields of `Settings`
    "demo" if name == "demonstrator_deg" else name.removesuffix("_deg").removesuffix("_px"): name
    for name in Settings.__struct_fields__
    if name not in ("body_points", "workspace_deg")
}
WORDS = {field: word for word, field in FIELDS.items()}
LISTS = ("demonstrator_deg", "start_deg", "joints", "undistort")
PACKED = "x"
ACTIONS = ("steps", "looks", "begin", "forget", "rehearse", *FIELDS)  # words that come one after another

Pairs = Sequence[tuple[str, str]]


class Packed(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True):
    """What stands in `x`: a script, and a recorded motion of the demonstrator as its file."""

    script: Script
    motion: bytes | None = None


def split(query: str) -> list[tuple[str, str]]:
    """Return the fields of a query in their order. Raises ValueError for one that is too long."""
    if len(query) > MAX_LINK:
        raise ValueError(f"the link is too long: {len(query)} characters of {MAX_LINK}")
    return parse_qsl(query.removeprefix("?"), keep_blank_values=True)


def joined(pairs: Pairs) -> str:
    """Return the query that has these fields."""
    return "&".join(f"{name}={quote_plus(text, safe=',;/:')}" for name, text in pairs)


def said(script: Script, base: Settings) -> list[tuple[str, str]]:
    """Say a script in the fields of a query. script: what to say; base: what the reader knows without being told, such
    as the settings of a preset, complete. Returns words and their values, in order. Raises ValueError if no field
    stands for something of it; `packed` can say that."""
    pairs = list(_differences(script.settings, base))
    has_begun = False  # whether a session is at work: a change then is no part of what it begins with
    for action in script.actions:
        if not has_begun and isinstance(action, MoveDemonstrator | ChangeSettings):
            pairs.append(("steps", "0"))  # it had looked already, which takes draws of noise
        has_begun = not isinstance(action, Begin)
        for name, text in _said(action, base):
            if name == "steps" and pairs and pairs[-1][0] == name:
                text = str(int(text) + int(pairs.pop()[1]))  # the last step may have made no motion
            pairs.append((name, text))
    return pairs


def _said(action: Action, base: Settings) -> Iterator[tuple[str, str]]:
    if isinstance(action, Steps):
        yield "steps", str(action.times)
    elif isinstance(action, Looks):
        yield "looks", str(action.times)
    elif isinstance(action, MoveDemonstrator):
        yield "demo", _degrees(action.theta_demo)
    elif isinstance(action, Begin):
        yield "begin", ""
        yield from _differences(action.settings, base)
    elif isinstance(action, ClearCalibration):
        yield "forget", ""
    elif isinstance(action, Calibrate):
        yield "rehearse", ";".join(map(_degrees, action.postures))
    else:
        yield _changed(action)


def _changed(action: ChangeSettings) -> tuple[str, str]:
    """Say a change of one setting; `demo` would be a move, and fields in a row are changes one after another."""
    names = list(action.fields)
    if len(names) != 1 or names[0] not in WORDS or names[0] == "demonstrator_deg":
        raise ValueError(f"no field says a change of {' and '.join(names)}")
    return WORDS[names[0]], _plain(action.fields[names[0]])


def _differences(settings: Settings, base: Settings) -> Iterator[tuple[str, str]]:
    for name in Settings.__struct_fields__:
        if (value := getattr(settings, name)) != getattr(base, name):
            if name not in WORDS:
                raise ValueError(f"no field says {name}")
            yield WORDS[name], _plain(value)


def _plain(value: Any) -> str:
    if value is None:
        return "none"
    if isinstance(value, bool):
        return str(int(value))
    if isinstance(value, tuple | list):
        return ",".join(map(_plain, value))
    return repr(value).removesuffix(".0") if isinstance(value, float) else str(value)


def _degrees(theta: Sequence[float]) -> str:
    """Say angles in the degrees that are these radians to the last bit, short ones where there are any."""
    return ",".join(_angle(rounded, angle) for rounded, angle in zip(to_degrees(np.array(theta)), theta))


def _angle(rounded: float, angle: float) -> str:
    near = float(np.degrees(angle))
    for degrees in (rounded, near, math.nextafter(near, math.inf), math.nextafter(near, -math.inf)):
        if float(np.radians(degrees)) == angle:
            return _plain(degrees)
    return f"{angle!r}rad"  # no number of degrees is that


def understood(pairs: Pairs, base: Settings, share: int = 1) -> Script:
    """Read the script that the fields of a query say.

    pairs: words of ACTIONS and their values, in order; base: what it is said against, complete; share: of how many
    scripts of one link it is one. Raises ValueError, in one line, for a word or a value that is not understood, and
    for more work than a link may ask for.
    """
    if sum(name not in ("steps", "looks", "demo") for name, _ in pairs) > MAX_CHANGES // share:
        raise ValueError(f"the link has more than {MAX_CHANGES // share} changes")
    begun, at = _beginning(pairs, 0, base)
    actions: list[Action] = []
    while at < len(pairs):
        name, text = pairs[at]
        at += 1
        if name == "begin":
            settings, at = _beginning(pairs, at, base)
            actions.append(Begin(settings))
        elif (name, text) != ("steps", "0"):
            actions.append(_action(name, text))
    return _bounded(Script(begun, tuple(actions)))


def _beginning(pairs: Pairs, at: int, base: Settings) -> tuple[Settings, int]:
    """Read the settings that a session begins with. Return where they end, too."""
    given: dict[str, Any] = {}
    while at < len(pairs) and pairs[at][0] in FIELDS:
        name, text = pairs[at]
        if FIELDS[name] in given:
            raise ValueError(f"the link has {name!r} twice before a step")
        given[FIELDS[name]] = _value(FIELDS[name], text)
        at += 1
    try:
        return msgspec.structs.replace(base, **given), at
    except ValueError as error:
        raise ValueError(f"the link cannot be opened: {_line(error)}") from None


def _action(name: str, text: str) -> Action:
    if name in ("steps", "looks"):
        if not (text.isascii() and text.isdecimal() and len(text) < 8 and int(text)):
            raise ValueError(f"the link's {name} must be a whole number from 1, got {text[:40]!r}")
        return (Steps if name == "steps" else Looks)(int(text))
    if name == "demo":
        return MoveDemonstrator(_radians(text))
    if name == "forget":
        return ClearCalibration()
    if name == "rehearse":
        return Calibrate(tuple(map(_radians, text.split(";"))))
    if name not in FIELDS:
        raise ValueError(f"the link has a field that is not known, {name[:40]!r}; there are {', '.join(ACTIONS)}")
    return ChangeSettings({FIELDS[name]: _value(FIELDS[name], text)})


def _value(field: str, text: str) -> Any:
    """Read the value of a field of `Settings`."""
    if text == "none":
        return None
    plain: Any = text.split(",") if field in LISTS else text
    try:
        return getattr(msgspec.convert({field: plain}, Settings, strict=False), field)
    except (msgspec.ValidationError, ValueError) as error:
        raise ValueError(f"the link cannot be opened: {_line(error)}") from None


def _radians(text: str) -> tuple[float, ...]:
    try:
        theta = [_angle_in(word) for word in text.split(",")]
    except ValueError:
        raise ValueError(f"the link has angles that are no numbers, {text[:40]!r}") from None
    if not all(map(math.isfinite, theta)):
        raise ValueError(f"the link has angles that are no numbers, {text[:40]!r}")
    return tuple(theta)


def _angle_in(word: str) -> float:
    return float(word[:-3]) if word.endswith("rad") else float(np.radians(float(word)))


def packed(script: Script, motion: bytes | None = None) -> str:
    """Return the text of `x` for a script and a recorded motion. Raises ValueError for one that is too long."""
    text = base64.urlsafe_b64encode(zlib.compress(msgspec.json.encode(Packed(script, motion)), 9)).decode().rstrip("=")
    if len(text) > MAX_LINK:
        raise ValueError(f"too much was done for a link: {len(text)} characters of {MAX_LINK}. Save a replay instead")
    return text


def unpacked(text: str, share: int = 1) -> Packed:
    """Read the text of `x`, of one of `share` scripts.

    Raises ValueError, in one line, for what is damaged or asks for too much.
    """
    try:
        data = base64.b64decode(text + "=" * (-len(text) % 4), altchars="-_", validate=True)
        content = zlib.decompressobj().decompress(data, MAX_UNPACKED + 1)
        if len(content) > MAX_UNPACKED:
            raise ValueError(f"more than {MAX_UNPACKED} bytes")
        _require_few(content, share)
        found = msgspec.json.decode(content, type=Packed)
    except (ValueError, zlib.error, binascii.Error, msgspec.MsgspecError, RecursionError) as error:
        raise ValueError(f"the link is damaged: {_line(error)}") from None
    return Packed(_bounded(found.script), found.motion)


class _Counted(msgspec.Struct):
    """The actions of `Packed`, uninterpreted."""

    class Inner(msgspec.Struct):
        deeds: list[msgspec.Raw] = []

    script: Inner


def _require_few(content: bytes, share: int) -> None:
    """Raise ValueError before many restarts are converted, each of which takes time."""
    actions = msgspec.json.decode(content, type=_Counted).script.deeds
    if len(actions) > MAX_ACTIONS // share:
        raise ValueError(f"more than {MAX_ACTIONS // share} actions")
    if sum(bytes(action)[:4] not in (b'["s"', b'["l"', b'["p"') for action in actions) > MAX_CHANGES // share:
        raise ValueError(f"more than {MAX_CHANGES // share} changes")


def _bounded(script: Script) -> Script:
    """Return a script that has no more actions than a session records, and finite angles."""
    if len(script.actions) > MAX_ACTIONS:
        raise ValueError(f"the link has more than {MAX_ACTIONS} actions")
    for action in script.actions:
        moves = (action.theta_demo,) if isinstance(action, MoveDemonstrator) else ()
        postures = action.postures if isinstance(action, Calibrate) else moves
        if not all(map(math.isfinite, chain.from_iterable(postures))):
            raise ValueError("the link has an angle that is no number")
    return script


def _line(error: Exception) -> str:
    return " ".join(str(error).split())[:200] or type(error).__name__
