"""One page: a model, its widgets and scene, and the loop that applies the visitor's commands."""

import threading
from contextlib import AbstractContextManager

import numpy as np
from viser import ClientHandle

from viewimit.loop.settings import Settings
from viewimit.simulation.world import World

from ..commands import COMMANDS
from ..model.choices import WINDOW, Message
from ..model.keeping import Keeper
from ..model.page_model import PageModel
from ..model.player import BUDGET
from ..model.queue import CommandQueue
from ..model.redraw import Redraw
from ..model.services import Services
from ..panels import PANELS
from ..panels.actions import Actions
from ..panels.panel import ClientInfo, Layout
from ..panels.status import STARTS_PICTURES, show_fault
from ..scene.scene3d import Scene3D, aspect_of, same_shape
from .loop import CommandLoop

PANELS_EVERY = 0.1  # s
LEAVES_WITHIN = 3.0  # s that a turn may take to its end when its page is gone
DOCKED_WITHIN = 3.0  # s
SEND_EVERY = 1.0  # s at least until a file is sent again: a second click does not send it twice


class Docking:
    """Panels come to stand beside a canvas that fills the window at first. A scene that is drawn before is drawn twice,
    and fitted to the wrong shape. waits: whether there are panels to wait for."""

    def __init__(self, client: ClientHandle, waits: bool):
        self._client, self._waits, self._until = client, waits, np.inf
        self._aspect = aspect_of(client)

    def over(self, now: float) -> bool:
        """Whether they do, or seem never to; s of any clock."""
        if self._waits:
            self._until = min(self._until, now + DOCKED_WITHIN)
            self._waits = now < self._until and same_shape(aspect_of(self._client), self._aspect)
        return not self._waits


class Page:
    """tick(now) takes what the visitor did, moves the loop on and poses the arms; draw() shows all else that changed.
    What changes is sent to the visitor's tab, which keeps it."""

    def __init__(
        self,
        client: ClientHandle,
        services: Services,
        settings: Settings,
        info: ClientInfo | None = None,
    ):
        self._client = client
        self._clock, self.queue, self._redraw = services.clock, CommandQueue(COMMANDS, services.clock), Redraw()
        self._now, self._is_new = -np.inf, True  # s, of the last tick; whether nothing of the world is drawn yet
        self._world: World | None = None  # that is drawn
        self._docked = False  # whether it is drawn at all
        self._posed: tuple[bytes, ...] | None = None  # the poses that are drawn
        self._sent_at: dict[str, float] = {}  # files by name
        self.model = PageModel(client.client_id, settings, services, self.queue, self._send)
        self._commands = CommandLoop(self.model, self.queue, self._announce_pictures, services.clock)
        try:
            self._build(services, info)
        except BaseException:
            self.close(0.0)  # what it has taken of the camera images
            raise
        self.model.eye = self._scene.eye
        self._docking = Docking(client, waits=self.layout.info.origin is not None)

    @property
    def busy(self) -> bool:
        """Whether a turn goes on beside the scheduler."""
        return self._commands.busy

    def held(self) -> AbstractContextManager:
        """Nothing of it is sent inside, but as a whole afterwards."""
        return self._client.atomic()

    def tick(self, now: float, budget: float = BUDGET) -> None:
        """Up to the poses, of which all else is drawn as they stand. budget: s for motions as fast as it computes."""
        self._now = now
        self._commands.tick(now, budget)
        if self._commands.drawable:
            self._pose()
        if not self._commands.busy:
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
        """Close the page. Return whether its last turn has ended within that time, s."""
        ended = self._commands.wait(within)
        if ended:
            self.model.close()
        else:
            threading.Thread(target=self._close_later, name="viewimit-leaving", daemon=True).start()
        return ended

    def _close_later(self) -> None:
        self._commands.wait()
        self.model.close()

    def _build(self, services: Services, info: ClientInfo | None) -> None:
        with self._client.atomic():
            self.layout = Layout(self._client, self.queue, info)
            self.model.refresh(0.0)
            self.layout.build(PANELS, self.model)
            self._actions: Actions = self.layout.named["actions"]
            self._keeper = Keeper(self.model, self._actions.keep)
            self._scene = Scene3D(self._client, self.queue, services.share)

    @property
    def _shown(self) -> bool:
        """Whether its window is seen at all."""
        return WINDOW not in self.model.view.unseen

    def _pose(self) -> None:
        if not self._shown:
            return
        world, docked = self.model.session.world, self._docking.over(self._now)
        if world is not self._world or docked != self._docked:
            self._world, self._docked, self._posed, self._is_new = world, docked, None, True
            if docked:  # widgets of the former world are removed at once: messages to them would be lost
                self._scene.build(world)
        if docked and self._scene.arms is not None:
            poses = self.model.poses(self._now)
            posed = tuple(pose.tobytes() for pose in poses)
            if posed != self._posed:
                self._posed = posed
                self._scene.arms.draw(*poses)

    def _draw_changed(self) -> None:
        model = self.model
        if self._scene.arms is not None and self._redraw.changed(Scene3D, self._scene.key(model)):
            self._scene.show(model)
        for drawing in self.layout.drawings:
            if not drawing.is_seen(model):
                continue
            period = drawing.period_of(model)
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
