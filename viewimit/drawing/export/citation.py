"""What makes a picture or a replay citable: what it shows, of which settings, seed and version, what repeats it."""

from dataclasses import dataclass

from ... import __version__
from ...estimation.transfers import TRANSFERS
from ...loop.codegen import as_command, as_python, as_reproduction
from ...loop.session import Session
from ...loop.settings import Settings
from ...sensing.files import file_name
from ...servo import SERVOS
from ..plots import describe_settings

PAPER = "“View-Based Imitation Learning by Conflict Resolution with Epipolar Geometry”, IROS 2001"


@dataclass(frozen=True)
class Citation:
    """title: of the method; conditions: a line of settings, with the seed; software: a sentence; command, python: that
    repeat it, each None where nothing of the kind can."""

    title: str
    conditions: str
    software: str
    command: str | None
    python: str | None

    @property
    def repeated_by(self) -> str:
        """In one line, for a caption; "" if nothing of one line does."""
        return self.command or ""


def cite(session: Session, motion: int | None = None) -> Citation:
    """A session up to a motion, None for its last that is kept."""
    motion = session.history[-1].motion if motion is None else motion
    moment = session.history[motion]
    command = python = None
    try:
        script = session.log.script(motion).renamed(file_name)
        python = as_python(script)
        command = as_command(script)
    except ValueError:  # some of it cannot be said in words
        pass
    title = f"{moment.method.title}, {moment.servo.title}"
    return Citation(title, conditions_of(moment.settings), software(), command, python)


def cite_both(one: Session, other: Session) -> Citation:
    """Of two sessions that go on side by side, each at its present: the conditions are the first one's."""
    first, second = (cite(each, each.snapshot.motion) for each in (one, other))
    command = python = None
    if first.command and second.command:
        command = f"{first.command} ; {second.command}"
    if first.python and second.python:
        python = f"{first.python}\n\n{second.python}"
    return Citation(f"{first.title} against {second.title}", first.conditions, software(), command, python)


def cite_experiment(name: str, settings: Settings, motion: object = None) -> Citation:
    """motion: the demonstrator's, by its name, or one that was recorded, which a command cannot say."""
    command = None
    if motion is None or isinstance(motion, str):
        try:
            command = as_reproduction(name, settings, motion)
        except ValueError:
            pass
    return Citation(title_of(settings), conditions_of(settings), software(), command, None)


def title_of(settings: Settings) -> str:
    return f"{TRANSFERS[settings.transfer].title}, {SERVOS[settings.servo].title}"


def conditions_of(settings: Settings) -> str:
    frames = f" · {settings.frames} frames" if settings.frames > 1 else ""
    return f"{describe_settings(settings)}{frames} · seed {settings.seed}"


def software() -> str:
    return f"viewimit {__version__}, after {PAPER}"
