"""A page's session and what goes with it, and all that changes it: what a change loses, Undo brings back."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

import msgspec
from numpy.typing import NDArray

from viewimit.language import _
from viewimit.loop.script import Log
from viewimit.loop.self_calibration import DEFAULT_POSTURES
from viewimit.loop.session import Session
from viewimit.loop.settings import BodyPoint, Settings
from viewimit.loop.snapshot import Snapshot

from ..jobs.camera_images import Cameras, SessionEyes
from .choices import CLIENT_REPORTED, Preset, Presets, View
from .displayed import require_use
from .player import DENSE, Duel, Player

METHOD = {"transfer", "servo"}


class UndoableSession:
    """settings: what it begins with; in_new_world(): the world has become another, or the session has begun anew."""

    def __init__(self, settings: Settings, camera: Cameras, in_new_world: Callable[[], None]):
        self._eyes, self._opponents_eyes = SessionEyes(camera), SessionEyes(camera)
        self._in_new_world = in_new_world
        self.session = Session(settings, open_eyes=self._eyes, dense=DENSE)
        self.player = Player(self.session)
        self.duel = Duel(self.session, self.player, self._opponents_eyes)
        self.presets = Presets(settings)
        self.past = Past(self.player, self.presets)

    def pose(self, theta: NDArray) -> None:
        """Move the demonstrator to theta, (m,) rad; what is lost by that, Undo brings back."""
        with self.past.kept():
            self.session.pose(theta)
        self.duel.follow()
        self.player.wake()

    def change(self, **fields) -> None:
        """Some of the settings."""
        world = self.session.world
        with self.past.kept():
            self.session.change(**fields)
        self.player.wake()
        if self.session.world is not world:
            self.begin_anew()
        elif self.duel.opponent is not None and not METHOD.isdisjoint(fields):
            self.duel.begin_again()
        else:
            self.duel.follow()

    def lay_points(self, points: tuple[BodyPoint, ...]) -> None:
        """Begin anew with these body points on both arms. Raises ValueError, with all as it is, if they cannot be."""
        self.player.pause()
        with self.past.kept(whole=True):
            self.session.change(body_points=points)
        self.begin_anew()

    def start_at(self, angles_deg: tuple[float, ...]) -> None:
        """The learner begins anew at a posture, (m,)."""
        self.player.pause()
        self.change(start_deg=angles_deg)
        self.player.settle()

    def rehearse(self) -> None:
        """The learner watches itself in its next motions, and then imitates. Raises ValueError, with all as it is,
        where its servo would make no use of that."""
        require_use(self.session.settings.servo)
        with self.past.kept():
            postures = self.session.calibration_postures(DEFAULT_POSTURES, self.session.settings.seed)
            self.session.begin_calibration(postures)
            self.duel.rehearse(DEFAULT_POSTURES)
        self.player.play()

    def forget_rehearsal(self) -> None:
        """What the learner has seen of itself, or what is left to be watched."""
        with self.past.kept():
            self.session.use_calibration(None)
            self.duel.remember_alike()
        self.player.wake()

    def begin_preset(self, preset: Preset) -> None:
        self.player.pause()
        with self.past.kept(whole=True):
            self.session.begin(preset.settings)
        self.player.speed = preset.motions_per_second
        self.presets.chosen = preset
        self.begin_anew()

    def begin_like(self, settings: Settings) -> None:
        """With projected points; nothing of what was here is kept."""
        self.session.begin(msgspec.structs.replace(settings, sensor="projected"))

    def leave_pictures(self) -> None:
        """Begin anew with projected points."""
        self.player.pause()
        self.begin_like(self.session.settings)
        self.begin_anew()

    def reset(self) -> None:
        """Back to the start."""
        self.player.pause()
        with self.past.kept():
            self.session.reset()
        self.duel.begin()

    def bring_back(self, left: Left) -> None:
        """As it was. Raises ValueError, with all as it is, if that cannot be any more."""
        self.go_on_with(left)
        self.past.forget_newest()

    def go_on_with(self, left: Left) -> None:
        """As `bring_back`, for what the past does not hold."""
        world = self.session.world
        for session, (moments, cursor, log) in zip(self.player.sessions, left.runs):
            session.resume(moments, cursor, log)
        self.presets.chosen, self.player.speed = left.preset, left.speed
        self.player.settle()
        if self.session.world is not world:
            self._in_new_world()

    def begin_anew(self) -> None:
        """The session has begun anew, in a world of its own."""
        self.duel.begin()
        self._in_new_world()

    def close(self) -> None:
        """Give the eyes back."""
        self._eyes.close()
        self._opponents_eyes.close()


# What a page has left behind: motions that others took the place of, and what was there before it began anew.

MOST = 12  # that are kept

Run = tuple[tuple[Snapshot, ...], int, Log]  # history, cursor, and how it came there


@dataclass(frozen=True, eq=False)
class Left:
    """runs: the learner's, and its opponent's in a duel; at: the motion at which something else has begun; preset,
    speed: of the page then."""

    runs: tuple[Run, ...]
    at: int
    preset: Preset
    speed: float

    @property
    def motions(self) -> int:
        """Of the learner."""
        return self.runs[0][0][-1].motion

    @property
    def sensor(self) -> str:
        moments, cursor, _log = self.runs[0]
        return moments[cursor].settings.sensor


class Past:
    """Of all that a player steps. The newest last: Undo takes one back from where it was left, as it takes a motion
    back from the next."""

    def __init__(self, player: Player, presets: Presets) -> None:
        self._player, self._presets = player, presets
        self._left: list[Left] = []

    @property
    def here(self) -> Left | None:
        """What was left at the motion that is shown, if nothing has been left since, with as many learners as there
        are."""
        newest = self._left[-1] if self._left else None
        here = newest is not None and newest.at == self._player.cursor and len(newest.runs) == len(self._player.runners)
        return newest if here else None

    def forget_newest(self) -> None:
        self._left.pop()

    @property
    def everything(self) -> tuple[Left, ...]:
        return tuple(self._left)

    def go_back_to(self, everything: tuple[Left, ...]) -> None:
        """What was left behind since is forgotten."""
        self._left = list(everything[-MOST:])

    @property
    def present(self) -> Left:
        """What is there now."""
        return self._leaving(tuple(map(_run, self._player.sessions)), self._player.cursor)

    def leave_here(self, left: Left) -> None:
        """What was there before all that led to the motion that is shown."""
        session = self._player.sessions[0]
        if left.runs[0][0] != tuple(session.history) or left.runs[0][1] != session.cursor:
            self._left = [*self._left[1 - MOST :], replace(left, at=self._player.cursor)]

    def keep_branch(self) -> None:
        """Motions after the present one are about to be made anew."""
        if any(session.cursor < len(session.history) - 1 for session in self._player.sessions):
            self._keep(self.present)

    @contextmanager
    def kept(self, whole: bool = False) -> Iterator[None]:
        """Inside, moments may be lost. whole: even if there is but the first. What raises has lost none."""
        sessions = self._player.sessions
        # stay as they are for who begins anew
        histories = [(session.history, session.cursor, session.log) for session in sessions]
        branches = any(cursor < len(history) - 1 for history, cursor, _log in histories)
        runs = tuple(map(_run, sessions)) if branches else None
        before = self._leaving((), 0)
        yield
        if sessions[0].history is not histories[0][0]:
            if whole or len(histories[0][0]) > 1:
                runs = runs or tuple((tuple(moments), cursor, log) for moments, cursor, log in histories)
                self._keep(replace(before, runs=runs))
        elif runs is not None:
            self._keep(replace(before, runs=runs, at=max(session.cursor for session in sessions)))

    def _leaving(self, runs: tuple[Run, ...], at: int) -> Left:
        return Left(runs, at, self._presets.chosen, self._player.speed)

    def _keep(self, left: Left) -> None:
        newest = self._left[-1] if self._left else None
        if newest is None or newest.at != left.at or newest.runs[0][0] != left.runs[0][0]:
            self._left = [*self._left[1 - MOST :], left]


def _run(session: Session) -> Run:
    return tuple(session.history), session.cursor, session.log.copy()


# What a page was before an entry of the glossary was shown: it is given back, whatever has been done since.


@dataclass(frozen=True, eq=False)
class BeforeWord:
    """key: of the entry that is shown, by a preset; left: what was there, and playing; past: what had been left behind
    before; view: as it was."""

    key: str
    preset: Preset
    left: Left
    past: tuple[Left, ...]
    view: View
    playing: bool


class ShownWord:
    """Of one page's session."""

    def __init__(self, undoable: UndoableSession):
        self._undoable = undoable
        self._before: BeforeWord | None = None

    @property
    def before(self) -> BeforeWord | None:
        """What was there before the entry that is shown; None if none is."""
        before = self._before
        return before if before is not None and self._undoable.presets.chosen is before.preset else None

    @property
    def key(self) -> str | None:
        """Of the entry that is shown."""
        return None if self.before is None else self.before.key

    def show(self, key: str, preset: Preset, view: View) -> None:
        """Begin with what shows an entry; what was there before the first of them, and its view, is kept."""
        past, playing = self._undoable.past, self._undoable.player.playing
        before = self.before or BeforeWord(key, preset, past.present, past.everything, view, playing)
        self._undoable.begin_preset(preset)
        self._before = replace(before, key=key, preset=preset)

    def give_back(self, view: View) -> View:
        """What was there before, in the window as it is now → as it is to be viewed. Raises ValueError, with all as it
        is, if there is nothing to be given back, or that cannot be any more."""
        before, player = self.before, self._undoable.player
        if before is None:
            raise ValueError(_("nothing is shown in place of what was here"))
        if len(before.left.runs) != len(player.runners):
            raise ValueError(_("a duel has begun or ended since: end or begin it again first"))
        player.pause()
        self._undoable.go_on_with(before.left)
        self._undoable.past.go_back_to(before.past)
        if before.playing:
            player.play()
        return replace(before.view, help=False, **{name: getattr(view, name) for name in CLIENT_REPORTED})
