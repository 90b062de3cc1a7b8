"""One page: a session, its pace, its drawings. Built in viser's thread, then ticked by the scheduler alone."""

from collections.abc import Callable

import numpy as np
from viser import ClientHandle

from viewimit.session import Session
from viewimit.snapshot import Settings, Snapshot

from .comparison import Comparison
from .controls import Controls
from .duel_tab import DuelTab
from .experiment_worker import ExperimentWorker
from .inbox import Inbox
from .keeper import Head, Memory
from .laboratory import Laboratory
from .landscape_worker import LandscapeWorker, landscape_key
from .load import Load
from .pace import Pace
from .panels import Panels
from .presets import Preset, presets_from
from .scene3d import Scene3D
from .visitor import View, Visitor

WIDE = 1600  # px of window from which the page has room for more
PANELS_EVERY, CURVES_EVERY, EQUATIONS_EVERY = 0.1, 0.2, 0.5  # s; nobody reads numbers that change faster
COVERED = {False: 60, True: 250}  # px at the bottom of the scene that overlays cover
MESSAGE_STAYS = 6.0  # s
KEPT_EVERY = 5.0  # s


class Page:
    """tick(now) takes what the visitor did, moves the loop on, and draws what changed."""

    def __init__(
        self,
        client: ClientHandle,
        worker: LandscapeWorker,
        experiments: ExperimentWorker,
        share_opponent: Callable[[], None],
        settings: Settings,
        keep: Callable[[Memory], None],
        load: Load,
        resumed: Memory | None = None,
    ):
        self._client, self._worker, self._begun, self._keep, self._load = client, worker, settings, keep, load
        self._inbox, self._view = Inbox(), View()
        self._session = Session(settings)
        if resumed is not None:
            self._session.resume(resumed.history, resumed.head.cursor)
        self._pace = Pace(self._session)
        self._message: tuple[str, float] | None = None
        self._drawn: dict[str, tuple] = {}
        self._last: dict[str, float] = {}
        self._canvas, self._dragging, self._dark = (0, 0), False, False
        presets = presets_from(settings)
        wide = client.camera.image_width >= WIDE
        with client.atomic():
            client.gui.main_panel.dock_left()
            client.gui.main_panel.set_width(300 if wide else 280)
            self._controls = Controls(client, self._inbox, presets, self._session)
            self._panels = Panels(client, self._inbox, wide)
            self._comparison = Comparison(client.client_id, self._panels, self._inbox, worker)
            tab = self._panels.lower.add_tab("Duel")
            self._duel = DuelTab(client, tab, self._inbox, self._session, self._pace, worker, wide)
            tab = self._panels.lower.add_tab("Experiments")
            pose = lambda theta: self._visitor.pose(theta)
            self._laboratory = Laboratory(client, tab, self._inbox, self._session, experiments, worker, pose)
            choose = lambda point: self._inbox.put("chosen", point)
            self._scene = Scene3D(client, choose, COVERED[wide], share_opponent)
            self._gizmo = self._add_gizmo()
            self._show_world()
        elsewhere = {
            "view": self._scene.fit_view,
            "help": self._panels.show_help,
            "dark": self._set_dark,
            "hand dropped": self._drop_hand,
            "landscape": self._panels.show_landscape,
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

        if resumed is not None:
            self._resume(resumed.head, presets)

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

    def fail(self, error: Exception) -> None:
        """Show a fault of this session in its own page, and hold still."""
        self._pace.pause()
        self._say(f"This session met an error, {error!r}. Reset begins anew.", np.inf)
        self._panels.draw_state("message", self._message[0])

    def tick(self, now: float) -> None:
        values, actions = self._inbox.take()
        for name, value in values.items():
            self._allow(now, self._visitor.set, name, value)
        for action in actions:
            self._allow(now, self._visitor.act, action, now)
        self._laboratory.tick()
        self._pace.advance(now, self._load.step_budget)
        with self._client.atomic():  # viser's thread is woken once
            self._draw(now)
        if self._due("kept", now, KEPT_EVERY):
            self._keep(self.memory())

    def _allow(self, now: float, carry_out: Callable, what: str, *value) -> None:
        """Carry out one wish of the visitor; one that cannot be is said, and the others go on."""
        try:
            if what == "reset":
                self._message = None
            carry_out(what, *value)
        except ValueError as refusal:
            self._say(str(refusal), now + MESSAGE_STAYS)
            self._controls.show(self._session.settings)
            self._drawn.pop("laboratory", None)

    def _draw(self, now: float) -> None:
        present = self._session.snapshot
        (theta, _), *others = [runner.theta(now) for runner in self._pace.runners]
        poses = [theta, present.theta_demo, *(other for other, _ in others)]
        if self._changed("poses", *(pose.tobytes() for pose in poses)):
            self._scene.draw_poses(*poses)
        panels_every = PANELS_EVERY * self._load.panels
        if not self._due("panels", now, panels_every):
            return
        self._controls.show_playing(self._pace.playing)
        self._fit_new_canvas()
        self._ask_for_landscape(present)
        self._comparison.tick(self._session.world, present)
        if self._pace.runners[0].duration < 2 * panels_every:  # gone by when it would be drawn again
            theta = present.theta
        shown_as = self._view.chosen, tuple(self._view.show.values()), self._panels.landscape
        if self._changed("panels", present, theta.tobytes(), *shown_as):
            shown = present if theta is present.theta else self._session.observe(theta, present)
            self._draw_panels(shown, present)
        self._draw_status(now)
        if self._changed("duel", *self._duel.state):
            self._duel.draw()
        if self._changed("laboratory", *self._laboratory.state):
            self._laboratory.draw()
        if self._due("curves", now, CURVES_EVERY * self._load.plots) and self._changed(
            "curves", present, self._pace.cursor, self._pace.last, self._view.chosen, self._panels.landscape
        ):
            self._panels.draw_curves(self._session)
            self._controls.show_history(self._pace.cursor, self._pace.last)
        if self._due("equations", now, EQUATIONS_EVERY * self._load.plots) and self._changed(
            "equations", present, self._view.chosen
        ):
            self._panels.draw_equations(self._session, self._view.chosen)

    def _draw_status(self, now: float) -> None:
        """A message as long as it stays, else what is recorded or replayed, else the diagnosis."""
        if self._message and now > self._message[1]:
            self._message = None
        if self._message:
            self._panels.draw_state("message", self._message[0])
        elif busy := self._laboratory.describe():
            self._panels.draw_following(self._session, *busy)
        else:
            self._panels.draw_status(self._session, self._pace.playing)

    def _draw_panels(self, shown: Snapshot, present: Snapshot) -> None:
        self._scene.draw(shown, self._view.chosen, self._view.show)
        self._panels.draw_images(shown, self._view.chosen, self._view.show["whole_frames"])
        self._panels.draw_path(self._session, shown)
        self._controls.show_learner(self._session.scene, shown.theta, present.theta_demo)
        self._gizmo.visible = self._view.show["gizmo"]
        if not self._dragging and self._changed("hand", present.theta_demo.tobytes()):
            self._gizmo.position = self._scene.hand_position(present.theta_demo)

    def _ask_for_landscape(self, present: Snapshot) -> None:
        if self._changed("landscape", *landscape_key(present)):
            world, make = self._session.world, self._panels.make_landscape
            done = lambda made: self._inbox.put("landscape", made)
            self._worker.ask(self._client.client_id, lambda: make(world, present), done)

    def _show_world(self) -> None:
        self._scene.build(self._session.world)
        self._panels.set_world(self._session.world, self._session.snapshot)
        self._drawn.clear()

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

    def _due(self, what: str, now: float, period: float) -> bool:
        if now - self._last.get(what, -np.inf) < 0.9 * period:  # ticks jitter
            return False
        self._last[what] = now
        return True

    def _changed(self, what: str, *state) -> bool:
        """Whether this differs from what was drawn last; nothing is sent when nothing changes."""
        before, self._drawn[what] = self._drawn.get(what), state
        if before is None or len(before) != len(state):
            return True
        return any(a is not b and (isinstance(a, Snapshot) or a != b) for a, b in zip(before, state))

    def _drop_hand(self, _) -> None:
        self._dragging = False
        self._drawn.pop("hand", None)
        self._drawn.pop("panels", None)

    def _add_gizmo(self):
        gizmo = self._client.scene.add_transform_controls(
            "/demonstrator_hand", scale=0.22, disable_rotations=True, disable_sliders=True, opacity=0.7
        )

        @gizmo.on_update
        async def _(event) -> None:
            self._dragging = True
            self._inbox.put("hand", np.array(event.target.position, float))

        @gizmo.on_drag_end
        async def _(_event) -> None:
            self._inbox.put("hand dropped", True)

        return gizmo
