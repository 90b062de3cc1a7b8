"""Where the learner starts: one slider a joint, folded under the landscape, on which a click asks for the same."""

from functools import partial

from viewimit.drawing.svg import joint_symbol
from viewimit.settings import given

from ..control.commands.session import StartJoint
from ..control.state import PageState
from .panel import Layout, Panel
from .widgets import put


class StartPanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        self._gui, self._queue = layout.gui, layout.queue
        with layout.tab("Landscape"):
            self._inside = self._gui.add_folder("Start", expand_by_default=False)
        self._sliders: list = []
        self._add_sliders(state)

    def depends_on(self, state: PageState) -> tuple:
        return state.generation, state.settings.start_deg, state.refusals

    def show(self, state: PageState) -> None:
        if state.generation != self._generation:
            for slider in self._sliders:
                slider.remove()
            self._add_sliders(state)
        for slider, angle in zip(self._sliders, given(state.settings.start_deg)):
            put(slider, round(angle, 1))

    def _add_sliders(self, state: PageState) -> None:
        scene, angles = state.session.scene, given(state.settings.start_deg)
        self._generation, self._sliders = state.generation, []
        with self._inside:
            for k, (joint, (low, high)) in enumerate(zip(scene.moving_joints, scene.range_deg)):
                name, hint = f"Start {joint_symbol(joint)}", "degrees; the learner begins anew there"
                slider = self._gui.add_slider(name, low, high, 0.5, angles[k], hint=hint)
                self._queue.on_value(slider, partial(StartJoint.parse, k))
                self._sliders.append(slider)
