"""A session in words that others can run: lines of Python, or a command. Both end at the same posture, bit for bit."""

import shlex
from collections.abc import Sequence

import msgspec

from ..sensing.files import is_text
from .script import Action, Begin, Calibrate, ChangeSettings, Looks, MoveDemonstrator, Script, Steps
from .settings import DISTURBANCES, SAFETY, USUAL_POINTS, Settings, option

MOST_LINES = 12
OF_BODY = ("scene", "robot", "joints", "points", "undistort", "sensor")  # which body is seen, and by what
NO_WORDS = {  # fields of settings without an option
    "delay": "pictures that come late have no option",
    "body_points": "its points were placed by hand; save the scene, and name its file",
}


def as_python(script: Script) -> str:
    """At most MOST_LINES lines, which print the learner's posture, rad. What takes more is told as data."""
    told = "\n".join(
        (
            "from viewimit import Session, Settings",
            "",
            f"session = Session({_settings(script.settings)})",
            *(line for action in script.actions for line in _lines(action)),
            "print(session.snapshot.theta)",
        )
    )
    return told if len(told.splitlines()) <= MOST_LINES and not _is_data(script) else _as_data(script)


def as_command(script: Script) -> str:
    """Of `viewimit imitate`. Raises ValueError, with what it is, for what a command cannot say."""
    settings = script.settings
    options = _options(settings, Settings())
    if is_text(settings.scene):
        raise ValueError("no command: its scene came without a file; save the scene, and name its file")
    if not all(isinstance(action, Steps) for action in script.actions):
        raise ValueError("no command: something was done by hand on the way; as Python it can be said")
    return shlex.join(["viewimit", "imitate", *options, f"--max-motions={script.steps}", "--json"])


def as_imitation(settings: Settings, calibration: str) -> str:
    """Of `viewimit imitate`, of the body that was rehearsed with these settings.

    calibration: the file that `viewimit rehearse` has written.
    """
    words = _words(settings, Settings(), (*OF_BODY, *SAFETY))
    return shlex.join(["viewimit", "imitate", "--calibration", calibration, *words])


def as_reproduction(figure: str, settings: Settings, motion: str | None = None) -> str:
    """Of `viewimit reproduce`. motion: the demonstrator's, where it has one. Raises ValueError as `as_command`."""
    if settings.undistort != Settings().undistort:
        raise ValueError("no command: viewimit reproduce rids no images of a distortion")
    if any(getattr(settings, name) != getattr(Settings(), name) for name in SAFETY):
        raise ValueError("no command: viewimit reproduce has no option that limits how far the arm goes")
    moves = [] if motion is None else [f"--motion={motion}"]
    return shlex.join(["viewimit", "reproduce", figure, *moves, *_options(settings, Settings.paper())])


def _options(settings: Settings, usual: Settings) -> list[str]:
    """usual: what a command begins with. Raises ValueError for what has no option."""
    for name, why in NO_WORDS.items():
        if getattr(settings, name) != getattr(Settings(), name):
            raise ValueError(f"no command: {why}")
    names = ("scene", "robot", "joints", "points", "transfer", "servo", "frames", *DISTURBANCES, "seed", "undistort",
             "rectify", "sensor", *SAFETY)  # fmt: skip
    postures = (f"{option(name)}={_value(getattr(settings, name))}" for name in ("demonstrator_deg", "start_deg"))
    return [*_words(settings, usual, names), *postures]


def _words(settings: Settings, usual: Settings, names: Sequence[str]) -> list[str]:
    """Options for those of the named fields that are not as usual."""
    words = []
    for name in names:
        value = getattr(settings, name)
        if value != (USUAL_POINTS if name == "points" else getattr(usual, name)):
            words.append(f"{option(name)}={_value(value)}")
    return words


def _value(value: object) -> str:
    if isinstance(value, tuple):
        ranges = value and isinstance(value[0], tuple)
        return ",".join(":".join(map(_value, one)) if ranges else _value(one) for one in value)
    return f"{value:g}" if isinstance(value, float) and float(f"{value:g}") == value else str(value)


def _settings(settings: Settings) -> str:
    """Those that are not as in the best method or, if that is fewer words, as in the paper's."""
    fields = {name: getattr(settings, name) for name in settings.__struct_fields__}
    ways = {
        called: {name: value for name, value in fields.items() if value != getattr(usual, name)}
        for called, usual in (("Settings", Settings()), ("Settings.paper", Settings.paper()))
    }
    called = min(ways, key=lambda way: len(ways[way]))
    return f"{called}({_fields(ways[called])})"


def _fields(fields: dict[str, object]) -> str:
    return ", ".join(f"{name}={value!r}" for name, value in fields.items())


def _lines(action: Action) -> list[str]:
    if isinstance(action, Steps | Looks):
        verb = "session.step()" if isinstance(action, Steps) else "session.look()"
        return [verb] if action.times == 1 else [f"for _ in range({action.times}):", f"    {verb}"]
    if isinstance(action, MoveDemonstrator):
        return [f"session.pose({action.theta_demo!r})  # rad"]
    if isinstance(action, ChangeSettings):
        return [f"session.change({_fields(action.fields)})"]
    if isinstance(action, Begin):
        return [f"session.begin({_settings(action.settings)})"]
    return ["session.use_calibration(None)"]


def _is_data(script: Script) -> bool:
    """Whether it holds what nobody wants to read."""
    return any(isinstance(action, Calibrate) for action in script.actions)


def _as_data(script: Script) -> str:
    written = msgspec.json.encode(script).decode()
    return "\n".join(
        (
            "import msgspec",
            "",
            "from viewimit import Session",
            "from viewimit.loop.script import Script",
            "",
            "session = Session()",
            f"session.play(msgspec.json.decode({written!r}, type=Script))",
            "print(session.snapshot.theta)",
        )
    )
