"""What a page is about, without its widgets: a session, how fast it runs, how it is shown, and what goes with it.
Commands change it; panels and the scene read it, and change nothing."""

from collections.abc import Callable, Hashable
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from viewimit.drawing.export.panels import landscape_key, largest_residual
from viewimit.drawing.export.perspective import Viewpoint
from viewimit.loop.settings import Settings
from viewimit.loop.snapshot import Snapshot

from .choices import Freedom, Message, Preset, View, usual
from .computed import Basins, Comparison, DuelLandscapes, Experiments, OwnLandscape
from .displayed import Display, Displayed
from .editing import UndoableSession
from .link import Following
from .motions import Motions
from .points import NOT_EDITED, PointEditing
from .queue import CommandQueue, Send
from .services import Services


class Saved(NamedTuple):
    """A file for the visitor."""

    name: str
    data: bytes


class PageModel:
    """generation: how often the world was replaced or the session restarted; inputs: how many of the visitor's commands
    were applied or rejected, after each of which widgets are written again; tour_offered: to a first visitor; eye():
    that looks at the 3-D scene; is_kept: the page's tab keeps what it is sent of it; unsaved: whether it cannot."""

    def __init__(self, settings: Settings, services: Services, queue: CommandQueue, send: Send):
        self.begun, self.send = settings, send
        self.undoable = UndoableSession(settings, services.camera, self._show_new_world)
        self.session, self.player, self.duel = self.undoable.session, self.undoable.player, self.undoable.duel
        self.presets, self.past = self.undoable.presets, self.undoable.past
        self.following = Following(services, queue)
        self.view, self.freedom = View(chosen=largest_residual(self.session.snapshot)), Freedom()
        self.display = Display(self.session, self.player)
        beside, self._files = partial(services.landscapes.ask, queue), partial(services.files.ask, queue)
        self.motions = Motions(self.session, self.undoable.pose, partial(beside, "motion", moves=True), send)
        self.points = PointEditing(self.session, self.undoable.set_body_points, partial(beside, "point"), send)
        self.experiments = Experiments(services.experiments, self.session, self.motions, queue, send)
        self.landscape, self.duel_landscapes = OwnLandscape(beside), DuelLandscapes(beside)
        self.comparison = Comparison(beside)
        self.basins = Basins(services.basins, queue)
        self._asked_for: tuple = ()  # what landscapes and basins depend on
        self.tour_offered = True
        self.eye: Callable[[], Viewpoint | None] = lambda: None
        self.generation, self.inputs = 0, 0
        self.message: Message | None = None
        self._refusal: Message | None = None
        self.unsaved = False
        self.is_kept = False
        self.displayed, self.edited = self.display.at(0.0, 0.0, self.view), NOT_EDITED

    @property
    def settings(self) -> Settings:
        return self.session.settings

    @property
    def snapshot(self) -> Snapshot:
        """Return the moment of the session that figures describe."""
        return self.displayed.present

    @property
    def preset(self) -> Preset:
        """With which the session has begun."""
        return self.presets.chosen

    @property
    def modified(self) -> bool:
        """Whether the settings are others than the preset's."""
        return self.session.settings != usual(self.presets.chosen)

    def show(self, **fields: Any) -> None:
        """Change fields of the view."""
        self.view = replace(self.view, **fields)

    def say(self, text: str, until: float) -> None:
        """Show the visitor a message, as long as now < until, s."""
        self.message = Message(text, until)

    def refuse(self, why: str, until: float) -> None:
        """Say why a command was rejected; the widgets show the model's values again."""
        self.say(why, until)
        self._refusal = self.message
        self.inputs += 1

    def accept(self) -> None:
        """Remove the message about a rejected command: a later one was applied."""
        if self.message is self._refusal:
            self.message = None

    def ask_for_landscapes(self) -> None:
        """Ask for the landscapes that have changed since they were asked for last."""
        world, present, opponent = self.session.world, self.session.snapshot, self.duel.opponent
        learners = [present] if opponent is None else [present, opponent.snapshot]
        key = world, self.comparison.toggles, [(one.settings, landscape_key(one)) for one in learners]
        if key != self._asked_for:
            self._asked_for = key
            self.landscape.ask(world, present)
            self.comparison.ask(world, present)
            self.basins.follow(self.session)
            self.duel_landscapes.ask(world, present, opponent)

    def refresh(self, now: float, shortest_motion: float = 0.0) -> Displayed:
        """Update the display. shortest_motion: s; an arm that moves for less is displayed where it arrives."""
        if self.message is not None and now > self.message.until:
            self.message = None
        self.displayed = self.display.at(now, shortest_motion, self.view)
        self.edited = self.points.shown if self.points.begun else NOT_EDITED
        return self.displayed

    def send_made(self, kind: str, make: Callable[[], Saved]) -> None:
        """Send the visitor a file that is made in the background; of each kind only the newest request."""
        self._files(f"saved {kind}", make, self._send_saved)

    def _send_saved(self, made: Saved | Exception) -> None:
        if isinstance(made, Exception):
            raise ValueError(f"it could not be saved: {made}")
        self.send(made.name, made.data)

    def _show_new_world(self) -> None:
        """The world is another."""
        if self.view.chosen is not None:
            self.view = replace(self.view, chosen=min(self.view.chosen, len(self.session.world.body) - 1))
        self.display.reset()
        self.generation += 1


EARLY = 0.9  # of a period: ticks jitter


class Redraw:
    """Remembers by kind of drawing, or by a name, its last values and when it was drawn: nothing is sent when nothing
    changes, nor more often than anybody sees."""

    def __init__(self):
        self._state: dict[Hashable, tuple] = {}
        self._at: dict[Hashable, float] = {}

    def due(self, what: Hashable, now: float, period: float) -> bool:
        """Return whether a period, s, has passed since this was last due. A call late by less than a period does not
        delay those after it."""
        at = self._at.get(what, -np.inf)
        if now - at < EARLY * period:
            return False
        self._at[what] = min(at + period, now) if now - at < 2 * period else now
        return True

    def changed(self, what: Hashable, state: tuple) -> bool:
        """Return whether the state differs from the last one. Of snapshots the identity counts."""
        before, self._state[what] = self._state.get(what), state
        if before is None or len(before) != len(state):
            return True
        return any(a is not b and (isinstance(a, Snapshot) or a != b) for a, b in zip(before, state))
