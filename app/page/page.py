"""One page: a model, what is shown of it, and the loop that carries out what its visitor does."""

import threading
from contextlib import AbstractContextManager
from dataclasses import replace
from functools import partial

import numpy as np
from viser import ClientHandle

from viewimit.loop.settings import Settings

from ..model.page_model import PageModel
from ..model.queue import Command, CommandQueue
from ..model.services import Services, TimeBudget
from ..model.state import WINDOW, PageState
from ..panels import PANELS
from ..panels.actions import ActionsPanel
from ..panels.panel import NOWHERE, Layout, Reach
from ..panels.status import StatusPanel
from ..scene.scene3d import Scene3D
from ..scene.view import Docking
from .keeper import Keeper
from .loop import CommandLoop
from .redraw import Drawing, Redraw, draw_all

PANELS_EVERY = 0.1  # s
LEAVES_WITHIN = 3.0  # s that a turn may take to its end when its page is gone
SEND_EVERY = 1.0  # s at least until a file is sent again: a second click does not send it twice


class Page:
    """tick(now) takes what the visitor did, moves the loop on and poses the arms; drawings() tells how to show all else
    that changed. What changes is sent to the visitor's tab, which keeps it."""

    def __init__(
        self,
        client: ClientHandle,
        services: Services,
        settings: Settings,
        reach: Reach = NOWHERE,
    ):
        self._client, self._shedding = client, services.shedding
        self._clock, self.queue, self._redraw = services.clock, CommandQueue(services.clock), Redraw()
        self._now, self._anew = -np.inf, True  # s, of the last tick; a world of which nothing is drawn yet
        self._sent_at: dict[str, float] = {}  # files by name
        self.model = PageModel(client.client_id, settings, services, self.queue, self._send)
        budget = TimeBudget(services.clock)
        self._commands = CommandLoop(self.model, self.queue, services.shedding, self._announce_pictures, budget)
        try:
            self._build(services, reach)
        except BaseException:
            self.close(0.0)  # what it has taken of the camera images
            raise
        self.model.eye = self._scene.eye
        self._docking = Docking(client, waits=reach.origin is not None)

    def put(self, command: Command) -> None:
        """As if the visitor had done it; from any thread."""
        self.queue.put(command)

    def panel(self, kind: type):
        """The page's panel of this class."""
        return next(panel for panel in self._panels if isinstance(panel, kind))

    @property
    def busy(self) -> bool:
        """Whether a turn goes on beside the scheduler."""
        return self._commands.busy

    def held(self) -> AbstractContextManager:
        """Nothing of it is sent inside, but as a whole afterwards."""
        return self._client.atomic()

    def tick(self, now: float) -> None:
        """Up to the poses, of which all else is drawn as they stand."""
        self._now = now
        self._commands.tick(now)
        if self._commands.drawable:
            self._pose()
        if not self._commands.busy:
            self._keeper.tick(now, self._actions.last)

    def drawings(self) -> list[Drawing]:
        """Of what has changed and is due, but the poses."""
        if not (self._commands.drawable and self._shown):
            return []
        every = PANELS_EVERY * self._shedding.panels
        if not self._redraw.due("panels", self._now, every) and not self._anew:
            return []
        self._anew = False
        self.model.ask_for_landscapes()
        return self._drawings_of(self.model.state(self._now, shortest_motion=2 * every))

    def fail(self, error: Exception) -> None:
        """Show a fault of this session in its own page, and hold still."""
        self.model.player.pause()
        text = f"This session met an error, {error!r}. Reset begins anew."
        self.model.say(text, np.inf)
        self.panel(StatusPanel).show_message(text)

    def close(self, within: float = LEAVES_WITHIN) -> bool:
        """The page is gone. Whether its last turn has ended, within so many s."""
        ended = self._commands.wait(within)
        if ended:
            self.model.close()
        else:
            threading.Thread(target=self._close_later, name="viewimit-leaving", daemon=True).start()
        return ended

    def _close_later(self) -> None:
        self._commands.wait()
        self.model.close()

    def _build(self, services: Services, reach: Reach) -> None:
        with self._client.atomic():
            layout, state = Layout(self._client, self.queue, reach), self.model.state(0.0)
            self._panels = [panel() for panel in PANELS]
            for panel in self._panels:
                panel.build(layout, state)
            layout.dock()
            self._actions = self.panel(ActionsPanel)
            self._keeper = Keeper(self.model, self._actions.send_part)
            self._scene = Scene3D(self._client, self.queue, services.share)

    @property
    def _shown(self) -> bool:
        """Whether its window is seen at all."""
        return WINDOW not in self.model.view.unseen

    def _pose(self) -> None:
        if not self._shown:
            return
        world, docked = self.model.session.world, self._docking.over(self._now)
        if self._redraw.changed("world", world, docked):
            self._anew = True
            if docked:  # widgets of the world before are gone at once: what is sent to them would be lost
                self._scene.build(world)
        if docked:
            poses = self.model.poses(self._now)
            if self._redraw.changed("poses", world, *(pose.tobytes() for pose in poses)):
                self._scene.arms.draw(*poses)

    def _drawings_of(self, state: PageState) -> list[Drawing]:
        """Of what of a state has changed and is due."""
        drawings: list[Drawing] = []
        if self._scene.built and self._redraw.changed("scene", *self._scene.depends_on(state)):
            drawings.append((Scene3D, partial(self._scene.show, state)))
        for panel in self._panels:
            if not panel.seen(state):
                continue
            period = panel.period(state) * self._shedding.plots
            if period and not self._redraw.due(type(panel), self._now, period):
                continue
            if self._redraw.changed(type(panel), *panel.depends_on(state)):
                drawings.append((type(panel), partial(panel.show, state)))
        return drawings

    def _announce_pictures(self) -> None:
        """At once: it takes seconds to begin with them, in which nothing is drawn."""
        self._pose()
        draw_all(self.drawings())
        draw_all(self._drawings_of(replace(self.model.state(self._now), message="starting the camera images …")))

    def _send(self, name: str, data: bytes) -> None:
        now = self._clock()
        if now - self._sent_at.get(name, -SEND_EVERY) >= SEND_EVERY:
            self._sent_at[name] = now
            self._client.send_file_download(name, data, save_immediately=True)
