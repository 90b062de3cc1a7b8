"""What a page has left behind: motions that others took the place of, and what was there before it began anew."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

from viewimit.script import Log
from viewimit.session import Session
from viewimit.snapshot import Snapshot

from ..presets import Preset

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
    def camera(self) -> str:
        moments, cursor, _ = self.runs[0]
        return moments[cursor].settings.camera


class Past:
    """The newest last. Undo takes one back from where it was left, as it takes a motion back from the next."""

    def __init__(self) -> None:
        self._left: list[Left] = []

    def at(self, motion: int, runs: int) -> Left | None:
        """What was left at this motion, if nothing has been left since, with as many learners as there are."""
        newest = self._left[-1] if self._left else None
        return newest if newest is not None and newest.at == motion and len(newest.runs) == runs else None

    def forget_newest(self) -> None:
        self._left.pop()

    @property
    def everything(self) -> tuple[Left, ...]:
        return tuple(self._left)

    def go_back_to(self, everything: tuple[Left, ...]) -> None:
        """What was left behind since is forgotten."""
        self._left = list(everything)

    def keep_branch(self, sessions: Sequence[Session], preset: Preset, speed: float) -> None:
        """Motions after the present one are about to be made anew."""
        if any(session.cursor < len(session.history) - 1 for session in sessions):
            self._keep(tuple(map(_run, sessions)), _cursor(sessions), preset, speed)

    @contextmanager
    def kept(self, sessions: Sequence[Session], preset: Preset, speed: float, whole: bool = False) -> Iterator[None]:
        """Inside, moments may be lost. whole: even if there is but the first. What raises has lost none."""
        # stay as they are for who begins anew
        histories = [(session.history, session.cursor, session.log) for session in sessions]
        branches = any(cursor < len(history) - 1 for history, cursor, _ in histories)
        runs = tuple(map(_run, sessions)) if branches else None
        yield
        if sessions[0].history is not histories[0][0]:
            if whole or len(histories[0][0]) > 1:
                self._keep(runs or tuple((tuple(one), cursor, log) for one, cursor, log in histories), 0, preset, speed)
        elif runs is not None:
            self._keep(runs, _cursor(sessions), preset, speed)

    def present(self, sessions: Sequence[Session], preset: Preset, speed: float) -> Left:
        """What is there now."""
        return Left(tuple(map(_run, sessions)), _cursor(sessions), preset, speed)

    def leave_here(self, left: Left, motion: int) -> None:
        """What was there before all that led to this motion."""
        self._left = [*self._left[1 - MOST :], replace(left, at=motion)]

    def _keep(self, runs: tuple[Run, ...], at: int, preset: Preset, speed: float) -> None:
        newest = self._left[-1] if self._left else None
        if newest is None or newest.at != at or newest.runs[0][0] != runs[0][0]:
            self._left = [*self._left[1 - MOST :], Left(runs, at, preset, speed)]


def _run(session: Session) -> Run:
    return tuple(session.history), session.cursor, session.log.copy()


def _cursor(sessions: Sequence[Session]) -> int:
    return max(session.cursor for session in sessions)
