"""How fast the loop runs, and where an arm is seen between two postures."""

import time
from collections.abc import Callable

import msgspec
import numpy as np
from numpy.typing import NDArray

from viewimit.analysis.convergence import ErrorTrace
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.servo import SERVOS
from viewimit.simulation.eyes import open_eyes

from ..drawing.duel import ARRIVED_DEG, Standing

MOTION_SHARE, LONGEST_MOTION = 0.85, 1.2  # of the period; s: how long the arm is seen to move
SINGLE_STEP = 0.45  # s a motion takes that was asked for singly
EARLY, LATE = 0.02, 0.05  # s that a motion may begin before its time, as ticks jitter; and late without giving way
DENSE = 512  # motions of a page's session that are all kept; of older ones some are
BUDGET = 0.02  # s a tick for stepping as fast as it computes


class Runner:
    """One session as it is stepped and seen. resting: its servo waits for a change."""

    def __init__(self, session: Session):
        self.session = session
        self.resting = False
        self._motion: tuple[NDArray, float, float] | None = None  # from where, when, for how long

    def step(self) -> None:
        """One motion, not seen on its way. Too few points are looked for again; a servo that rests is not asked."""
        moved = self.session.step()
        self.resting = not moved and self.session.snapshot.transfer is not None
        self._motion = None

    def move(self, now: float, duration: float) -> None:
        """One motion, seen for so long, 0 for not on its way."""
        before, motion = self.session.snapshot.theta, self.session.snapshot.motion
        self.step()
        if duration and self.session.snapshot.motion > motion:
            self._motion = before, now, duration

    def seen_from(self, now: float, asked: float) -> None:
        """A motion that was asked for earlier, and took until now, is seen from now on."""
        if self._motion is not None and self._motion[1] == asked:
            self._motion = self._motion[0], now, self._motion[2]

    def scrub(self, motion: int, now: float | None = None) -> None:
        """To the moment after that many motions, or to its last one; seen as a motion that begins now, if at all."""
        before = self.session.snapshot.theta
        motion = min(motion, len(self.session.history) - 1)
        self._motion = None
        if motion != self.session.cursor and self.session.scrub(motion) and now is not None:
            self._motion = before, now, SINGLE_STEP

    def settle(self) -> None:
        """Show the present posture without a motion towards it."""
        self._motion, self.resting = None, False

    def theta(self, now: float, shortest: float = 0.0) -> tuple[NDArray, bool]:
        """Where the arm is seen, (m,) rad, and whether it is on its way. shortest: s; an arm that moves for less is
        seen where it arrives."""
        theta = self.session.snapshot.theta
        if self._motion is None or self._motion[2] < shortest:
            return theta, False
        start, began, duration = self._motion
        share = (now - began) / duration
        if share >= 1 or start.shape != theta.shape:
            self._motion = None
            return theta, False
        return start + (theta - start) * share * share * (3 - 2 * share), True


class Player:
    """Steps runners, the visitor's own first, motion for motion; one that rests waits for the others. speed: motions a
    second, 0 as fast as it computes; still: arms are not seen on their way."""

    def __init__(self, session: Session, clock: Callable[[], float] = time.monotonic):
        self.runners, self._clock = [Runner(session)], clock
        self.speed = 2.0
        self.playing = self.still = False
        self._next = 0.0

    @property
    def sessions(self) -> list[Session]:
        """The visitor's own first."""
        return [runner.session for runner in self.runners]

    @property
    def cursor(self) -> int:
        """Motions that are shown: of the runner that made most of them."""
        return max(runner.session.cursor for runner in self.runners)

    @property
    def last(self) -> int:
        """Motions that are kept."""
        return max(len(runner.session.history) for runner in self.runners) - 1

    def toggle(self) -> None:
        self.playing, self._next = not self.playing, 0.0
        self.wake()

    def play(self) -> None:
        """Play on; learners at rest are asked again."""
        if not self.playing:
            self.toggle()
        self.wake()

    def pause(self) -> None:
        self.playing = False
        self.wake()

    def wake(self) -> None:
        """Something has changed: resting servos are asked again, and what moved is shown where it is."""
        for runner in self.runners:
            runner.resting = False

    def settle(self) -> None:
        """Show the present postures without motions towards them."""
        for runner in self.runners:
            runner.settle()

    def seen_from(self, now: float, asked: float) -> None:
        """The motions that were asked for earlier, and took until now, are seen from now on."""
        for runner in self.runners:
            runner.seen_from(now, asked)

    def due(self, now: float) -> bool:
        """Whether motions are."""
        return self.playing and bool(self._awake) and (self.speed == 0 or now >= self._next - EARLY)

    def advance(self, now: float, budget: float = BUDGET) -> None:
        """Make the motions that are due. budget: s for those that run as fast as they compute."""
        if not self.due(now):
            return
        if self.speed == 0:
            until = self._clock() + budget
            while self.playing and self._awake and self._clock() < until:
                for runner in self._awake:
                    runner.step()
        else:
            self._next = max(self._next, now - LATE) + 1 / self.speed
            for runner in self._awake:
                runner.move(now, 0.0 if self.still else min(MOTION_SHARE / self.speed, LONGEST_MOTION))

    def step(self, now: float) -> None:
        """One motion, as when playing slowly."""
        for runner in self.runners:
            runner.move(now, 0.0 if self.still else SINGLE_STEP)

    def scrub(self, motion: int, now: float | None = None) -> None:
        """To the moment after that many motions, if there is one; a runner that made fewer stays at its last."""
        if 0 <= motion <= self.last:
            for runner in self.runners:
                runner.scrub(motion, None if self.still else now)

    @property
    def _awake(self) -> list[Runner]:
        return [runner for runner in self.runners if not runner.resting]


class Duel:
    """The visitor's learner against an opponent with its own transfer and servo, all other settings and the start being
    the same. opponent: None without a duel; transfer, servo: what it has or would have; opener: of its eyes."""

    def __init__(self, session: Session, player: Player, opener: Callable = open_eyes):
        self._session, self._player, self._opener = session, player, opener
        self.opponent: Session | None = None
        self.transfer, self.servo = "epipolar", "gradient"
        self._traces = ErrorTrace(), ErrorTrace()

    def toggle(self) -> None:
        """Begin at the start, playing; or end, which leaves the visitor's learner where it is."""
        if self.opponent is None:
            if self._settings == self._session.settings:  # a race against itself
                self.transfer, self.servo = Settings().transfer, Settings().servo
            self._add(self._settings)
            self.begin_again()
            self._player.playing = True
        else:
            self.opponent = None
            del self._player.runners[1:]

    def resume(self, other: Session) -> None:
        """Begin where another session is, which is the opponent's."""
        self.transfer, self.servo = other.settings.transfer, other.settings.servo
        self._add(other.settings).resume(tuple(other.history), other.cursor, other.log)

    def _add(self, settings: Settings) -> Session:
        self.opponent = Session(settings, open_eyes=self._opener, dense=DENSE)
        self._player.runners.append(Runner(self.opponent))
        return self.opponent

    def begin_again(self) -> None:
        """Both back to the start, with the settings as they are now."""
        self._session.reset()
        self.begin()

    def begin(self) -> None:
        """Restart the opponent, as the visitor's session was."""
        if self.opponent is not None:
            self.opponent.begin(self._settings)
            self.remember_alike()
        self._player.settle()

    def rehearse(self, count: int) -> None:
        """Let the opponent observe itself in as many postures as the visitor's learner, if its servo uses them."""
        if self.opponent is not None and SERVOS[self.servo].predicts:
            self.opponent.begin_calibration(self.opponent.calibration_postures(count, self._session.settings.seed))

    def remember_alike(self) -> None:
        """The opponent has the visitor's body, and knows of it what the visitor's learner does."""
        body = self._session.snapshot.calibration
        if self.opponent is not None and self.opponent.snapshot.calibration is not body:
            self.opponent.use_calibration(body)

    def follow(self) -> None:
        """What has changed for the visitor's learner, the demonstrator's posture above all, changes for both."""
        if self.opponent is not None and self.opponent.settings != self._settings:
            self.opponent.change(**msgspec.structs.asdict(self._settings))

    @property
    def standings(self) -> tuple[Standing, Standing]:
        """The visitor's and the opponent's. Raises ValueError without a duel."""
        if self.opponent is None:
            raise ValueError("there is no duel")
        own, other = self._traces
        return _standing(self._session, own), _standing(self.opponent, other)

    @property
    def _settings(self) -> Settings:
        return msgspec.structs.replace(self._session.settings, transfer=self.transfer, servo=self.servo)

    def choose(self, transfer: str | None = None, servo: str | None = None) -> None:
        """Another method for the opponent: a race that goes on begins again."""
        self.transfer, self.servo = transfer or self.transfer, servo or self.servo
        if self.opponent is not None:
            self.begin_again()


def _standing(session: Session, trace: ErrorTrace) -> Standing:
    count = session.cursor + 1
    errors = trace.of(session.history)[:count]
    since, here = count - 1, session.snapshot.theta_demo  # the first snapshot with the demonstrator where it is
    while since and ((before := session.history[since - 1].theta_demo) is here or np.array_equal(before, here)):
        since -= 1
    arrived = next((k for k in range(since, count) if errors[k] < ARRIVED_DEG), None)
    return Standing(session.snapshot, errors, arrived)
