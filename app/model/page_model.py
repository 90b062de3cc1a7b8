"""What a page is about, without its widgets: a session, how fast it runs, how it is shown, and what goes with it.

Commands are carried out on it; `state` tells the panels what to show.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

from numpy.typing import NDArray

from viewimit.drawing.export.panels import largest_residual
from viewimit.drawing.export.perspective import Viewpoint
from viewimit.loop.settings import Settings

from ..sessions.link import Branch, Run, SavedPage
from .choices import Freedom
from .displayed import SeenMoments
from .editing import UndoableSession
from .experiments import Experiments
from .following import Following
from .landscapes import Basins, Comparison, DuelLandscapes, OwnLandscape
from .motions import Motions
from .points import PointEditing
from .presets import Preset
from .queue import Arrival, CommandQueue, MovingArrival
from .saving import Saving
from .services import Services
from .shown_word import ShownWord
from .state import SWITCHES, Message, PageState, View


class PageModel:
    """settings: what its session begins with; send(name, data): a file for the visitor.

    generation: how often the session has begun anew, in a world of its own; refusals: how many commands could not be;
    tour_offered: to somebody who has not been here before; eye(): that looks at the 3-D scene, as the page knows it;
    is_kept: the page's tab keeps what it is sent of it; resends_all: the tab has missed a part; unsaved: why the tab
    cannot keep it.
    """

    def __init__(
        self,
        page_id: int,
        settings: Settings,
        services: Services,
        queue: CommandQueue,
        send: Callable[[str, bytes], None],
    ):
        self.begun, self.send = settings, send
        self.undoable = UndoableSession(settings, services.camera, self._show_anew)
        self.session, self.player, self.duel = self.undoable.session, self.undoable.player, self.undoable.duel
        self.presets, self.past = self.undoable.presets, self.undoable.past
        self.word = ShownWord(self.undoable)
        self.following = Following(page_id, services, queue)
        self.view, self.freedom = View(chosen=largest_residual(self.session.snapshot)), Freedom()
        self.moments = SeenMoments(self.session, self.player)
        beside = services.landscapes
        aside = partial(_aside, partial(beside.ask, page_id), queue)
        self.motions = Motions(self.session, self.undoable.pose, partial(aside, "motion", MovingArrival), send)
        point_aside = partial(aside, "point", Arrival)
        self.points = PointEditing(self.session, self.undoable.lay_points, point_aside, send)
        self.experiments = Experiments(services.experiments, page_id, self.session, self.motions, queue, send)
        self.saving = Saving(page_id, services.files, queue, send)
        self.landscape = OwnLandscape(page_id, beside, queue)
        self.duel_landscapes = DuelLandscapes(page_id, beside, queue)
        self.comparison = Comparison(page_id, beside, queue)
        self.basins = Basins(page_id, services.basins, queue)
        self.tour_offered = True
        self.eye: Callable[[], Viewpoint | None] = lambda: None
        self.generation, self.refusals = 0, 0
        self.message: Message | None = None
        self._refusal: Message | None = None
        self.unsaved: str | None = None
        self.is_kept = self.resends_all = False

    @property
    def preset(self) -> Preset:
        """With which the session has begun."""
        return self.presets.chosen

    @property
    def modified(self) -> bool:
        """Whether the settings are others than the preset's."""
        return self.presets.differ(self.session.settings)

    def say(self, text: str, until: float) -> None:
        """A message for the visitor, as long as now < until, s."""
        self.message = Message(text, until)

    def refuse(self, why: str, until: float) -> None:
        """Say why something cannot be; the widgets show again what is."""
        self.say(why, until)
        self._refusal = self.message
        self.refusals += 1

    def accept(self) -> None:
        """What the visitor did can be: why something before it could not, is said no longer."""
        if self.message is self._refusal:
            self.message = None

    def ask_for_landscapes(self) -> None:
        """For what has changed since they were asked for last."""
        world, present = self.session.world, self.session.snapshot
        self.landscape.ask(world, present)
        self.comparison.ask(world, present)
        self.basins.follow(self.session)
        self.duel_landscapes.ask(world, present, self.duel.opponent)

    def poses(self, now: float) -> tuple[NDArray, ...]:
        """(m,) rad each: where the learner is seen, the demonstrator, and one more arm if there is one."""
        return self.moments.poses(now)

    def linked(self) -> SavedPage:
        """What a link to this page holds. Raises ValueError where that cannot be said."""
        view, snapshot = self.view, self.session.snapshot
        run = Run(script=self.session.script, cursor=snapshot.motion)
        return SavedPage(
            present=Branch(runs=(run,), preset=self.preset.name, speed=self.player.speed),
            settings=snapshot.settings,
            commanded=tuple(snapshot.commanded.tolist()),
            chosen=view.chosen,
            show={name: on for name in SWITCHES if isinstance(on := getattr(view, name), bool)},
        )

    def state(self, now: float, shortest_motion: float = 0.0) -> PageState:
        """What the page shows. shortest_motion: s; an arm on a shorter way is shown where it arrives."""
        session, player = self.session, self.player
        if self.message is not None and now > self.message.until:
            self.message = None
        seen = self.moments.at(now, shortest_motion, self.view.chosen)
        return PageState(
            looked=seen.looked,
            look_at=self.moments.look_at,
            pictures=seen.pictures,
            shown=seen.shown,
            on_its_way=seen.on_its_way,
            see_through=seen.see_through,
            imitated=seen.imitated,
            stage=seen.stage,
            generation=self.generation,
            refusals=self.refusals,
            session=session,
            settings=session.settings,
            present=session.snapshot,
            playing=player.playing,
            speed=player.speed,
            cursor=player.cursor,
            last=player.last,
            preset=self.preset,
            modified=self.modified,
            presets=self.presets.offered,
            view=self.view,
            landscape=self.landscape.made,
            transfers=self.comparison.html,
            basin=self.basins.run,
            duel=self.duel,
            ground=self.duel_landscapes.html,
            experiments=self.experiments,
            motions=self.motions,
            points=self.points.shown,
            linked=self.linked,
            message=None if self.message is None else self.message.text,
            unsaved=self.unsaved,
            tour_offered=self.tour_offered,
            follows_link=self.following.goes_on,
            restores=self.following.restores,
            word=self.word.key,
        )

    def save_picture(self, now: float) -> None:
        """Save the panel that is chosen. Raises ValueError where there is none."""
        self.saving.picture(self.view.picture, self.view.picture_as, self.state(now), self.eye())

    def close(self) -> None:
        """What it looks with is given back."""
        self.undoable.close()

    def _show_anew(self) -> None:
        """The world is another."""
        if self.view.chosen is not None:
            self.view = replace(self.view, chosen=min(self.view.chosen, len(self.session.world.body) - 1))
        self.moments.let_go()
        self.generation += 1


def _aside(
    ask: Callable[..., None],
    queue: CommandQueue,
    kind: str,
    arrival: type[Arrival],
    make: Callable[[], Any],
    take: Callable[[Any], None],
) -> None:
    """take(made) follows in the page's own time; of a kind the newest is enough. ask: a worker, for this page."""
    ask(make, queue.taker(kind, take, arrival), kind)
