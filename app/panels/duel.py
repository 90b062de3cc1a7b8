"""The tab Duel with what is behind it: the page passes wishes on to it and lets it draw."""

from contextlib import AbstractContextManager
from dataclasses import dataclass

from viser import ClientHandle

from viewimit.drawing import duel as drawing
from viewimit.servo import SERVOS
from viewimit.session import Session
from viewimit.simulation.world import World
from viewimit.snapshot import Snapshot
from viewimit.transfer import TRANSFERS

from ..control.duel import Duel
from ..control.inbox import Inbox, on_click, on_value, put, put_html, put_label
from ..control.player import Pace
from ..jobs.landscapes import LandscapeWorker, compute, landscape_key
from ..jobs.session_eyes import SessionEyes


@dataclass(frozen=True, eq=False)
class Ground:
    """What lies under the paths, drawn. html: of both learners' landscapes."""

    world: World
    html: str


class DuelTab:
    """wishes: what may be asked, by the names in the inbox; each may raise ValueError.

    tab: what is built in; worker: makes the landscapes beside the session; wide: with room for the errors beneath them;
    eyes: opens the opponent's.
    """

    def __init__(
        self,
        client: ClientHandle,
        tab: AbstractContextManager,
        inbox: Inbox,
        session: Session,
        pace: Pace,
        worker: LandscapeWorker,
        wide: bool,
        eyes: SessionEyes,
    ):
        self._page_id, self._inbox, self._session, self._worker = client.client_id, inbox, session, worker
        self._wide, self._asked = wide, None
        self.duel = Duel(session, pace, eyes)
        self.wishes = {**self.duel.wishes, "duel's landscapes": self._take}
        with tab:
            self._build(client.gui)

    @property
    def state(self) -> tuple:
        """What the tab shows: drawn again when this differs."""
        opponent = self.duel.opponent
        present = (self._session.snapshot, opponent.snapshot) if opponent else (None, None)
        return *present, self.duel.transfer, self.duel.servo

    def draw(self) -> None:
        duel, opponent = self.duel, self.duel.opponent
        put(self._transfer, TRANSFERS[duel.transfer].title)
        put(self._servo, SERVOS[duel.servo].title)
        put_label(self._switch, *(("End duel", "player-stop") if opponent else ("Begin duel", "swords")))
        errors = ""
        if opponent is None:
            self._asked = None
            put_html(self._ground, drawing.draw_empty())
            put_html(self._race, "")
        else:
            self._ask()
            standings = duel.standings
            scene = self._session.scene
            put_html(self._race, drawing.draw_race(scene, (self._session, opponent), standings))
            if self._wide and len(scene.moving_joints) == 2:
                errors = drawing.draw_errors_alone(standings)
        put_html(self._errors, errors)

    def _build(self, gui) -> None:
        duel, inbox = self.duel, self._inbox
        with gui.add_folder(None):
            gui.add_html('<span class="vi-row"></span>')
            names = [method.title for method in TRANSFERS.values()]
            self._transfer = gui.add_dropdown(
                "Opponent's transfer", names, initial_value=TRANSFERS[duel.transfer].title
            )
            names = [servo.title for servo in SERVOS.values()]
            self._servo = gui.add_dropdown("Opponent's servo", names, initial_value=SERVOS[duel.servo].title)
            self._switch = gui.add_button("Begin duel", icon="swords")
        self._ground, self._race = gui.add_html(drawing.draw_empty()), gui.add_html("")
        self._errors = gui.add_html("")
        on_value(self._transfer, inbox, "opponent's transfer")
        on_value(self._servo, inbox, "opponent's servo")
        on_click(self._switch, inbox, "duel")

    def _ask(self) -> None:
        """For landscapes of what both learners now see of the demonstrator."""
        present = self._session.snapshot, self.duel.opponent.snapshot
        asked = tuple(map(landscape_key, present))
        if asked != self._asked:
            new_scene = self._asked is None or self._asked[0][:4] != asked[0][:4]
            self._asked, world = asked, self._session.world
            if new_scene:
                self._take(Ground(world, drawing.draw_ground(world.scene, [], present[0].theta_demo)))
            done = lambda made: self._inbox.put("duel's landscapes", made)
            self._worker.ask(self._page_id, lambda: _ground(world, present), done, kind="duel")

    def _take(self, made: Ground | Exception) -> None:
        if isinstance(made, Exception):
            raise ValueError(f"no landscapes for the duel: {made}")
        if made.world is self._session.world and self.duel.opponent is not None:
            put_html(self._ground, made.html)


def _ground(world: World, present: tuple[Snapshot, Snapshot]) -> Ground:
    """Runs in the worker's thread."""
    found = [compute(world, snapshot) for snapshot in present]
    if None in found:
        return Ground(world, drawing.draw_empty_ground())
    return Ground(world, drawing.draw_ground(world.scene, found, present[0].theta_demo))
