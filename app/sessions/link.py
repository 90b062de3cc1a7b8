"""All that makes a page what it is, in as many characters as an address may have; and back, as hostile input."""

import base64
import math
from typing import Annotated

import msgspec
import zstandard

from viewimit.loop.history import MAX_HISTORY
from viewimit.loop.script import Action, Begin, Calibrate, ChangeSettings, MoveDemonstrator, Script, current_script
from viewimit.loop.settings import OWN, Settings
from viewimit.sensing.files import file_name, is_text
from viewimit.simulation.robot import robot_names
from viewimit.simulation.scene import load_scene, scene_names
from viewimit.simulation.scene_writing import scene_text

FORM = "1"  # the first character: which form the rest has
PACKING_ERRORS = zstandard.ZstdError, msgspec.MsgspecError
MOST_CHARS = 6_000
MOST_BYTES = 1 << 18  # unpacked
MOST_STEPS = 3_000  # passes of the loop that a server makes for a visitor
MOST_FRAMES = 100  # images averaged in each
MAX_ACTIONS = 500
MOST_POINTS = 64  # placed by hand, or of a layout
MOST_LAYOUTS = 16
MOST_TITLE = 200  # characters
MOST_SCENES = 16  # told in full
MOST_REHEARSED = 200

Index = Annotated[int, msgspec.Meta(ge=0, le=MAX_HISTORY)]
Speed = Annotated[float, msgspec.Meta(ge=0, le=1_000)]
Name = Annotated[str, msgspec.Meta(max_length=80)]


class Linked(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, omit_defaults=True):
    """script: what leads to the moment shown; chosen: a point; show: switches of the page that are on or off."""

    script: Script
    preset: Name = ""
    speed: Speed = 2.0
    chosen: Index | None = None
    show: dict[Name, bool] = {}


def written(linked: Linked) -> str:
    """Letters, digits, - and _. A scene of one's own is told in full, so that the link opens everywhere; one with a
    robot of one's own, or with more to say than an address holds, by its file's name alone. Raises ValueError for what
    is too long."""
    text = ""
    for named in (told, file_name):
        renamed = msgspec.structs.replace(linked, script=linked.script.renamed(named))
        text = _packed(renamed)
        if len(text) <= MOST_CHARS:
            _require(renamed, renamed.script.settings)
            return text
    raise ValueError(f"too much was done for a link: {len(text)} characters of {MOST_CHARS}")


def read(text: str, begun: Settings) -> Linked:
    """begun: what the server was started with, whose own scene a link may name. Raises ValueError that says in a line
    why it is none."""
    linked = _unpacked(text)
    own = {
        name(place): place for place in (begun.scene, begun.robot) if place is not None for name in (file_name, told)
    }
    linked = msgspec.structs.replace(linked, script=linked.script.renamed(lambda name: own.get(name, name)))
    _require(linked, begun)
    return linked


def files_named(text: str) -> list[str]:
    """By a link: of scenes and robots that a server has to be started with to open it."""
    named: dict[str, None] = {}  # in their order
    _unpacked(text).script.renamed(lambda name: named.setdefault(name) or name)
    return [name for name in named if name not in (*scene_names(), *robot_names()) and not is_text(name)]


def told(place: str) -> str:
    """A scene's file in full where that can be; by its name else, as all that is no file of a scene."""
    if not place.lower().endswith(".toml"):
        return file_name(place)
    try:
        text = scene_text(load_scene(place))
        _require_scene(text)
        return text
    except (OSError, ValueError):
        return file_name(place)


def _packed(linked: Linked) -> str:
    packed = zstandard.compress(msgspec.msgpack.encode(linked), 19)
    return FORM + base64.urlsafe_b64encode(packed).decode().rstrip("=")


def _unpacked(text: str) -> Linked:
    if len(text) > MOST_CHARS:
        raise ValueError(f"the link is too long: {len(text)} characters of {MOST_CHARS}")
    if not text.startswith(FORM):
        raise ValueError("the link is of another version, or damaged")
    try:
        packed = base64.b64decode(text[1:] + "=" * (-len(text[1:]) % 4), altchars="-_", validate=True)
        plain = zstandard.ZstdDecompressor().decompress(packed, max_output_size=MOST_BYTES)
        found = msgspec.msgpack.decode(plain)
        if isinstance(found.pop("lesson", None), list):
            raise ValueError("it opens a lesson, which are in the lab now, at /lab/tour")
        script = current_script(found.get("script"))
        return msgspec.convert({**found, "script": script}, Linked)
    except (ValueError, LookupError, TypeError, AttributeError, RecursionError, *PACKING_ERRORS) as error:
        raise ValueError(f"the link is damaged: {str(error)[:120]}") from None


def _require(linked: Linked, begun: Settings) -> None:
    """Raises ValueError for what a server does not do for whoever comes by."""
    script = linked.script
    if script.steps > MOST_STEPS:
        raise ValueError(f"the link asks for {script.steps} motions; {MOST_STEPS} are the most")
    if len(script.actions) > MAX_ACTIONS:
        raise ValueError(f"the link asks for {len(script.actions)} actions; {MAX_ACTIONS} are the most")
    all_settings = [
        script.settings,
        *(found for action in script.actions if (found := _settings_of(action)) is not None),
    ]
    for settings in all_settings:
        _require_names(settings, begun)
    texts = {settings.scene for settings in all_settings if is_text(settings.scene)}
    if len(texts) > MOST_SCENES:
        raise ValueError(f"the link tells {len(texts)} scenes; {MOST_SCENES} are the most")
    for text in texts:
        _require_scene(text)
    for action in script.actions:
        _require_finite(action)


def _settings_of(action: Action) -> Settings | None:
    """The settings that an action begins or goes on with, its other fields as usual."""
    if isinstance(action, Begin):
        return action.settings
    if not isinstance(action, ChangeSettings):
        return None
    try:
        return msgspec.convert(action.fields, Settings)
    except msgspec.ValidationError as error:
        raise ValueError(f"the link is damaged: {error}") from None


def _require_names(settings: Settings, begun: Settings) -> None:
    """No file of the server's is opened for a link, but those that it shows anyhow."""
    if OWN in (settings.transfer, settings.servo):
        raise ValueError("the link runs a transfer or a servo that only its author has")
    if not is_text(settings.scene) and settings.scene not in (*scene_names(), begun.scene):
        raise ValueError(f"the link shows a scene that is not here, {settings.scene[:80]!r}")
    if settings.robot is not None and settings.robot not in (*robot_names(), begun.robot):
        raise ValueError(f"the link shows a robot that is not here, {settings.robot[:80]!r}")
    if len(settings.body_points or ()) > MOST_POINTS:
        raise ValueError(f"the link places {len(settings.body_points or ())} points; {MOST_POINTS} are the most")
    if settings.frames > MOST_FRAMES:
        raise ValueError(f"the link averages {settings.frames} images; {MOST_FRAMES} are the most")


def _require_scene(text: str) -> None:
    """No more than a page is made to draw."""
    try:
        scene = load_scene(text)
    except ValueError as error:
        raise ValueError(f"the link's scene cannot be: {' '.join(str(error).split())[:150]}") from None
    for what, count, most in (
        ("points", max(map(len, scene.points.values()), default=0), MOST_POINTS),
        ("layouts", len(scene.points), MOST_LAYOUTS),
        ("letters of a title", len(scene.title), MOST_TITLE),
    ):
        if count > most:
            raise ValueError(f"the link's scene has {count} {what}; {most} are the most")
    if not scene.title.isprintable():
        raise ValueError("the link's scene has a title that cannot be printed")


def _require_finite(action: Action) -> None:
    postures = (
        (action.theta_demo,)
        if isinstance(action, MoveDemonstrator)
        else action.postures
        if isinstance(action, Calibrate)
        else ()
    )
    if len(postures) > MOST_REHEARSED:
        raise ValueError(f"the link rehearses {len(postures)} postures; {MOST_REHEARSED} are the most")
    if not all(math.isfinite(angle) for posture in postures for angle in posture):
        raise ValueError("the link is damaged: an angle is no number")
