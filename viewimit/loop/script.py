"""How a session came to where it is: the settings that it began with, and what was done to it since, motion by motion.

Played in a new session it leads to the same posture, to the last bit; so it is what a link holds, and what is said of
a run in lines of Python.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any

import msgspec

from .settings import OWN, Settings

Times = Annotated[int, msgspec.Meta(ge=1)]
FIELDS: dict[str, Any] = {"frozen": True, "forbid_unknown_fields": True, "array_like": True}


class Stepped(msgspec.Struct, tag="s", **FIELDS):
    """`Session.step()` so many times: motions, or none where the servo rested."""

    times: Times


class Posed(msgspec.Struct, tag="p", **FIELDS):
    """The demonstrator was moved there, rad."""

    theta_demo: tuple[float, ...]


class Changed(msgspec.Struct, tag="c", **FIELDS):
    """Fields of `Settings`, and what they became."""

    fields: dict[str, Any]


class Rehearsed(msgspec.Struct, tag="r", **FIELDS):
    """Postures, rad, that were to be gone through with nobody to imitate."""

    postures: tuple[tuple[float, ...], ...]


class Began(msgspec.Struct, tag="b", **FIELDS):
    """Anew with these settings, with what was rehearsed before."""

    settings: Settings


class Forgot(msgspec.Struct, tag="f", **FIELDS):
    """What was rehearsed."""


class Looked(msgspec.Struct, tag="l", **FIELDS):
    """`Session.look()` so many times."""

    times: Times


Deed = Stepped | Posed | Changed | Rehearsed | Began | Forgot | Looked
MOST_DEEDS = 4_000  # of a session that are remembered


class Script(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """settings: complete; deeds: in their order."""

    settings: Settings
    deeds: tuple[Deed, ...] = ()

    @property
    def steps(self) -> int:
        """How long it takes to play, in passes of the loop."""
        return sum(deed.times for deed in self.deeds if isinstance(deed, Stepped | Looked))

    @property
    def runs_own(self) -> bool:
        """Whether it needs a transfer or a servo that a session was given itself."""
        named: list[object] = [self.settings.transfer, self.settings.servo]
        for deed in self.deeds:
            if isinstance(deed, Began):
                named += [deed.settings.transfer, deed.settings.servo]
            elif isinstance(deed, Changed):
                named += [deed.fields.get("transfer"), deed.fields.get("servo")]
        return OWN in named

    def renamed(self, told: Callable[[str], str]) -> Script:
        """With scenes and robots called as told has them: `file_name` for others, to whom folders are nothing."""
        return Script(_settings_renamed(self.settings, told), tuple(_deed_renamed(deed, told) for deed in self.deeds))


def _deed_renamed(deed: Deed, told: Callable[[str], str]) -> Deed:
    if isinstance(deed, Began):
        return Began(_settings_renamed(deed.settings, told))
    if isinstance(deed, Changed):
        files = {name: told(deed.fields[name]) for name in ("scene", "robot") if deed.fields.get(name) is not None}
        return Changed({**deed.fields, **files})
    return deed


def _settings_renamed(settings: Settings, told: Callable[[str], str]) -> Settings:
    robot = None if settings.robot is None else told(settings.robot)
    return msgspec.structs.replace(settings, scene=told(settings.scene), robot=robot)


class Log(msgspec.Struct, forbid_unknown_fields=True):
    """What is done to a session, as it is done. before: what led to motion 0; deeds: by the motion at which they were
    done, but for the step from each motion to the next; lost: the motion from which on it does not know all, or None;
    glanced: the motions whose last look is part of the step to the next.
    """

    before: Script
    deeds: dict[int, list[Deed]] = {}
    lost: int | None = None
    glanced: set[int] = set()

    @classmethod
    def unknown(cls) -> Log:
        """That knows of nothing."""
        return cls(Script(Settings()), lost=0)

    def note(self, motion: int, deed: Deed) -> None:
        """At a motion, past which nothing is true any more."""
        self._drop_after(motion)
        here = self.deeds.setdefault(motion, [])
        if here and isinstance(deed, Stepped | Looked) and type(here[-1]) is type(deed):
            here[-1] = type(deed)(here[-1].times + deed.times)
        elif len(self.before.deeds) + sum(map(len, self.deeds.values())) < MOST_DEEDS:
            here.append(deed)
        else:
            self.lose(motion)

    def note_on(self, motion: int, looked: bool) -> None:
        """The step from a motion to the next, at the beginning of which was looked again, or not."""
        if looked:
            self.note(motion, Looked(1))
            self.glanced.add(motion)
        else:
            self._drop_after(motion)

    def lose(self, motion: int) -> None:
        """Something was done that no script can say."""
        self._drop_after(motion)
        self.lost = motion if self.lost is None else self.lost

    def script(self, motion: int) -> Script:
        """That leads to a motion. Raises ValueError where that is not known."""
        if self.lost is not None and self.lost <= motion:
            raise ValueError("it goes on from what cannot be said in a few words, as a rehearsal kept in a file")
        deeds = list(self.before.deeds)
        last = 0
        for at in sorted(at for at in self.deeds if at <= motion):
            here = self.deeds[at] if at == motion else self._left_for_next(at)
            if here:
                deeds += [Stepped(at - last)] * (at > last) + here
                last = at
        found = Script(self.before.settings, tuple(deeds + [Stepped(motion - last)] * (motion > last)))
        if found.runs_own:
            raise ValueError("it runs a transfer or a servo of your own, which no script, link or file can hold")
        return found

    def copy(self) -> Log:
        """That does not follow any more."""
        return Log(self.before, {at: list(deeds) for at, deeds in self.deeds.items()}, self.lost, set(self.glanced))

    def _left_for_next(self, motion: int) -> list[Deed]:
        """What was done at a motion before the step to the next."""
        if motion not in self.glanced:
            return self.deeds[motion]
        *before, look = self.deeds[motion]
        assert isinstance(look, Looked)
        return before + [Looked(look.times - 1)] * (look.times > 1)

    def _drop_after(self, motion: int) -> None:
        self.glanced = {at for at in self.glanced if at < motion}
        if self.lost is not None and self.lost > motion:
            self.lost = None
        for later in [at for at in self.deeds if at > motion]:
            del self.deeds[later]
