"""The actions that lead a session to its present state: `Script`, and `Log`, which records them.

`Session.play` repeats a script and reaches the same posture, to the last bit. Links hold scripts, and `codegen` writes
them as Python or as a command.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any

import msgspec

from .settings import OWN, Settings

Times = Annotated[int, msgspec.Meta(ge=1)]
FIELDS: dict[str, Any] = {"frozen": True, "forbid_unknown_fields": True, "array_like": True}


class Steps(msgspec.Struct, tag="s", **FIELDS):
    """Call `Session.step()` a number of times. A servo at rest makes no motion."""

    times: Times


class MoveDemonstrator(msgspec.Struct, tag="p", **FIELDS):
    """Move the demonstrator to theta_demo, (m,) rad."""

    theta_demo: tuple[float, ...]


class ChangeSettings(msgspec.Struct, tag="c", **FIELDS):
    """Change fields of `Settings`."""

    fields: dict[str, Any]


class Calibrate(msgspec.Struct, tag="r", **FIELDS):
    """Visit postures, (K, m) rad, without a demonstrator, and record the own body."""

    postures: tuple[tuple[float, ...], ...]


class Begin(msgspec.Struct, tag="b", **FIELDS):
    """Restart with these settings. A calibration is kept."""

    settings: Settings


class ClearCalibration(msgspec.Struct, tag="f", **FIELDS):
    """Drop the calibration."""


class Looks(msgspec.Struct, tag="l", **FIELDS):
    """Call `Session.look()` a number of times."""

    times: Times


Action = Steps | MoveDemonstrator | ChangeSettings | Calibrate | Begin | ClearCalibration | Looks
MAX_ACTIONS = 10_000  # of a session that a log records


class Script(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The complete settings that a session begins with, and its actions in order."""

    settings: Settings
    actions: tuple[Action, ...] = msgspec.field(default=(), name="deeds")  # its name in links

    @property
    def steps(self) -> int:
        """Number of passes of the loop that it takes to play."""
        return sum(action.times for action in self.actions if isinstance(action, Steps | Looks))

    @property
    def needs_custom_method(self) -> bool:
        """Whether it needs a transfer or a servo that was given to the session itself."""
        named: list[object] = [self.settings.transfer, self.settings.servo]
        for action in self.actions:
            if isinstance(action, Begin):
                named += [action.settings.transfer, action.settings.servo]
            elif isinstance(action, ChangeSettings):
                named += [action.fields.get("transfer"), action.fields.get("servo")]
        return OWN in named

    def renamed(self, rename: Callable[[str], str]) -> Script:
        """A script with other names of scenes and robots, such as `file_name` gives them without their folders."""
        return Script(
            _settings_renamed(self.settings, rename), tuple(_action_renamed(action, rename) for action in self.actions)
        )


def _action_renamed(action: Action, rename: Callable[[str], str]) -> Action:
    if isinstance(action, Begin):
        return Begin(_settings_renamed(action.settings, rename))
    if isinstance(action, ChangeSettings):
        files = {
            name: rename(action.fields[name]) for name in ("scene", "robot") if action.fields.get(name) is not None
        }
        return ChangeSettings({**action.fields, **files})
    return action


def _settings_renamed(settings: Settings, rename: Callable[[str], str]) -> Settings:
    scene, robot = rename(settings.scene), None if settings.robot is None else rename(settings.robot)
    if (scene, robot) == (settings.scene, settings.robot):
        return settings  # new settings would be validated again
    return msgspec.structs.replace(settings, scene=scene, robot=robot)


class Log(msgspec.Struct, forbid_unknown_fields=True):
    """The actions that a session has taken, recorded as they are taken.

    before: the script that led to motion 0; actions: by the motion at which they were taken, except for the step from
    each motion to the next; unknown_from: the first motion of which not all is known, or None; looked_at: the motions
    whose last look is part of the step to the next.
    """

    before: Script
    actions: dict[int, list[Action]] = msgspec.field(default_factory=dict, name="deeds")  # its name in saved sessions
    unknown_from: int | None = msgspec.field(default=None, name="lost")
    looked_at: set[int] = msgspec.field(default_factory=set, name="glanced")

    @classmethod
    def unknown(cls) -> Log:
        """A log of a session whose past is unknown."""
        return cls(Script(Settings()), unknown_from=0)

    def note(self, motion: int, action: Action, merge_poses: bool = False) -> None:
        """Record an action at a motion. Later actions are dropped.

        merge_poses: a posture of the demonstrator replaces one recorded just before, as in a drag. A simulated session
        then plays to the same bits; an arm and eyes of the user's own would not see the postures in between.
        """
        self._drop_after(motion)
        here = self.actions.setdefault(motion, [])
        if here and isinstance(action, Steps | Looks) and type(here[-1]) is type(action):
            here[-1] = type(action)(here[-1].times + action.times)
        elif merge_poses and here and isinstance(action, MoveDemonstrator) and isinstance(here[-1], MoveDemonstrator):
            here[-1] = action
        elif len(self.before.actions) + sum(map(len, self.actions.values())) < MAX_ACTIONS:
            here.append(action)
        else:
            self.invalidate(motion)

    def note_on(self, motion: int, looked: bool) -> None:
        """Record the step from a motion to the next. looked: it began with another look."""
        if looked:
            self.note(motion, Looks(1))
            self.looked_at.add(motion)
        else:
            self._drop_after(motion)

    def invalidate(self, motion: int) -> None:
        """Record at a motion that something happened that no script can hold."""
        self._drop_after(motion)
        self.unknown_from = motion if self.unknown_from is None else self.unknown_from

    def script(self, motion: int) -> Script:
        """The script that leads to a motion. Raises ValueError where it is not known."""
        if self.unknown_from is not None and self.unknown_from <= motion:
            raise ValueError("it goes on from what cannot be said in a few words, as a rehearsal kept in a file")
        actions = list(self.before.actions)
        last = 0
        for at in sorted(at for at in self.actions if at <= motion):
            here = self.actions[at] if at == motion else self._left_for_next(at)
            if here:
                actions += [Steps(at - last)] * (at > last) + here
                last = at
        found = Script(self.before.settings, tuple(actions + [Steps(motion - last)] * (motion > last)))
        if found.needs_custom_method:
            raise ValueError("it runs a transfer or a servo of your own, which no script, link or file can hold")
        return found

    def begin(self, motion: int, settings: Settings) -> Log:
        """The log of a session that restarts after this one, of which it keeps a calibration."""
        try:
            script = self.script(motion)
        except ValueError:
            return Log.unknown()
        return Log(Script(script.settings, (*script.actions, Begin(settings))))

    def copy(self) -> Log:
        """A copy that does not follow this log."""
        return Log(
            self.before,
            {at: list(actions) for at, actions in self.actions.items()},
            self.unknown_from,
            set(self.looked_at),
        )

    def _left_for_next(self, motion: int) -> list[Action]:
        """The actions at a motion before the step to the next."""
        if motion not in self.looked_at:
            return self.actions[motion]
        *before, look = self.actions[motion]
        assert isinstance(look, Looks)
        return before + [Looks(look.times - 1)] * (look.times > 1)

    def _drop_after(self, motion: int) -> None:
        self.looked_at = {at for at in self.looked_at if at < motion}
        if self.unknown_from is not None and self.unknown_from > motion:
            self.unknown_from = None
        for later in [at for at in self.actions if at > motion]:
            del self.actions[later]
