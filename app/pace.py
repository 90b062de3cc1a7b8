"""How fast the loop runs, and where the arm is seen between two postures."""

import time

from numpy.typing import NDArray

from viewimit.session import Session

MOTION_SHARE, LONGEST_MOTION = 0.85, 1.2  # of the period; s: how long the arm is seen to move
SINGLE_STEP = 0.45  # s a motion takes that was asked for singly
LATE = 0.05  # s that a tick may be late without the pace giving way
BUDGET = 0.02  # s a tick for stepping as fast as it computes


class Pace:
    """speed: motions a second, 0 as fast as it computes. While the servo rests nothing is stepped."""

    def __init__(self, session: Session):
        self._session = session
        self.speed = 2.0
        self.playing = False
        self._resting = False
        self._next = 0.0
        self._motion: tuple[NDArray, float, float] | None = None  # from where, when, for how long

    def toggle(self) -> None:
        self.playing, self._resting, self._next = not self.playing, False, 0.0

    def pause(self) -> None:
        self.playing = self._resting = False

    def wake(self) -> None:
        """Something has changed: a resting servo is asked again, and what moved is shown where it is."""
        self._resting = False

    def settle(self) -> None:
        """Show the present posture without a motion towards it."""
        self._motion, self._resting = None, False

    def advance(self, now: float) -> None:
        """Make the motions that are due."""
        if not self.playing or self._resting:
            return
        if self.speed == 0:
            until = time.monotonic() + BUDGET
            while not self._resting and time.monotonic() < until:
                self._rest_unless(self._session.step())
            self._motion = None
        elif now >= self._next:
            self._next = max(self._next, now - LATE) + 1 / self.speed
            self._move(now, min(MOTION_SHARE / self.speed, LONGEST_MOTION))

    def step(self, now: float) -> None:
        """One motion, as when playing slowly."""
        self._move(now, SINGLE_STEP)

    def undo(self, now: float) -> None:
        """One motion back, seen as one."""
        before = self._session.snapshot.theta
        if self._session.undo():
            self._motion = before, now, SINGLE_STEP

    def theta(self, now: float) -> tuple[NDArray, bool]:
        """Where the arm is seen, (m,) rad, and whether it is on its way."""
        theta = self._session.snapshot.theta
        if self._motion is None:
            return theta, False
        start, began, duration = self._motion
        share = (now - began) / duration
        if share >= 1 or start.shape != theta.shape:
            self._motion = None
            return theta, False
        return start + (theta - start) * share * share * (3 - 2 * share), True

    def _move(self, now: float, duration: float) -> None:
        before = self._session.snapshot.theta
        moved = self._session.step()
        if moved:
            self._motion = before, now, duration
        self._rest_unless(moved)

    def _rest_unless(self, moved: bool) -> None:
        """Too few points are looked for again; a servo that rests waits for a change."""
        self._resting = not moved and self._session.snapshot.transfer is not None
