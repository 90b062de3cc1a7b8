"""One page: a model, its widgets and scene, and the loop that applies the visitor's commands."""

import threading
from collections.abc import Callable
from concurrent.futures import Future, wait
from contextlib import AbstractContextManager

import numpy as np
from viser import ClientHandle

from viewimit.loop.settings import Settings
from viewimit.simulation.world import World

from ..commands import COMMANDS
from ..jobs.camera_images import CameraLost, RemoteEyes
from ..model.choices import MESSAGE_S, WINDOW, Message
from ..model.keeping import Keeper
from ..model.page_model import PageModel, Redraw
from ..model.player import BUDGET
from ..model.queue import CommandQueue, Entry
from ..model.services import Services
from ..panels import PANELS
from ..panels.actions import Actions
from ..panels.panel import ClientInfo, Layout
from ..panels.status import STARTS_PICTURES, show_fault
from ..scene.scene3d import Scene3D

PANELS_EVERY = 0.1  # s
LEAVES_WITHIN = 3.0  # s that a turn may take to its end when its page is gone
SEND_EVERY = 1.0  # s at least until a file is sent again: a second click does not send it twice
BESIDE = 0.2  # s a turn beside the scheduler for motions as fast as it computes
MOST_A_PASS = 0.01  # s of a tick of 50 ms in which one more command of a page begins: the other pages wait meanwhile


class Page:
    """tick(now) takes what the visitor did, moves the loop on and poses the arms; draw() shows all else that changed.
    What changes is sent to the visitor's tab, which keeps it."""

    def __init__(self, client: ClientHandle, services: Services, settings: Settings, info: ClientInfo | None = None):
        self._client = client
        self._clock, self.queue, self._redraw = services.clock, CommandQueue(COMMANDS), Redraw()
        self._now, self._is_new = -np.inf, True  # s, of the last tick; whether nothing of the world is drawn yet
        self._world: World | None = None  # that is drawn
        self._posed: tuple[bytes, ...] | None = None  # the poses that are drawn
        self._sent_at: dict[str, float] = {}  # files by name
        self.model = PageModel(settings, services, self.queue, self._send)
        self._commands = CommandLoop(self.model, self.queue, self._announce_pictures, services.clock)
        with client.atomic():
            self.layout = Layout(client, self.queue, info)
            self.model.refresh(0.0)
            self.layout.build(PANELS, self.model)
            self._actions: Actions = self.layout.named["actions"]
            self._keeper = Keeper(self.model, self._actions.keep)
            self._scene = Scene3D(client, self.queue, services.share)
        self.model.eye = self._scene.eye

    @property
    def busy(self) -> bool:
        """Whether a turn goes on beside the scheduler."""
        return self._commands.turns.busy

    def held(self) -> AbstractContextManager:
        """Nothing of it is sent inside, but as a whole afterwards."""
        return self._client.atomic()

    def tick(self, now: float, budget: float = BUDGET) -> None:
        """Up to the poses, of which all else is drawn as they stand. budget: s for motions as fast as it computes."""
        self._now = now
        self._commands.tick(now, budget)
        if self._commands.drawable:
            self._pose()
        if not self.busy:
            self._keeper.tick(now, self._actions.last)

    def draw(self) -> None:
        """Draw what has changed and is due, but the poses."""
        if not (self._commands.drawable and self._shown):
            return
        if not self._redraw.due("panels", self._now, PANELS_EVERY) and not self._is_new:
            return
        self._is_new = False
        self.model.ask_for_landscapes()
        self.model.refresh(self._now, shortest_motion=2 * PANELS_EVERY)
        self._draw_changed()

    def fail(self, error: Exception) -> None:
        """Show a fault of this session in its own page, and hold still."""
        self.model.player.pause()
        text = f"This session met an error, {error!r}. Reset starts again."
        self.model.say(text, np.inf)
        show_fault(self.layout, text)

    def close(self, within: float = LEAVES_WITHIN) -> bool:
        """Return whether its last turn has ended within that time, s."""
        return self._commands.turns.wait(within)

    @property
    def _shown(self) -> bool:
        """Whether its window is seen at all."""
        return WINDOW not in self.model.view.unseen

    def _pose(self) -> None:
        if not self._shown:
            return
        world = self.model.session.world
        if world is not self._world:
            self._world, self._posed, self._is_new = world, None, True
            self._scene.build(world)
        poses = self.model.display.poses(self._now)
        posed = tuple(pose.tobytes() for pose in poses)
        if posed != self._posed and self._scene.arms is not None:
            self._posed = posed
            self._scene.arms.draw(*poses)

    def _draw_changed(self) -> None:
        model = self.model
        if self._scene.arms is not None and self._redraw.changed(Scene3D, self._scene.key(model)):
            self._scene.show(model)
        for drawing in self.layout.drawings:
            if drawing.tab in model.view.unseen:
                continue
            period = drawing.period(model) if callable(drawing.period) else drawing.period
            if period and not self._redraw.due(drawing.kind, self._now, period):
                continue
            if self._redraw.changed(drawing.kind, drawing.key(model)):
                drawing.draw(model)

    def _announce_pictures(self) -> None:
        """At once: it takes seconds to begin with them, in which nothing is drawn."""
        self._pose()
        self.draw()
        before, self.model.message = self.model.message, Message(STARTS_PICTURES, np.inf)
        self.model.refresh(self._now)
        self._draw_changed()
        self.model.message = before

    def _send(self, name: str, data: bytes) -> None:
        now = self._clock()
        if now - self._sent_at.get(name, -SEND_EVERY) >= SEND_EVERY:
            self._sent_at[name] = now
            self._client.send_file_download(name, data, save_immediately=True)


class CommandLoop:
    """tick(now, budget) ends a turn, begins the next, or does meanwhile what need not wait. announce_pictures(): the
    first camera images are about to be waited for; clock: s, by which commands are timed."""

    def __init__(
        self, model: PageModel, queue: CommandQueue, announce_pictures: Callable[[], None], clock: Callable[[], float]
    ):
        self._model, self._queue, self._clock = model, queue, clock
        self._announce_pictures, self.turns = announce_pictures, Background()
        self._asked_at = 0.0

    @property
    def drawable(self) -> bool:
        """Whether the session may be read: no turn changes it."""
        return not self.turns.alone

    def tick(self, now: float, budget: float) -> None:
        self._end_turn(now)
        if self.turns.busy:
            if not self.turns.alone:  # what need not wait for the turn that goes on
                self._apply_in_time(self._queue.take_order_independent(), now)
        else:
            self._take_turn(now, budget)

    def _take_turn(self, now: float, budget: float) -> None:
        """Carry out what the visitor did and make the motions that are due: beside the scheduler if that takes camera
        images or long, at once if not."""
        model, restores = self._model, self._model.following.restores
        commands = self._queue.take_order_independent(cancelling=True) if restores else self._queue.take()
        opens = any(entry.camera(model) for entry in commands)
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
            self.turns.begin(lambda: self._carry_out(rest, now), alone=True)
            return
        self._tick_motions()
        if model.player.due(now):
            self.turns.begin(lambda: model.player.advance(now, BESIDE), alone=False)

    def _carry_out(self, commands: list[Entry], now: float) -> None:
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

    def _apply_in_time(self, commands: list[Entry], now: float, rest: list[Entry] | None = None) -> bool:
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
            if self.turns.end():
                self._model.player.seen_from(now, self._asked_at)
        except CameraLost as lost:
            self._model.undoable.leave_pictures()
            self._model.refuse(f"{lost}: back to projected points.", now + MESSAGE_S)

    def _apply(self, entry: Entry, now: float) -> None:
        """Carry out one command; one that cannot be is said, and the others go on."""
        try:
            entry.apply(self._model, now)
        except ValueError as refusal:
            self._model.refuse(str(refusal), now + MESSAGE_S)
            return
        if not entry.is_made:
            self._model.inputs += 1
            if not entry.order_independent:
                self._model.accept()


class Background:
    """Runs one turn at a time in a thread: what takes long for one page. busy: a turn runs, or `end` has not reported
    its end; alone: the turn changes the session, so do not read it."""

    def __init__(self):
        self._turn: Future | None = None
        self.alone = False

    @property
    def busy(self) -> bool:
        return self._turn is not None

    def begin(self, turn: Callable[[], None], alone: bool) -> None:
        ending, self.alone = Future[None](), alone
        self._turn = ending

        def carry_out() -> None:
            try:
                turn()
                ending.set_result(None)
            except BaseException as fault:  # raised where the turn ends, in the thread that draws the page
                ending.set_exception(fault)

        threading.Thread(target=carry_out, name="viewimit-turn", daemon=True).start()

    def end(self) -> bool:
        """Whether a turn has ended since it was asked last. Raises what the turn raised."""
        if self._turn is None or not self._turn.done():
            return False
        ended, self._turn, self.alone = self._turn, None, False
        ended.result()
        return True

    def wait(self, seconds: float) -> bool:
        """Whether no turn goes on any more, after that time at most."""
        return self._turn is None or not wait([self._turn], seconds).not_done
