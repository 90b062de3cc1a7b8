"""How the page shows the session: a chosen point, layout, camera images, switches, colours, the default camera."""

import html
from functools import partial

from viewimit.simulation.eyes import require_eyes
from viewimit.simulation.scene import Scene

from ..commands.display import ChoosePoint, FitView, Switch
from ..commands.method import switch_camera, switch_rectify
from ..commands.tools import ChooseLayout
from ..model.choices import NO_POINT
from ..model.points import chosen_layout, layout_choices
from ..model.state import PageState
from .panel import Layout, Panel
from .widgets import put

SWITCHES = (
    ("Goal in L and R", "goal"),
    ("Rays", "rays"),
    ("Residuals, 3-D", "residuals"),
    ("Hand gizmo", "gizmo"),
    ("Whole frames", "whole_frames"),
    ("Raw, rectified", "rectified"),
    ("Shadows", "shadows"),
    ("Dark", "dark"),
)


class DisplayPanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        self._gui, queue = layout.gui, layout.queue
        gui = self._gui
        with gui.add_folder("Display", expand_by_default=False):
            self._chosen = gui.add_dropdown("Point", [NO_POINT], initial_value=NO_POINT)
            self._points = gui.add_dropdown("Layout", ["10 points"], initial_value="10 points")
            self._rectify = gui.add_checkbox("Rectify", True, hint="the images, where their matches ask for it")
            self._camera = gui.add_checkbox("Camera images", False)
            self._why_not = gui.add_html("", visible=False)
            self._switches = {name: gui.add_checkbox(label, state.view.on(name)) for label, name in SWITCHES}
            fit = gui.add_button("Fit view")
        queue.on_value(self._chosen, ChoosePoint.parse)
        queue.on_value(self._points, ChooseLayout.parse)
        queue.on_value(self._rectify, switch_rectify)
        queue.on_value(self._camera, switch_camera)
        for name, handle in self._switches.items():
            queue.on_value(handle, partial(Switch.parse, name))
        queue.on_click(fit, FitView())
        self._generation, self._dark = -1, False

    @property
    def camera_on(self) -> bool:
        """As the box shows it."""
        return self._camera.value

    def depends_on(self, state: PageState) -> tuple:
        return state.generation, state.settings, state.view, state.refusals

    def show(self, state: PageState) -> None:
        settings, view = state.settings, state.view
        if state.generation != self._generation:
            self._generation = state.generation
            self._offer(state)
        put(self._chosen, NO_POINT if view.chosen is None else str(view.chosen))
        put(self._points, self._markers or chosen_layout(settings))
        put(self._rectify, settings.rectify == "auto")
        put(self._camera, settings.sensor == "rendered")
        for name, handle in self._switches.items():
            put(handle, view.on(name))
        if view.on("dark") != self._dark:
            self._dark = view.on("dark")
            self._gui.configure_theme(dark_mode=self._dark, show_logo=False, show_share_button=False)

    def _offer(self, state: PageState) -> None:
        """The choices that depend on the scene and on what is seen of it."""
        count = len(state.session.world.body)
        pictured = state.settings.sensor == "rendered"  # which show the markers that the robot wears, in one layout
        self._markers = f"{count} markers" if pictured else ""
        why = why_no_pictures(state.session.scene)
        self._camera.disabled = why is not None
        self._why_not.content = "" if why is None else f'<div class="vi-why">{html.escape(why)}</div>'
        self._why_not.visible = why is not None
        self._points.options = [self._markers] if pictured else list(layout_choices(state.settings))
        self._points.disabled = pictured
        self._chosen.options = [NO_POINT, *(str(i) for i in range(count))]


def why_no_pictures(scene: Scene) -> str | None:
    """Why camera images cannot be had of this scene here, None if they can."""
    try:
        require_eyes("rendered", scene)
    except ValueError as reason:
        return str(reason)
    return None
