"""Citations of pictures and replays: method, settings, seed, version, and the command that repeats them."""

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
SOFTWARE = f"viewimit {__version__}, after {PAPER}"


@dataclass(frozen=True)
class Citation:
    """What a reader needs to cite and repeat a result."""

    title: str  # of the method
    conditions: str  # settings with the seed, in one line
    software: str  # name, version and paper
    command: str | None  # repeats the result; None if no command can
    python: str | None  # repeats the result; None if it needs more than settings and actions


def cite(session: Session, motion: int | None = None) -> Citation:
    """Cite a session up to a motion; None for its last one in the history."""
    motion = session.history[-1].motion if motion is None else motion
    moment = session.history[motion]
    command = python = None
    try:
        script = session.log.script(motion).renamed(file_name)
        python = as_python(script)
        command = as_command(script)
    except ValueError:  # some action has no words
        pass
    title = f"{moment.method.title}, {moment.servo.title}"
    return Citation(title, _conditions(moment.settings), SOFTWARE, command, python)


def cite_both(one: Session, other: Session) -> Citation:
    """Cite two sessions side by side, each at its present motion, with the conditions of the first."""
    first, second = (cite(each, each.snapshot.motion) for each in (one, other))
    command = f"{first.command} ; {second.command}" if first.command and second.command else None
    python = f"{first.python}\n\n{second.python}" if first.python and second.python else None
    return Citation(f"{first.title} against {second.title}", first.conditions, SOFTWARE, command, python)


def cite_experiment(name: str, settings: Settings, motion: object = None) -> Citation:
    """Cite an experiment. motion: the demonstrator's, by its name; a recorded one has no command."""
    command = None
    if motion is None or isinstance(motion, str):
        try:
            command = as_reproduction(name, settings, motion)
        except ValueError:
            pass
    title = f"{TRANSFERS[settings.transfer].title}, {SERVOS[settings.servo].title}"
    return Citation(title, _conditions(settings), SOFTWARE, command, None)


def _conditions(settings: Settings) -> str:
    words = [describe_settings(settings)]
    if settings.frames > 1:
        words.append(f"{settings.frames} frames")
    return " · ".join([*words, f"seed {settings.seed}"])
