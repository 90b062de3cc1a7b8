"""Links that people can read and write, such as `?preset=paper&demo=45,-90&steps=3`: what differs from a preset."""

from collections.abc import Iterator, Mapping
from typing import Any
from urllib.parse import parse_qsl, urlencode

import msgspec
import numpy as np

from viewimit.drawing.export.panels import largest_residual
from viewimit.loop.embodiment import to_degrees
from viewimit.loop.script import Begin, ChangeSettings, MoveDemonstrator, Script, Steps
from viewimit.loop.session import Session
from viewimit.loop.settings import OWN, Settings
from viewimit.loop.simulated_robot import complete
from viewimit.loop.snapshot import Snapshot
from viewimit.simulation.robot import robot_names
from viewimit.simulation.scene import scene_names

from ..sessions.link import Branch, Run, SavedPage, decode, require_allowed
from .choices import FLAGS, PRESETS, SPEEDS, SWITCHES, Preset, View, presets_from
from .page_model import PageModel

FIELDS = {  # of a link: the fields of `Settings`
    "demo" if name == "demonstrator_deg" else name.removesuffix("_deg").removesuffix("_px"): name
    for name in Settings.__struct_fields__
    if name not in ("body_points", "workspace_deg")
}
LISTS = ("demonstrator_deg", "start_deg", "joints", "undistort")
MAX_STEPS = 20_000
MAX_READABLE = 2_000  # characters


class NotReadable(Exception):
    """What a page shows does not follow from settings and a number of steps alone."""


def read_link(text: str, begun: Settings) -> SavedPage:
    """Read a link, readable or packed. begun: what the server was started with. Raises ValueError, in one line."""
    return _read(text, begun) if "=" in text else decode(text, begun)


def write_link(model: PageModel) -> str:
    """Return the readable link to what a page shows. Raises NotReadable if there is none."""
    session, view = model.session, model.view
    if model.duel.opponent is not None:
        raise NotReadable  # a duel has two learners
    begin, steps = _beginning(session)
    if steps > MAX_STEPS:
        raise NotReadable
    preset = model.preset if model.preset.key else _nearest(begin)
    fields = {"preset": preset.key} | dict(_differences(begin, complete(preset.settings)))
    if steps:
        fields["steps"] = str(steps)
    if model.player.speed != preset.motions_per_second:
        fields["speed"] = f"{model.player.speed:g}"
    if view.chosen != largest_residual(session.snapshot):
        fields["point"] = "none" if view.chosen is None else str(view.chosen)
    default = View()
    for name in SWITCHES:
        if getattr(view, name) != getattr(default, name):
            fields[name] = str(int(getattr(view, name)))
    return urlencode(fields, safe=",")


def _beginning(session: Session) -> tuple[Settings, int]:
    """Return the settings that a session could have begun with, and its number of steps since."""
    actions = list(session.script.actions)
    begins = [k for k, action in enumerate(actions) if isinstance(action, Begin)]
    since = actions[begins[-1] + 1 :] if begins else actions
    first = next((k for k, action in enumerate(since) if isinstance(action, Steps)), len(since))
    if not all(isinstance(action, MoveDemonstrator | ChangeSettings) for action in since[:first]):
        raise NotReadable  # it has looked or calibrated before its first step
    steps = [action.times for action in since[first:] if isinstance(action, Steps)]
    if len(steps) < len(since) - first:
        raise NotReadable  # something was done on the way
    start = session.history[0]
    settings = msgspec.structs.replace(
        session.settings, demonstrator_deg=to_degrees(start.theta_demo), start_deg=to_degrees(start.commanded)
    )
    if first and not _begins_alike(settings, start):
        raise NotReadable  # what was seen before its first step counts
    made, motion = sum(steps), session.snapshot.motion
    is_last = session.cursor == len(session.history) - 1
    # The last step that was made may have found the learner at rest, without a motion: it is repeated, too.
    return settings, min(made, motion + 1) if is_last else motion


def _begins_alike(settings: Settings, start: Snapshot) -> bool:
    """Return whether a new session with these settings begins with the same E. With camera images it is not tried."""
    if start.motion != 0 or settings.sensor == "rendered":
        return False
    return np.array_equal(Session(settings).snapshot.E, start.E, equal_nan=True)


def _differences(settings: Settings, base: Settings) -> Iterator[tuple[str, str]]:
    """Yield the fields of a link for settings that differ from a preset's."""
    for name in ("body_points", "workspace_deg"):
        if getattr(settings, name) != getattr(base, name):
            raise NotReadable  # too long for an address
    named = settings.scene in scene_names() and settings.robot in (None, *robot_names())
    if not named or OWN in (settings.transfer, settings.servo):
        raise NotReadable  # it is no shipped scene, robot or method
    for name, field in FIELDS.items():
        value = getattr(settings, field)
        if value == getattr(base, field):
            continue
        if value is None:
            raise NotReadable  # no text stands for it
        yield name, ",".join(map(_plain, value)) if isinstance(value, tuple) else _plain(value)


def _plain(value: Any) -> str:
    if isinstance(value, bool):
        return str(int(value))
    return repr(value).removesuffix(".0") if isinstance(value, float) else str(value)


def _nearest(settings: Settings) -> Preset:
    """Return the preset from which settings differ least."""

    def differing(preset: Preset) -> int:
        base = complete(preset.settings)
        return sum(getattr(settings, name) != getattr(base, name) for name in Settings.__struct_fields__)

    return min((preset for preset in PRESETS if preset.settings.sensor == settings.sensor), key=differing)


def _read(text: str, begun: Settings) -> SavedPage:
    """Read a readable link. Without a preset it differs from what the server was started with."""
    if len(text) > MAX_READABLE:
        refusal = "the link is too long: {n} characters of {most}"
        raise ValueError(refusal.format(n=len(text), most=MAX_READABLE))
    pairs = parse_qsl(text, keep_blank_values=True)
    fields = dict(pairs)
    allowed = ("preset", *FIELDS, "steps", "speed", "point", *SWITCHES)
    for name in fields:
        if name not in allowed:
            refusal = "the link has a field that is not known, {name!r}; there are {names}"
            raise ValueError(refusal.format(name=name[:40], names=", ".join(allowed)))
    if len(fields) < len(pairs):
        raise ValueError("the link has a field twice")
    key = fields.pop("preset", None)
    offered = {preset.key: preset for preset in PRESETS}
    if key is not None and key not in offered:
        refusal = "the link has a preset that is not here, {name!r}; there are {names}"
        raise ValueError(refusal.format(name=key[:40], names=", ".join(offered)))
    preset = next(iter(presets_from(begun).values())) if key is None else offered[key]
    settings = _settings(fields, complete(preset.settings), begun)
    steps = _number("steps", fields.get("steps", "0"), MAX_STEPS)
    speed = _speed(fields["speed"]) if "speed" in fields else preset.motions_per_second
    script = Script(settings, (Steps(steps),) if steps else ())
    return SavedPage(
        present=Branch(runs=(Run(script=script, cursor=steps),), preset=preset.name, speed=speed),
        settings=settings, chosen=_point(fields.get("point")), show=_switches(fields),
    )  # fmt: skip


def _speed(text: str) -> float:
    """Read steps a second; 0 is as fast as it computes."""
    offered = {f"{speed:g}": speed for speed in SPEEDS.values()}
    if text not in offered:
        refusal = "the link's speed must be one of {speeds}, got {value!r}"
        raise ValueError(refusal.format(speeds=", ".join(offered), value=text[:40]))
    return offered[text]


def _settings(fields: Mapping[str, str], base: Settings, begun: Settings) -> Settings:
    given = {FIELDS[name]: value for name, value in fields.items() if name in FIELDS}
    plain = {name: value.split(",") if name in LISTS else value for name, value in given.items()}
    try:
        found = msgspec.convert(plain, Settings, strict=False)
        settings = msgspec.structs.replace(base, **{name: getattr(found, name) for name in plain})
    except (msgspec.ValidationError, ValueError) as error:
        raise _impossible(error) from None
    require_allowed(SavedPage(present=Branch(), settings=settings), begun)  # before a file of this name is opened
    try:
        return complete(settings)
    except ValueError as error:
        raise _impossible(error) from None


def _impossible(error: Exception) -> ValueError:
    return ValueError("the link cannot be opened: {why}".format(why=" ".join(str(error).split())[:200]))


def _point(text: str | None) -> int | None:
    """Return the index of the point that is explained; -1 for the one with the largest residual."""
    return None if text == "none" else -1 if text is None else _number("point", text, 1_000)


def _switches(fields: Mapping[str, str]) -> dict[str, bool]:
    defaults = {name: getattr(View(), name) for name in SWITCHES}
    for name in SWITCHES:
        if name in fields and fields[name] not in FLAGS:
            refusal = "the link's {name} is neither 0 nor 1: {value!r}"
            raise ValueError(refusal.format(name=name, value=fields[name][:40]))
    return defaults | {name: FLAGS[fields[name]] for name in SWITCHES if name in fields}


def _number(name: str, text: str, most: int) -> int:
    if not (text.isascii() and text.isdecimal() and int(text) <= most):
        refusal = "the link's {name} must be a whole number up to {most}, got {value!r}"
        raise ValueError(refusal.format(name=name, most=most, value=text[:40]))
    return int(text)
