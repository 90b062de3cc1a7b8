"""A page's session with its player, duel and presets, and its changes, which Undo takes back."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import msgspec
from numpy.typing import NDArray

from viewimit.drawing.svg import count_motions
from viewimit.loop.script import Log
from viewimit.loop.self_calibration import DEFAULT_POSTURES, MIN_POSTURES
from viewimit.loop.session import Session
from viewimit.loop.settings import BodyPoint, Settings
from viewimit.loop.snapshot import Snapshot
from viewimit.servo import SERVOS
from viewimit.wording import either

from ..jobs.camera_images import CameraProcess, eyes_beside
from .choices import Preset, Presets
from .player import DENSE, Duel, Player

METHOD = {"transfer", "servo"}


class UndoableSession:
    """A session whose changes can be undone. in_new_world(): called after the world was replaced, or it restarted."""

    def __init__(self, settings: Settings, camera: CameraProcess, in_new_world: Callable[[], None]):
        self._in_new_world, opener = in_new_world, eyes_beside(camera)
        self.session = Session(settings, open_eyes=opener, dense=DENSE)
        self.player = Player(self.session)
        self.duel = Duel(self.session, self.player, opener)
        self.presets = Presets(settings)
        self.past = UndoStack(self.player, self.presets)

    def pose(self, theta: NDArray) -> None:
        """Move the demonstrator to theta, (m,) rad. Undo brings back the motions that this ends."""
        with self.past.recording_undo():
            self.session.pose(theta)
        self.duel.follow()
        self.player.wake()

    def change(self, **fields) -> None:
        """Change some of the settings."""
        world = self.session.world
        with self.past.recording_undo():
            self.session.change(**fields)
        self.player.wake()
        if self.session.world is not world:
            self.after_restart()
        elif self.duel.opponent is not None and not METHOD.isdisjoint(fields):
            self.duel.begin_again()
        else:
            self.duel.follow()

    def set_body_points(self, points: tuple[BodyPoint, ...]) -> None:
        """Restart with these body points on both arms. Raises ValueError, and changes nothing, for invalid points."""
        self._restart(lambda: self.session.change(body_points=points))

    def _restart(self, restart: Callable[[], None]) -> None:
        self.player.pause()
        with self.past.recording_undo(whole=True):
            restart()
        self.after_restart()

    def start_at(self, angles_deg: tuple[float, ...]) -> None:
        """Restart the learner at a posture, (m,) degrees."""
        self.player.pause()
        self.change(start_deg=angles_deg)
        self.player.settle()

    def rehearse(self) -> None:
        """Let the learner observe its own body for some motions, and then imitate. Raises ValueError, and changes
        nothing, if its servo does not use a rehearsal."""
        servo = SERVOS[self.session.settings.servo]
        if not servo.predicts:
            raise ValueError(f"{servo.title} makes no use of a rehearsal; choose {_able()}")
        with self.past.recording_undo():
            postures = self.session.calibration_postures(DEFAULT_POSTURES, self.session.settings.seed)
            self.session.begin_calibration(postures)
            self.duel.rehearse(DEFAULT_POSTURES)
        self.player.play()

    def forget_rehearsal(self) -> None:
        """Discard the self-observations, made or still to be made."""
        with self.past.recording_undo():
            self.session.use_calibration(None)
            self.duel.remember_alike()
        self.player.wake()

    def begin_preset(self, preset: Preset) -> None:
        """Begin with a preset, which is the chosen one even if the duel cannot be restarted."""

        def begin() -> None:
            self.session.begin(preset.settings)
            self.player.speed, self.presets.chosen = preset.motions_per_second, preset

        self._restart(begin)

    def begin_like(self, settings: Settings) -> None:
        """Begin with these settings and projected points; Undo does not bring back the former session."""
        self.session.begin(msgspec.structs.replace(settings, sensor="projected"))

    def leave_pictures(self) -> None:
        """Restart with projected points."""
        self.player.pause()
        self.begin_like(self.session.settings)
        self.after_restart()

    def reset(self) -> None:
        """Back to the start."""
        self.player.pause()
        with self.past.recording_undo():
            self.session.reset()
        self.duel.begin()

    def bring_back(self, entry: UndoEntry) -> None:
        """Restore the newest undo entry and remove it. Raises ValueError, and changes nothing, if that fails."""
        world = self.session.world
        for session, run in zip(self.player.sessions, entry.runs):
            session.resume(*run)
        self.presets.chosen, self.player.speed = entry.preset, entry.speed
        self.player.settle()
        self.past.pop()
        if self.session.world is not world:
            self._in_new_world()

    def after_restart(self) -> None:
        """Restart the duel and tell the page of the new world."""
        self.duel.begin()
        self._in_new_world()


MAX_ENTRIES = 12

Run = tuple[tuple[Snapshot, ...], int, Log]  # history, cursor, and how it came there


@dataclass(frozen=True, eq=False)
class UndoEntry:
    """A former state of a page's sessions."""

    runs: tuple[Run, ...]  # the learner's, and its opponent's in a duel
    at: int  # the motion at which another run began
    preset: Preset
    speed: float  # motions a second

    @property
    def motions(self) -> int:
        """How many motions the learner had made."""
        return self.runs[0][0][-1].motion

    @property
    def shown(self) -> Snapshot:
        """The learner's snapshot that was shown."""
        snapshots, cursor, _log = self.runs[0]
        return snapshots[cursor]


class UndoStack:
    """Former states of all sessions that a player steps, the newest last. Undo restores that at the motion where it
    ended, as it goes back one motion elsewhere."""

    def __init__(self, player: Player, presets: Presets) -> None:
        self._player, self._presets = player, presets
        self._entries: list[UndoEntry] = []

    @property
    def here(self) -> UndoEntry | None:
        """The newest entry, if it belongs to the present motion and has as many learners."""
        newest = self._entries[-1] if self._entries else None
        here = newest is not None and newest.at == self._player.cursor and len(newest.runs) == len(self._player.runners)
        return newest if here else None

    def pop(self) -> None:
        self._entries.pop()

    def clear(self) -> None:
        """Forget all former states."""
        self._entries = []

    def push_branch(self) -> None:
        """Push the present state if a next motion would replace later ones."""
        if any(session.cursor < len(session.history) - 1 for session in self._player.sessions):
            runs = tuple(map(_run, self._player.sessions))
            self._keep(UndoEntry(runs, self._player.cursor, self._presets.chosen, self._player.speed))

    @contextmanager
    def recording_undo(self, whole: bool = False) -> Iterator[None]:
        """Push an entry if the block discards snapshots. whole: even a single one. A block that raises pushes none."""
        sessions = self._player.sessions
        # a restart replaces these objects
        histories = [(session.history, session.cursor, session.log) for session in sessions]
        branches = any(cursor < len(history) - 1 for history, cursor, _log in histories)
        runs = tuple(map(_run, sessions)) if branches else None
        preset, speed = self._presets.chosen, self._player.speed
        yield
        if sessions[0].history is histories[0][0]:
            if runs is not None:
                self._keep(UndoEntry(runs, self._player.cursor, preset, speed))
        elif whole or len(histories[0][0]) > 1:
            runs = runs or tuple((tuple(history), cursor, log) for history, cursor, log in histories)
            self._keep(UndoEntry(runs, 0, preset, speed))

    def _keep(self, entry: UndoEntry) -> None:
        newest = self._entries[-1] if self._entries else None
        if newest is None or newest.at != entry.at or newest.runs[0][0] != entry.runs[0][0]:
            self._entries = [*self._entries[1 - MAX_ENTRIES :], entry]


def _run(session: Session) -> Run:
    return tuple(session.history), session.cursor, session.log.copy()


class Rehearsal:
    """The self-observations of a learner before it imitates, in words. seen: postures that it remembers; to_go: in
    which it is still to watch itself."""

    def __init__(self, session: Session):
        now = self._now = session.snapshot
        self.seen = 0 if now.calibration is None else len(now.calibration)
        self.to_go = 0 if now.pending_postures is None else len(now.pending_postures)
        self._motions, self._is_used = session.history.imitation_motions, SERVOS[now.settings.servo].predicts

    @property
    def held(self) -> bool:
        """Whether there is something to forget."""
        return self.to_go > 0 or self.seen >= MIN_POSTURES

    @property
    def offered(self) -> bool:
        """Whether a rehearsal can begin, or its observations can be discarded."""
        return self.held or self._is_used

    @property
    def words(self) -> str:
        """The remembered postures and whether they hold, or why no rehearsal is offered; "" for nothing to say."""
        if self.to_go:
            return f"Watches itself: {self.seen} of {self.seen + self.to_go} poses."
        remembers, holds = f"Remembers {self.seen} poses", self._now.calibration_holds
        if not self._is_used:
            return f"{remembers}; only for {_able()}." if self.held else f"Only for {_able()}."
        if not self.held:
            return ""
        if holds is False:
            return f"{remembers}, which do not hold here: it probes."
        if holds is None:
            return f"{remembers}; Play imitates with them."
        imitates = "Imitated in" if self._now.status.is_at_rest else "Imitates:"
        return f"{remembers}, which hold. {imitates} {count_motions(self._motions)}."


def _able() -> str:
    """The servos that make use of it, by their titles."""
    return either([servo.title for servo in SERVOS.values() if servo.predicts])
