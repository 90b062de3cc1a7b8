"""One slider for each of the demonstrator's joints that move."""

from functools import partial

from viewimit.drawing.svg import joint_symbol
from viewimit.settings import given

from ..control.commands.session import PoseJoint
from ..control.state import PageState
from .panel import Layout, Panel
from .widgets import put


class DemonstratorPanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        self._gui, self._queue = layout.gui, layout.queue
        with self._gui.add_folder("Demonstrator"):
            self._gui.add_html('<span class="vi-demonstrator-folder"></span>')
            self._inside = self._gui.add_folder(None)
        self._sliders: list = []
        self._add_sliders(state)

    def depends_on(self, state: PageState) -> tuple:
        return state.generation, state.settings.demonstrator_deg, state.refusals

    def show(self, state: PageState) -> None:
        if state.generation != self._generation:
            for slider in self._sliders:
                slider.remove()
            self._add_sliders(state)
        for slider, angle in zip(self._sliders, given(state.settings.demonstrator_deg)):
            put(slider, round(angle, 1))

    def _add_sliders(self, state: PageState) -> None:
        scene, angles = state.session.scene, given(state.settings.demonstrator_deg)
        self._generation, self._sliders = state.generation, []
        with self._inside:
            for k, (joint, (low, high)) in enumerate(zip(scene.moving_joints, scene.range_deg)):
                slider = self._gui.add_slider(joint_symbol(joint), low, high, 0.5, angles[k], hint="degrees")
                self._queue.on_value(slider, partial(PoseJoint.parse, k))
                self._sliders.append(slider)
