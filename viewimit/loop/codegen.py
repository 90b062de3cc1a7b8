"""Write a script as Python code or as a command. Both reach the same posture, bit for bit."""

import shlex
from collections.abc import Sequence

import msgspec

from ..sensing.files import is_text
from .script import Action, Begin, Calibrate, ChangeSettings, Looks, MoveDemonstrator, Script, Steps
from .settings import DISTURBANCES, SAFETY, USUAL_POINTS, Settings, option

MAX_LINES = 12
BODY_FIELDS = ("scene", "robot", "joints", "points", "undistort", "sensor")  # which body is seen, and by what
NO_OPTION = {  # fields of Settings without an option, and why
    "delay": "pictures that come late have no option",
    "body_points": "its points were placed by hand; save the scene, and name its file",
}


def as_python(script: Script) -> str:
    """Python code of at most MAX_LINES lines that prints the learner's posture, rad. Longer scripts become data."""
    code = "\n".join(
        (
            "from viewimit import Session, Settings",
            "",
            f"session = Session({_settings(script.settings)})",
            *(line for action in script.actions for line in _lines(action)),
            "print(session.snapshot.theta)",
        )
    )
    holds_postures = any(isinstance(action, Calibrate) for action in script.actions)  # too many to read
    return _as_data(script) if holds_postures or len(code.splitlines()) > MAX_LINES else code


def as_command(script: Script) -> str:
    """The command `viewimit imitate …`. Raises ValueError, with the reason, for a script that no command can repeat."""
    settings = script.settings
    options = _options(settings, Settings())
    if is_text(settings.scene):
        raise ValueError("no command: its scene came without a file; save the scene, and name its file")
    if not all(isinstance(action, Steps) for action in script.actions):
        raise ValueError("no command: something was done by hand on the way; as Python it can be said")
    unmatched = [] if settings.matched else ["--unmatched"]
    return shlex.join(["viewimit", "imitate", *options, *unmatched, f"--max-motions={script.steps}", "--json"])


def as_imitation(settings: Settings, calibration: str) -> str:
    """The command `viewimit imitate …` that uses a calibration recorded with these settings.

    calibration: the file that `viewimit rehearse` has written.
    """
    words = _words(settings, Settings(), (*BODY_FIELDS, *SAFETY))
    return shlex.join(["viewimit", "imitate", "--calibration", calibration, *words])


def as_reproduction(figure: str, settings: Settings, motion: str | None = None) -> str:
    """The command `viewimit reproduce …`. motion: for Fig. 10. Raises ValueError as `as_command`."""
    if settings.undistort != Settings().undistort:
        raise ValueError("no command: viewimit reproduce does not undistort images")
    if not settings.matched:
        raise ValueError("no command: viewimit reproduce needs points with names")
    if any(getattr(settings, name) != getattr(Settings(), name) for name in SAFETY):
        raise ValueError("no command: viewimit reproduce has no option that limits how far the arm goes")
    moves = [] if motion is None else [f"--motion={motion}"]
    return shlex.join(["viewimit", "reproduce", figure, *moves, *_options(settings, Settings.paper())])


def _options(settings: Settings, defaults: Settings) -> list[str]:
    """The options that differ from a command's defaults. Raises ValueError for settings without an option."""
    for name, why in NO_OPTION.items():
        if getattr(settings, name) != getattr(Settings(), name):
            raise ValueError(f"no command: {why}")
    names = ("scene", "robot", "joints", "points", "transfer", "servo", "frames", *DISTURBANCES, "seed", "undistort",
             "rectify", "sensor", "dynamics", *SAFETY)  # fmt: skip
    postures = (f"{option(name)}={_value(getattr(settings, name))}" for name in ("demonstrator_deg", "start_deg"))
    return [*_words(settings, defaults, names), *postures]


def _words(settings: Settings, defaults: Settings, names: Sequence[str]) -> list[str]:
    """Options for those of the named fields that differ from the defaults."""
    words = []
    for name in names:
        value = getattr(settings, name)
        if value != (USUAL_POINTS if name == "points" else getattr(defaults, name)):
            words.append(f"{option(name)}={_value(value)}")
    return words


def _value(value: object) -> str:
    if isinstance(value, tuple):
        ranges = value and isinstance(value[0], tuple)
        return ",".join(":".join(map(_value, one)) if ranges else _value(one) for one in value)
    return f"{value:g}" if isinstance(value, float) and float(f"{value:g}") == value else str(value)


def _settings(settings: Settings) -> str:
    """A call that gives the fields that differ from the best method, or from the paper's if these are fewer."""
    fields = {name: getattr(settings, name) for name in settings.__struct_fields__}
    ways = {
        called: {name: value for name, value in fields.items() if value != getattr(defaults, name)}
        for called, defaults in (("Settings", Settings()), ("Settings.paper", Settings.paper()))
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
