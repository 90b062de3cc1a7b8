"""What a page has left behind: motions that others took the place of, and what was there before it began anew."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

from viewimit.loop.script import Log
from viewimit.loop.session import Session
from viewimit.loop.snapshot import Snapshot

from .player import Player
from .presets import Preset, Presets

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
        moments, cursor, _ = self.runs[0]
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
        branches = any(cursor < len(history) - 1 for history, cursor, _ in histories)
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
