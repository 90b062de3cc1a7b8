"""What a page is about, without its widgets: a session, how fast it runs, how it is shown, and what goes with it.

Commands are carried out on it; `state` tells the panels what to show.
"""

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from viewimit.analysis.motion import Motion
from viewimit.analysis.motion import encode as encode_motion
from viewimit.drawing.images.construction import last_stage
from viewimit.drawing.images.planes import Windows
from viewimit.embodiment.in_scene import complete
from viewimit.export.panels import farthest_off
from viewimit.export.perspective import Eye
from viewimit.rehearsal import POSTURES, begin_rehearsal
from viewimit.script import Changed, Deed, Posed, Stepped
from viewimit.script_player import converted, do, play
from viewimit.session import Session
from viewimit.settings import BodyPoint, Settings
from viewimit.simulation.appearance import Bodies
from viewimit.snapshot import Snapshot
from viewimit.transfer import TRANSFERS
from viewimit.viewer.appearance import Appearance

from ..jobs.experiments import Run
from ..jobs.session_eyes import RemoteEyes, SessionEyes
from ..lessons.course import Course
from ..sessions.autosave import SavedPage, SavedSession
from ..sessions.link import Linked
from .classroom.lecturer import Lecturer
from .classroom.student import Student
from .classroom.summaries import name_of
from .commands.command import Arrival, MovingArrival
from .comparison import Comparison
from .duel import Duel
from .experiments import Experiments
from .joints import Freedom
from .landscapes import Basins, DuelLandscapes, OwnLandscape
from .moments.building import BuildingUp
from .moments.guided import Guided
from .moments.imitated import Imitated
from .moments.past import Left, Past
from .moments.rehearsal import require_use
from .moments.see_through import SeeThrough
from .moments.shown_word import BeforeWord
from .motions import Motions
from .on_the_way import OnTheWay
from .player import DENSE, Player
from .points.editing import PointEditing
from .presets import AS_STARTED, Preset, presets_from
from .queue import CommandQueue
from .saving import Saving
from .services import Services
from .state import SWITCHES, Message, PageState, View

METHOD = {"transfer", "servo"}


class PageModel:
    """settings: what its session begins with; send(name, data): a file for the visitor.

    generation: how often the session has begun anew, in a world of its own; refusals: how many commands could not be.
    """

    def __init__(
        self,
        page_id: int,
        settings: Settings,
        services: Services,
        queue: CommandQueue,
        send: Callable[[str, bytes], None],
    ):
        self._page_id, self.begun, self._services, self._queue, self.send = page_id, settings, services, queue, send
        self._eyes, self._opponents_eyes = SessionEyes(services.camera), SessionEyes(services.camera)
        self.session = Session(settings, self._eyes, DENSE)
        self.player = Player(self.session)
        self.duel = Duel(self.session, self.player, self._opponents_eyes)
        self.view = View(chosen=farthest_off(self.session.snapshot))
        self.freedom, self.on_the_way = Freedom(), OnTheWay()
        self.see_through, self.imitated = SeeThrough(self.session), Imitated(self.session)
        self.building = BuildingUp()
        self.presets = presets_from(settings)
        self.preset = next(iter(self.presets.values()))
        self._of_preset: tuple[Preset, Settings] | None = None  # as a session has them
        self.past = Past()
        self._before_word: BeforeWord | None = None
        self.motions = Motions(self.session, self.pose, self._make_motion, send)
        self.experiments = Experiments(
            services.experiments, page_id, self.session, self.motions, self._take_run_later, send
        )
        self.points = PointEditing(self.session, self.lay_points, self._propose_point, send)
        self.landscape = OwnLandscape(page_id, services.landscapes, queue)
        self.duel_landscapes = DuelLandscapes(page_id, services.landscapes, queue)
        self.comparison = Comparison(page_id, services.landscapes, queue)
        self.basins = Basins(page_id, services.basins, queue)
        self.guided = Guided(page_id, services.lessons, services.landscapes, queue)
        self.eye: Callable[[], Eye | None] = lambda: None  # that looks at the 3-D scene, as the page knows it
        self.saving = Saving(page_id, services.files, send, self._take_saved_later)
        self.student: Student | None = None  # in a class
        self.lecturer: Lecturer | None = None
        self._appearance: Appearance | None = None  # made when it is first shown
        self.generation, self.refusals = 0, 0
        self.message: Message | None = None
        self.unsaved: str | None = None  # why the session is not kept, as far as is known
        self._encoded: tuple[Motion, bytes] | None = None

    def pose(self, theta: NDArray, keep: bool = True) -> None:
        """Move the demonstrator to theta, (m,) rad. keep: what is lost by that, Undo brings back."""
        with self._kept() if keep else nullcontext():
            self.session.pose(theta)
        self.duel.follow()
        self.player.wake()

    def change(self, **fields) -> None:
        """Some of the settings."""
        self._change(fields)

    def _change(self, fields: Mapping[str, Any], keep: bool = True) -> None:
        world = self.session.world
        with self._kept() if keep else nullcontext():
            self.session.change(**fields)
        self.player.wake()
        if self.session.world is not world:
            self.begin_anew()
        elif self.duel.opponent is not None and not METHOD.isdisjoint(fields):
            self.duel.begin_again()
        else:
            self.duel.follow()

    def lay_points(self, points: tuple[BodyPoint, ...]) -> None:
        """Begin anew with these body points on both arms. Raises ValueError, with all as it is, if they cannot be."""
        self.player.pause()
        with self._kept(whole=True):
            self.session.change(body_points=points)
        self.begin_anew()

    def start_at(self, angles_deg: tuple[float, ...]) -> None:
        """The learner begins anew at a posture, (m,)."""
        self.player.pause()
        self.change(start_deg=angles_deg)
        self.player.settle()

    def rehearse(self) -> None:
        """The learner watches itself in its next motions, and then imitates. Raises ValueError, with all as it is,
        where its servo would make no use of that."""
        require_use(self.session.settings.servo)
        with self._kept():
            begin_rehearsal(self.session, POSTURES, self.session.settings.seed)
            self.duel.rehearse(POSTURES)
        self.player.play()

    def forget(self) -> None:
        """What the learner has seen of itself, or what is left to be watched."""
        with self._kept():
            self.session.remember(None)
            self.duel.remember_alike()
        self.player.wake()

    def begin_preset(self, preset: Preset) -> None:
        self.player.pause()
        with self._kept(whole=True):
            self.session.begin(preset.settings)
        self.player.speed = preset.motions_per_second
        self.preset = preset
        self.begin_anew()

    def reset(self) -> None:
        """Back to the start."""
        self.player.pause()
        with self._kept():
            self.session.reset()
        self.duel.begin()

    def keep_branch(self) -> None:
        """Motions after the one that is shown are about to be made anew."""
        self.past.keep_branch(self._sessions, self.preset, self.player.speed)

    @property
    def present(self) -> Left:
        """What is here now."""
        return self.past.present(self._sessions, self.preset, self.player.speed)

    def leave_here(self, left: Left) -> None:
        """What Undo brings back from here."""
        if left.runs[0][0] != tuple(self.session.history) or left.runs[0][1] != self.session.cursor:
            self.past.leave_here(left, self.player.cursor)

    @property
    def left_here(self) -> Left | None:
        """What was left behind at the moment that is shown, and can be brought back."""
        return self.past.at(self.player.cursor, len(self._sessions))

    def bring_back(self, left: Left) -> None:
        """As it was. Raises ValueError, with all as it is, if that cannot be any more."""
        self._go_on_with(left)
        self.past.forget_newest()

    def show_word(self, key: str, preset: Preset) -> None:
        """Begin with what shows an entry of the glossary; what was there before the first of them is kept."""
        first, playing = self.shown_word, self.player.playing
        left = self.present
        before = first or BeforeWord(key, preset, left, self.past.everything, self.view, playing)
        self.begin_preset(preset)
        self._before_word = replace(before, key=key, preset=preset)

    @property
    def shown_word(self) -> BeforeWord | None:
        """What was there before the entry that is shown; None if none is."""
        before = self._before_word
        return before if before is not None and self.preset is before.preset else None

    def give_back(self) -> None:
        """What was there before an entry of the glossary was shown. Raises ValueError, with all as it is, if there is
        nothing to be given back, or that cannot be any more."""
        before = self.shown_word
        if before is None:
            raise ValueError("nothing is shown in place of what was here")
        if len(before.left.runs) != len(self._sessions):
            raise ValueError("a duel has begun or ended since: end or begin it again first")
        self.player.pause()
        self._go_on_with(before.left)
        self.past.go_back_to(before.past)
        self.view = replace(
            before.view, help=False, wide=self.view.wide, narrow=self.view.narrow, prefers_dark=self.view.prefers_dark
        )
        if before.playing:
            self.player.play()

    def _go_on_with(self, left: Left) -> None:
        world = self.session.world
        for session, (moments, cursor, log) in zip(self._sessions, left.runs):
            session.resume(moments, cursor, log)
        self.preset, self.player.speed = left.preset, left.speed
        self.player.settle()
        if self.session.world is not world:
            self._show_anew()

    @property
    def modified(self) -> bool:
        """Whether the settings are others than the preset's."""
        if self._of_preset is None or self._of_preset[0] is not self.preset:
            self._of_preset = self.preset, complete(self.preset.settings)
        return self.session.settings != self._of_preset[1]

    @property
    def _sessions(self) -> list[Session]:
        """The learner's, and its opponent's in a duel."""
        return [runner.session for runner in self.player.runners]

    def _kept(self, whole: bool = False) -> AbstractContextManager[None]:
        return self.past.kept(self._sessions, self.preset, self.player.speed, whole)

    def leave_pictures(self) -> None:
        """Begin anew with projected points."""
        self.player.pause()
        self.session.begin(on_points(self.session.settings))
        self.begin_anew()

    @property
    def shown_session(self) -> Session:
        """The page's own, or a lesson's."""
        course = self.guided.course
        return self.session if course is None else course.session

    def follow_lesson(self, now: float) -> None:
        """Move on what moves by itself in it."""
        if self.guided.course is not None:
            self.guided.course.fit(self.view.narrow)
            self.guided.course.tick(now, self.player.still)

    def begin_anew(self) -> None:
        """The session has begun anew, in a world of its own."""
        self.duel.begin()
        self._show_anew()

    def _show_anew(self) -> None:
        """The world is another."""
        if self.view.chosen is not None:
            self.view = replace(self.view, chosen=min(self.view.chosen, len(self.session.world.body) - 1))
        self.on_the_way, self._appearance = OnTheWay(), None
        self.see_through.let_go()
        self.building.end()
        self.imitated.stop()
        self.generation += 1

    def go_on(self, memory: SavedSession) -> None:
        """With a session that was kept; the loop is paused."""
        self.session.resume(memory.history, memory.head.cursor, memory.head.log)
        self._show_as(memory.head)
        self.view = replace(self.view, chosen=memory.head.chosen)
        self.begin_anew()

    def require_fit(self) -> None:
        """Raises ValueError if the session's moments are of another arm or other points than its scene's."""
        session, present = self.session, self.session.snapshot
        if present.theta.shape != session.embodiment.lower.shape or len(present.views.demo) != len(session.world.body):
            raise ValueError("its moments are not of this scene")

    def begin_like(self, memory: SavedSession) -> None:
        """By points from where a session that was kept stands, until its first camera images are there."""
        self.session.begin(on_points(memory.history[memory.head.cursor].settings))
        self._show_as(memory.head)
        self.begin_anew()

    def linked(self) -> Linked:
        """What a link to this page holds. Raises ValueError where that cannot be said."""
        view = self.view
        show = {name: on for name in SWITCHES if isinstance(on := getattr(view, name), bool)}
        chosen, speed = view.chosen, self.player.speed
        script, preset, lesson = self.session.script, self.preset.name, self.guided.place
        return Linked(script=script, preset=preset, speed=speed, chosen=chosen, show=show, lesson=lesson)

    def require_free(self) -> None:
        """Raises ValueError while the lecturer of a class has locked the controls."""
        if self.student is not None and self.student.holds is not None:
            raise ValueError(self.student.holds)

    def do_along(self, deed: Deed, speed: float, now: float) -> None:
        """What was done to another session, which Undo does not count as this one's past. speed: motions a second
        there. Raises ValueError for what cannot be."""
        if isinstance(deed, Stepped):
            self.player.follow(deed.times, speed, now)
        elif isinstance(deed, Posed):
            self.pose(np.array(deed.theta_demo), keep=False)
        elif isinstance(deed, Changed):
            self._change(converted(deed.fields), keep=False)
        else:
            do(self.session, deed)
            self.player.wake()

    def show_view_of(self, linked: Linked) -> None:
        """What of a link is no part of the session."""
        self.player.speed = linked.speed
        shown: dict[str, Any] = {name: linked.show[name] for name in SWITCHES if name in linked.show}
        view = replace(self.view, chosen=linked.chosen, **shown)
        if view != self.view:
            self.view = view

    def follow_link(self, linked: Linked, keep: bool = True) -> None:
        """The page becomes what the link holds; keep: Undo brings back what it was. Raises ValueError, with all as it
        is."""
        self.guided.require(linked.lesson)
        self.guided.leave()
        self.player.pause()
        before = tuple(self.session.history), self.session.cursor, self.session.log.copy()
        try:
            with self._kept(whole=True) if keep else nullcontext():
                play(linked.script, self.session)
        except ValueError:
            self.session.resume(*before)
            raise
        settings = linked.script.settings
        from_link = Preset("From a link", settings, linked.speed, "As it was sent.")
        self.preset = self.presets.get(linked.preset, from_link)
        if linked.preset == AS_STARTED and self.modified:  # another server was started otherwise
            self.preset = from_link
        self.show_view_of(linked)
        self.begin_anew()
        if linked.lesson is not None:
            self.guided.begin(*linked.lesson)

    def memory(self) -> SavedSession:
        """What of the page is kept. The opponent of a duel and what runs in the tab Experiments is not."""
        session, view = self.session, self.view
        head = SavedPage(
            begun=self.begun,
            cursor=session.cursor,
            length=len(session.history),
            preset=self.preset.name,
            speed=self.player.speed,
            chosen=view.chosen,
            show={name: getattr(view, name) for name in SWITCHES},
            dark=view.dark,
            motion=self._recorded(),
            lessons=self.guided.kept,
            lesson=self.guided.going_on,
            offered=self.guided.offered,
            log=session.log.copy(),
            name="" if self.student is None else self.student.name,
        )
        return SavedSession(head, tuple(session.history))

    def say(self, text: str, until: float) -> None:
        """A message for the visitor, as long as now < until, s."""
        self.message = Message(text, until)

    def refuse(self, why: str, until: float) -> None:
        """Say why something cannot be; the widgets show again what is."""
        self.say(why, until)
        self.refusals += 1

    def ask_for_landscapes(self) -> None:
        """For what has changed since they were asked for last."""
        world, present = self.session.world, self.session.snapshot
        self.landscape.ask(world, present)
        self.comparison.ask(world, present)
        self.basins.follow(self.session)
        self.duel_landscapes.ask(world, present, self.duel.opponent)

    def poses(self, now: float) -> tuple[NDArray, ...]:
        """(m,) rad each: where the learner is seen, the demonstrator, and the opponent or the see-through arm if there
        is one."""
        if (course := self.guided.course) is not None:
            shown, guessed = course.moments[-1], course.see_through
            return shown.theta, shown.theta_demo, *(() if guessed is None else (guessed,))
        if (seen := self.imitated.moment(now)) is not None:
            return seen.theta, seen.theta_demo
        learner, *others = [runner.theta(now)[0] for runner in self.player.runners]
        if not others and (moment := self.see_through.moment) is not None:
            others = [moment.theta]
        return learner, self.session.snapshot.theta_demo, *others

    def state(self, now: float, shortest_motion: float = 0.0) -> PageState:
        """What the page shows. shortest_motion: s; an arm on a shorter way is shown where it arrives."""
        state = self._state(now, shortest_motion)
        return state if self.guided.course is None else in_lesson(state, self.guided.course)

    def _state(self, now: float, shortest_motion: float) -> PageState:
        session, player, present = self.session, self.player, self.session.snapshot
        theta, moving = player.theta(now)
        if player.runners[0].duration < shortest_motion:
            theta, moving = present.theta, False
        looked, shown = self.on_the_way.of(session, theta, moving)
        imitated, see_through = self.imitated.moment(now), self.see_through.moment
        crossed = TRANSFERS[session.settings.transfer].crosses_lines
        if self.message is not None and now > self.message.until:
            self.message = None
        return PageState(
            generation=self.generation,
            refusals=self.refusals,
            session=session,
            settings=session.settings,
            present=present,
            looked=imitated or see_through or looked,
            look_at=self._look_at,
            pictures=session.eyes.pictures(looked) if isinstance(session.eyes, RemoteEyes) else {},
            shown=imitated or see_through or shown,
            on_its_way=theta if moving else None,
            see_through=None if imitated else see_through,
            imitated=self.imitated.describe() if imitated else None,
            stage=None if self.view.chosen is None else self.building.stage(now, last_stage(crossed)),
            playing=player.playing or (self.student is not None and self.student.moves_along),
            speed=player.speed,
            cursor=player.cursor,
            last=player.last,
            preset=self.preset,
            modified=self.modified,
            presets=self.presets,
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
            lessons=self.guided.lessons,
            course=self.guided.course,
            offered=self.guided.offered,
            word=None if self.shown_word is None else self.shown_word.key,
            holds=None if self.student is None else self.student.holds,
            follows=self.student is not None and self.student.follows,
            asked=None if self.student is None or self.student.heard is None else self.student.heard.orders.asked,
            classroom=None if self.lecturer is None else self.lecturer.view(now),
            name=None if self.student is None else self.student.name,
        )

    def _look_at(self, moment: Snapshot) -> tuple[Bodies, Windows]:
        """Both arms in the images at a moment of the session's, and the windows that show them."""
        if self._appearance is None:
            self._appearance = Appearance(self.session.world, self.session.snapshot)
        return self._appearance.of(moment)

    def save_picture(self, now: float) -> None:
        """Of the panel that is chosen, or of a lesson's figures. Raises ValueError where there is none."""
        if self.guided.course is not None:
            self.saving.lesson(self.view.picture_as, self.guided.course)
        else:
            self.saving.picture(self.view.picture, self.view.picture_as, self.state(now), self.eye())

    def close(self) -> None:
        """Give the eyes back."""
        self._eyes.close()
        self._opponents_eyes.close()

    def _show_as(self, head: SavedPage) -> None:
        self.preset = self.presets.get(head.preset, self.preset)
        self.player.speed = head.speed
        shown: dict[str, Any] = {name: head.show[name] for name in SWITCHES if name in head.show}
        self.view = replace(self.view, dark=head.dark, **shown)
        self.guided.resume(head.lessons, head.lesson, head.offered)
        if self.student is not None:
            self.student.name = name_of(head.name)

    def _make_motion(self, make: Callable[[], object]) -> None:
        self._services.landscapes.ask(self._page_id, make, self._take_motion_later, kind="motion")

    def _propose_point(self, make: Callable[[], object]) -> None:
        self._services.landscapes.ask(self._page_id, make, self._take_point_later, kind="point")

    def _take_point_later(self, made: object) -> None:
        self._queue.put(Arrival("point", self.points.take, made))

    def _take_motion_later(self, made: object) -> None:
        self._queue.put(MovingArrival("motion", self.motions.take, made))

    def _take_run_later(self, run: Run) -> None:
        self._queue.put(Arrival(("run", run.name), self.experiments.take, run))

    def _take_saved_later(self, kind: str, take: Callable, made: object) -> None:
        self._queue.put(Arrival(("saved", kind), take, made))

    def _recorded(self) -> bytes | None:
        """The motion that was recorded or loaded, as a file has it."""
        motion = self.motions.recorded
        if motion is None:
            return None
        if self._encoded is None or self._encoded[0] is not motion:
            self._encoded = motion, encode_motion(motion)
        return self._encoded[1]


def in_lesson(state: PageState, course: Course) -> PageState:
    """What a page shows in a lesson: that one's session."""
    step, moment = course.step, course.moments[-1]
    chosen = None if step is None else step.chosen
    view = replace(state.view, chosen=chosen, rays=False, residuals=False, gizmo=False, help=False, large=None)
    seen: dict[str, Any] = {"session": course.session, "present": moment, "looked": moment, "shown": moment}
    return replace(state, view=view, on_its_way=None, see_through=None, imitated=None, stage=None, pictures={}, **seen)


def on_points(settings: Settings) -> Settings:
    """The same with projected points."""
    return msgspec.structs.replace(settings, camera="points")
