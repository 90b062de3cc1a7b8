"""Commands and motions that are due, run turn by turn: at once, or in a thread beside the scheduler.

What looks with camera images takes long, and would hold up everybody's pages.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from ..jobs.camera_images import CameraLost, RemoteEyes
from ..model.page_model import PageModel
from ..model.queue import CommandQueue, JobResult, Queued

BESIDE = 0.2  # s a turn beside the scheduler for motions as fast as it computes
MESSAGE_STAYS = 6.0  # s
MOST_A_PASS = 0.01  # s of a tick of 50 ms in which one more command of a page begins: the other pages wait meanwhile


class CommandLoop:
    """tick(now, budget) ends a turn, begins the next, or does meanwhile what need not wait.

    announce_pictures(): the first camera images are about to be waited for; clock: s, by which commands are timed.
    """

    def __init__(
        self,
        model: PageModel,
        queue: CommandQueue,
        announce_pictures: Callable[[], None],
        clock: Callable[[], float] = time.monotonic,
    ):
        self._model, self._queue, self._clock = model, queue, clock
        self._announce_pictures, self._background = announce_pictures, Background()
        self._asked_at = 0.0

    @property
    def busy(self) -> bool:
        """Whether a turn goes on beside the scheduler."""
        return self._background.busy

    @property
    def drawable(self) -> bool:
        """Whether the session may be read: no turn changes it."""
        return not self._background.alone

    def wait(self, seconds: float | None = None) -> bool:
        """Whether no turn goes on any more, after that time at most."""
        return self._background.wait(seconds)

    def tick(self, now: float, budget: float) -> None:
        self._end_turn(now)
        if self._background.busy:
            self._apply_meanwhile(now)
        else:
            self._take_turn(now, budget)

    def _take_turn(self, now: float, budget: float) -> None:
        """Carry out what the visitor did and make the motions that are due: beside the scheduler if that takes camera
        images or long, at once if not."""
        model, restores = self._model, self._model.following.restores
        commands = self._queue.take_order_independent(cancelling=True) if restores else self._queue.take()
        opens = any(entry.needs_camera(model) for entry in commands)
        if not opens and model.session.settings.sensor == "projected":
            self._apply_in_time(commands, now)
            self._move_on(now, budget)
            return
        first = next((k for k, entry in enumerate(commands) if entry.moves), len(commands))
        if not self._apply_in_time(commands[:first], now, commands[first:]):
            return
        rest = commands[first:]  # in their order: what comes after a motion may depend on it
        if model.following.restores and not restores:  # which has just begun
            self._queue.put_back(rest)
            return
        self._asked_at = now
        if opens:
            self._announce_pictures()
        if rest or model.motions.replaying:
            self._background.begin(lambda: self._carry_out(rest, now), alone=True)
            return
        self._tick_motions()
        if model.player.due(now):
            self._background.begin(lambda: model.player.advance(now, BESIDE), alone=False)

    def _carry_out(self, commands: list[Queued], now: float) -> None:
        for entry in commands:
            self._apply(entry, now)
        self._move_on(now, 0.0)

    def _move_on(self, now: float, budget: float) -> None:
        self._tick_motions()
        self._model.player.advance(now, budget)
        session = self._model.session
        if isinstance(session.eyes, RemoteEyes):
            session.eyes.retake(session.snapshot)

    def _tick_motions(self) -> None:
        motions = self._model.motions
        if motions.recorder is not None or motions.shown is not None:
            motions.tick()

    def _apply_meanwhile(self, now: float) -> None:
        """What need not wait for the turn that goes on."""
        if not self._background.alone:
            self._apply_in_time(self._queue.take_order_independent(), now)

    def _apply_in_time(self, commands: list[Queued], now: float, rest: list[Queued] | None = None) -> bool:
        """Apply commands in their order. Return whether all were; else the others wait for the next tick."""
        until = self._clock() + MOST_A_PASS
        for k, entry in enumerate(commands):
            waits = self._model.following.restores and entry.moves and not (entry.order_independent or entry.cancels)
            if waits or (k and self._clock() > until):
                self._queue.put_back(commands[k:] + (rest or []))
                return False
            self._apply(entry, now)
        return True

    def _end_turn(self, now: float) -> None:
        try:
            if self._background.end():
                self._model.player.seen_from(now, self._asked_at)
        except CameraLost as lost:
            self._model.undoable.leave_pictures()
            self._model.refuse(f"{lost}: back to projected points.", now + MESSAGE_STAYS)

    def _apply(self, entry: Queued, now: float) -> None:
        """Carry out one command; one that cannot be is said, and the others go on."""
        try:
            entry.apply(self._model, now)
        except ValueError as refusal:
            self._model.refuse(str(refusal), now + MESSAGE_STAYS)
            return
        if not isinstance(entry, JobResult):
            self._model.inputs += 1
            if not entry.order_independent:
                self._model.accept()


# What takes long for one page goes on in a thread of its own while the page is ticked, one turn after the other.


class Background:
    """Runs one turn at a time in a thread.

    busy: a turn runs, or `end` has not reported its end; alone: the turn changes the session, so do not read it.
    """

    def __init__(self):
        self._thread: threading.Thread | None = None
        self._fault: BaseException | None = None
        self.alone = False

    @property
    def busy(self) -> bool:
        return self._thread is not None

    def begin(self, turn: Callable[[], None], alone: bool) -> None:
        self.alone = alone
        self._thread = threading.Thread(target=self._carry_out, args=(turn,), name="viewimit-turn", daemon=True)
        self._thread.start()

    def end(self) -> bool:
        """Whether a turn has ended since it was asked last. Raises what the turn raised."""
        if self._thread is None or self._thread.is_alive():
            return False
        self._thread, self.alone = None, False
        fault, self._fault = self._fault, None
        if fault is not None:
            raise fault
        return True

    def wait(self, seconds: float | None = None) -> bool:
        """Whether no turn goes on any more, after that time at most."""
        if self._thread is not None:
            self._thread.join(seconds)
        return self._thread is None or not self._thread.is_alive()

    def _carry_out(self, turn: Callable[[], None]) -> None:
        try:
            turn()
        except BaseException as fault:  # raised where the turn ends, in the thread that draws the page
            self._fault = fault
