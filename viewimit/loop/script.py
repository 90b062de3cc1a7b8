"""How a session came to where it is: the settings that it began with, and what was done to it since, motion by motion.

Played in a new session it leads to the same posture, to the last bit; so it is what a link holds, and what is said of
a run in lines of Python.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any

import msgspec

from ..sensing.renamed import current_settings
from .settings import OWN, Settings

Times = Annotated[int, msgspec.Meta(ge=1)]
FIELDS: dict[str, Any] = {"frozen": True, "forbid_unknown_fields": True, "array_like": True}


class Steps(msgspec.Struct, tag="s", **FIELDS):
    """`Session.step()` so many times: motions, or none where the servo rested."""

    times: Times


class MoveDemonstrator(msgspec.Struct, tag="p", **FIELDS):
    """The demonstrator was moved there, rad."""

    theta_demo: tuple[float, ...]


class ChangeSettings(msgspec.Struct, tag="c", **FIELDS):
    """Fields of `Settings`, and what they became."""

    fields: dict[str, Any]


class Calibrate(msgspec.Struct, tag="r", **FIELDS):
    """Postures, rad, that were to be gone through with nobody to imitate."""

    postures: tuple[tuple[float, ...], ...]


class Begin(msgspec.Struct, tag="b", **FIELDS):
    """Anew with these settings, with what was rehearsed before."""

    settings: Settings


class ClearCalibration(msgspec.Struct, tag="f", **FIELDS):
    """What was rehearsed."""


class Looks(msgspec.Struct, tag="l", **FIELDS):
    """`Session.look()` so many times."""

    times: Times


Action = Steps | MoveDemonstrator | ChangeSettings | Calibrate | Begin | ClearCalibration | Looks
MAX_ACTIONS = 4_000  # of a session that are remembered


class Script(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """settings: complete; actions: in their order."""

    settings: Settings
    actions: tuple[Action, ...] = msgspec.field(default=(), name="deeds")  # its name in links

    @property
    def steps(self) -> int:
        """How long it takes to play, in passes of the loop."""
        return sum(action.times for action in self.actions if isinstance(action, Steps | Looks))

    @property
    def runs_own(self) -> bool:
        """Whether it needs a transfer or a servo that a session was given itself."""
        named: list[object] = [self.settings.transfer, self.settings.servo]
        for action in self.actions:
            if isinstance(action, Begin):
                named += [action.settings.transfer, action.settings.servo]
            elif isinstance(action, ChangeSettings):
                named += [action.fields.get("transfer"), action.fields.get("servo")]
        return OWN in named

    def renamed(self, told: Callable[[str], str]) -> Script:
        """With scenes and robots called as told has them: `file_name` for others, to whom folders are nothing."""
        return Script(
            _settings_renamed(self.settings, told), tuple(_action_renamed(action, told) for action in self.actions)
        )


def _action_renamed(action: Action, told: Callable[[str], str]) -> Action:
    if isinstance(action, Begin):
        return Begin(_settings_renamed(action.settings, told))
    if isinstance(action, ChangeSettings):
        files = {name: told(action.fields[name]) for name in ("scene", "robot") if action.fields.get(name) is not None}
        return ChangeSettings({**action.fields, **files})
    return action


def _settings_renamed(settings: Settings, told: Callable[[str], str]) -> Settings:
    robot = None if settings.robot is None else told(settings.robot)
    return msgspec.structs.replace(settings, scene=told(settings.scene), robot=robot)


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
        """That knows of nothing."""
        return cls(Script(Settings()), unknown_from=0)

    def note(self, motion: int, action: Action) -> None:
        """At a motion, past which nothing is true any more."""
        self._drop_after(motion)
        here = self.actions.setdefault(motion, [])
        if here and isinstance(action, Steps | Looks) and type(here[-1]) is type(action):
            here[-1] = type(action)(here[-1].times + action.times)
        elif len(self.before.actions) + sum(map(len, self.actions.values())) < MAX_ACTIONS:
            here.append(action)
        else:
            self.invalidate(motion)

    def note_on(self, motion: int, looked: bool) -> None:
        """The step from a motion to the next, at the beginning of which was looked again, or not."""
        if looked:
            self.note(motion, Looks(1))
            self.looked_at.add(motion)
        else:
            self._drop_after(motion)

    def invalidate(self, motion: int) -> None:
        """Something was done that no script can say."""
        self._drop_after(motion)
        self.unknown_from = motion if self.unknown_from is None else self.unknown_from

    def script(self, motion: int) -> Script:
        """That leads to a motion. Raises ValueError where that is not known."""
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
        if found.runs_own:
            raise ValueError("it runs a transfer or a servo of your own, which no script, link or file can hold")
        return found

    def begin(self, motion: int, settings: Settings) -> Log:
        """The log of a session that starts anew after this one, of which it keeps a calibration."""
        try:
            script = self.script(motion)
        except ValueError:
            return Log.unknown()
        return Log(Script(script.settings, (*script.actions, Begin(settings))))

    def copy(self) -> Log:
        """That does not follow any more."""
        return Log(
            self.before,
            {at: list(actions) for at, actions in self.actions.items()},
            self.unknown_from,
            set(self.looked_at),
        )

    def _left_for_next(self, motion: int) -> list[Action]:
        """What was done at a motion before the step to the next."""
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


def current_script(script: dict[str, Any]) -> dict[str, Any]:
    """The fields of a `Script`, as a link has them, with settings by the names of today. Raises for another form."""
    actions = [
        [kind, current_settings(content[0])] if kind in ("b", "c") else [kind, *content]
        for kind, *content in script.get("deeds", ())
    ]
    return {**script, "settings": current_settings(script["settings"]), "deeds": actions}
