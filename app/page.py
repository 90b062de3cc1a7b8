"""One page: a session, its pace, its drawings. Built in viser's thread, then ticked by the scheduler alone.

A session that looks with pictures takes its turns beside the scheduler; the page is ticked, and drawn, as ever.
"""

import threading
from collections.abc import Callable

import msgspec
import numpy as np
from numpy.typing import NDArray
from viser import ClientHandle

from viewimit.session import Session
from viewimit.settings import Settings
from viewimit.snapshot import Snapshot

from .control.inbox import Inbox
from .control.player import DENSE, Pace
from .control.presets import Preset, presets_from
from .control.redraw import Drawn
from .control.shedding import Load
from .control.turns import Turns
from .control.visitor import View, Visitor
from .control.wishes import Wishes
from .jobs.camera_images import CameraProcess
from .jobs.experiments import ExperimentWorker
from .jobs.landscapes import LandscapeWorker, landscape_key
from .jobs.session_eyes import RemoteEyes, SessionEyes
from .panels.comparison import Comparison
from .panels.controls import Controls
from .panels.duel import DuelTab
from .panels.laboratory import Laboratory
from .panels.panels import Panels
from .scene.hand_gizmo import HandGizmo
from .scene.scene3d import Scene3D
from .sessions.autosave import Head, Memory

WIDE = 1600  # px of window from which the page has room for more
PANELS_EVERY, CURVES_EVERY, EQUATIONS_EVERY = 0.1, 0.2, 0.5  # s; nobody reads numbers that change faster
COVERED = {False: 60, True: 250}  # px at the bottom of the scene that overlays cover
MESSAGE_STAYS = 6.0  # s
LEAVES_WITHIN = 3.0  # s that a turn may take to its end when its page is gone
KEPT_EVERY = 5.0  # s


class Page:
    """tick(now) takes what the visitor did, moves the loop on, and draws what changed."""

    def __init__(
        self,
        client: ClientHandle,
        worker: LandscapeWorker,
        experiments: ExperimentWorker,
        camera: CameraProcess,
        share_opponent: Callable[[], None],
        settings: Settings,
        keep: Callable[[Memory], str | None],
        load: Load,
        resumed: Memory | None = None,
    ):
        self._client, self._worker, self._begun, self._keep, self._load = client, worker, settings, keep, load
        self._inbox, self._view = Inbox(), View()
        self._eyes, self._opponents_eyes = SessionEyes(camera), SessionEyes(camera)
        self._turns = Turns()
        self._looked: Snapshot | None = None  # what the panels have shown last of an arm at rest
        self._heading: Snapshot | None = None  # the moment that the arm was seen at, or on its way to, last
        self._session = Session(settings, self._eyes, DENSE)
        pictured = resumed is not None and resumed.history[resumed.head.cursor].settings.camera == "rendered"
        if pictured:  # its eyes are opened in its first turn; until then it stands as it began
            self._session.begin(_on_points(resumed.history[resumed.head.cursor].settings))
            self._inbox.put("resume", resumed)
        elif resumed is not None:
            self._session.resume(resumed.history, resumed.head.cursor)
        self._pace = Pace(self._session)
        self._message: tuple[str, float] | None = None
        self._unsaved: str | None = None  # why the session is not kept, as `keep` has told last
        self._drawn = Drawn()
        self._canvas, self._dark = (0, 0), False
        presets = presets_from(settings)
        wide = client.camera.image_width >= WIDE
        with client.atomic():
            client.gui.main_panel.dock_left()
            client.gui.main_panel.set_width(300 if wide else 280)
            self._controls = Controls(client, self._inbox, presets, self._session)
            self._panels = Panels(client, self._inbox, wide)
            self._comparison = Comparison(client.client_id, self._panels, self._inbox, worker)
            tab = self._panels.lower.add_tab("Duel")
            self._duel = DuelTab(
                client, tab, self._inbox, self._session, self._pace, worker, wide, self._opponents_eyes
            )
            tab = self._panels.lower.add_tab("Experiments")
            pose = lambda theta: self._visitor.pose(theta)
            self._laboratory = Laboratory(client, tab, self._inbox, self._session, experiments, worker, pose)
            choose = lambda point: self._inbox.put("chosen", point)
            self._scene = Scene3D(client, choose, COVERED[wide], share_opponent)
            self._gizmo = HandGizmo(client, self._inbox)
            self._show_world()
        elsewhere = {
            "view": self._scene.fit_view,
            "help": self._panels.show_help,
            "dark": self._set_dark,
            "hand dropped": lambda _: self._drawn.forget("panels"),
            "landscape": self._panels.show_landscape,
            "resume": self._resume_pictures,
            **self._comparison.wishes,
            **self._duel.wishes,
            **self._laboratory.wishes,
        }
        self._visitor = Visitor(
            self._session,
            self._pace,
            self._controls,
            self._view,
            presets,
            self._duel.duel,
            self._show_world,
            elsewhere,
        )
        self._wishes = Wishes(
            self._inbox,
            self._session,
            self._pace,
            self._turns,
            load,
            self._visitor,
            self._duel.duel.wishes,
            self._laboratory,
            self._refuse,
            self._forgive,
            self._announce_pictures,
        )
        if resumed is not None:
            self._resume(msgspec.structs.replace(resumed.head, chosen=None) if pictured else resumed.head, presets)

    def memory(self) -> Memory:
        """What of the page is kept. The opponent of a duel and what runs in the tab Experiments is not."""
        session, view = self._session, self._view
        head = Head(
            begun=self._begun,
            cursor=session.cursor,
            length=len(session.history),
            preset=self._controls.preset.value,
            speed=self._pace.speed,
            chosen=view.chosen,
            show=dict(view.show),
            dark=self._dark,
            motion=self._laboratory.recorded,
        )
        return Memory(head, tuple(session.history))

    def _resume(self, head: Head, presets: dict[str, Preset]) -> None:
        """Show what the visitor had chosen; the loop is paused."""
        if head.preset in presets:
            self._controls.show_preset(presets[head.preset])
        self._pace.speed = head.speed
        self._controls.show_speed(head.speed)
        self._view.chosen = head.chosen
        self._controls.show_chosen(head.chosen)
        self._view.show.update({name: head.show[name] for name in self._view.show if name in head.show})
        self._controls.show_switches({**self._view.show, "dark": head.dark})
        if head.dark:
            self._set_dark(True)
        if head.motion is not None:
            self._inbox.put("motion file", head.motion)

    def _resume_pictures(self, resumed: Memory) -> None:
        self._session.resume(resumed.history, resumed.head.cursor)
        self._view.chosen = resumed.head.chosen
        self._visitor.draw_anew()

    def close(self) -> bool:
        """The page is gone. Whether its last turn has ended, so that what `memory` tells is whole."""
        ended = self._turns.wait(LEAVES_WITHIN)
        if ended:
            self._give_back_eyes()
        else:
            threading.Thread(target=self._give_back_eyes, name="viewimit-leaving", daemon=True).start()
        return ended

    def _give_back_eyes(self) -> None:
        self._turns.wait()
        self._eyes.close()
        self._opponents_eyes.close()

    def fail(self, error: Exception) -> None:
        """Show a fault of this session in its own page, and hold still."""
        self._pace.pause()
        self._say(f"This session met an error, {error!r}. Reset begins anew.", np.inf)
        self._panels.draw_state("message", self._message[0])

    def tick(self, now: float) -> None:
        self._wishes.tick(now)
        if not self._turns.alone:
            with self._client.atomic():  # viser's thread is woken once
                self._draw(now)
        if not self._turns.busy and self._drawn.due("kept", now, KEPT_EVERY):
            self._unsaved = self._keep(self.memory())

    def _refuse(self, why: str, now: float) -> None:
        """Say it, and show again what is."""
        self._say(why, now + MESSAGE_STAYS)
        self._controls.show(self._session.settings)
        self._drawn.forget("laboratory")

    def _forgive(self) -> None:
        self._message = None

    def _announce_pictures(self, now: float) -> None:
        """It takes seconds to begin with them."""
        self._draw(now)
        self._panels.draw_state("message", "starting the camera images …")

    def _draw(self, now: float) -> None:
        present = self._session.snapshot
        (theta, moving), *others = [runner.theta(now) for runner in self._pace.runners]
        poses = [theta, present.theta_demo, *(other for other, _ in others)]
        if self._drawn.changed("poses", *(pose.tobytes() for pose in poses)):
            self._scene.draw_poses(*poses)
        panels_every = PANELS_EVERY * self._load.panels
        if not self._drawn.due("panels", now, panels_every):
            return
        self._controls.show_playing(self._pace.playing)
        self._fit_new_canvas()
        self._ask_for_landscape(present)
        self._comparison.tick(self._session.world, present)
        if self._pace.runners[0].duration < 2 * panels_every:  # gone by when it would be drawn again
            theta, moving = present.theta, False
        shown_as = self._view.chosen, tuple(self._view.show.values()), self._panels.landscape
        if self._drawn.changed("panels", present, theta.tobytes(), *shown_as):
            self._draw_panels(*self._seen(theta, moving, present), present)
        self._draw_status(now)
        if self._drawn.changed("duel", *self._duel.state):
            self._duel.draw()
        if self._drawn.changed("laboratory", *self._laboratory.state):
            self._laboratory.draw()
        self._draw_plots(now, present, theta if moving else None)

    def _draw_plots(self, now: float, present: Snapshot, on_its_way: NDArray | None) -> None:
        """on_its_way: (m,) rad, where the arm is seen; None at rest."""
        every, seen = CURVES_EVERY * self._load.plots, present.theta if on_its_way is None else on_its_way
        if (on_its_way is not None or self._drawn.due("path", now, every)) and self._drawn.changed(
            "path", present, seen.tobytes(), self._pace.last, self._panels.landscape
        ):
            self._panels.draw_path(self._session, on_its_way)
        if self._drawn.due("curves", now, every) and self._drawn.changed(
            "curves", present, self._pace.cursor, self._pace.last, self._view.chosen, self._panels.landscape
        ):
            self._panels.draw_curves(self._session)
            self._controls.show_history(self._pace.cursor, self._pace.last)
        if self._drawn.due("equations", now, EQUATIONS_EVERY * self._load.plots) and self._drawn.changed(
            "equations", present, self._view.chosen
        ):
            self._panels.draw_equations(self._session, self._view.chosen)

    def _draw_status(self, now: float) -> None:
        """A message as long as it stays, else what is recorded or replayed, else that nothing is saved, else the
        diagnosis."""
        if self._message and now > self._message[1]:
            self._message = None
        if self._message:
            self._panels.draw_state("message", self._message[0])
        elif busy := self._laboratory.describe():
            self._panels.draw_following(self._session, *busy)
        elif self._unsaved:
            self._panels.draw_state("message", f"not saved: {self._unsaved}; a reload would lose this session.")
        else:
            self._panels.draw_status(self._session, self._pace.playing)

    def _seen(self, theta: NDArray, moving: bool, present: Snapshot) -> tuple[Snapshot, Snapshot]:
        """What the images show, and what all else does. On its way an arm is seen by points only: no picture of it is
        taken before it has arrived."""
        left, self._heading = self._heading, present
        if not moving:
            self._looked = present
        elif present.settings.camera == "points":
            self._looked = self._session.observe(theta, present)
        elif left is not None:
            if left is not present:  # a motion has begun; the arm may have rested too shortly to be drawn there
                self._looked = left
            return self._looked, self._looked.with_fields(theta=theta, theta_demo=present.theta_demo)
        else:
            self._looked = present
        return self._looked, self._looked

    def _draw_panels(self, looked: Snapshot, shown: Snapshot, present: Snapshot) -> None:
        eyes = self._session.eyes
        pictures = eyes.pictures(looked) if isinstance(eyes, RemoteEyes) else {}
        self._scene.draw(shown, self._view.chosen, self._view.show)
        self._scene.show_pictures(pictures)
        self._panels.draw_images(looked, self._view.chosen, self._view.show["whole_frames"], pictures)
        self._controls.show_learner(self._session.scene, shown.theta, present.theta_demo)
        self._gizmo.show(self._view.show["gizmo"], present.theta_demo, self._scene.hand_position)

    def _ask_for_landscape(self, present: Snapshot) -> None:
        if self._drawn.changed("landscape", *landscape_key(present)):
            world, make = self._session.world, self._panels.make_landscape
            done = lambda made: self._inbox.put("landscape", made)
            self._worker.ask(self._client.client_id, lambda: make(world, present), done)

    def _show_world(self) -> None:
        self._scene.build(self._session.world)
        self._panels.set_world(self._session.world, self._session.snapshot)
        self._drawn.forget_all()
        self._looked = self._heading = None

    def _fit_new_canvas(self) -> None:
        """Fit the view when the canvas has changed, as when the panels dock or the window is resized."""
        size = (self._client.camera.image_width, self._client.camera.image_height)
        if size != self._canvas and min(size) > 0:
            self._canvas = size
            self._scene.fit_untouched_view()

    def _set_dark(self, dark) -> None:
        self._dark = bool(dark)
        self._client.gui.configure_theme(dark_mode=bool(dark), show_logo=False, show_share_button=False)
        self._scene.set_dark(bool(dark))

    def _say(self, text: str, until: float) -> None:
        self._message = text, until


def _on_points(settings: Settings) -> Settings:
    return msgspec.structs.replace(settings, camera="points")
