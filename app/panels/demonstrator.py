"""One slider for each of the demonstrator's joints that move."""

from viewimit.loop.settings import given

from ..commands.session import PoseJoint
from ..model.state import PageState
from .panel import Layout, Panel
from .widgets import JointSliders


class DemonstratorPanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        with layout.gui.add_folder("Demonstrator"):
            layout.gui.add_html('<span class="vi-demonstrator-folder"></span>')
            inside = layout.gui.add_folder(None)
        self._sliders = JointSliders(layout, inside, "{}", PoseJoint.parse)
        self.show(state)

    def depends_on(self, state: PageState) -> tuple:
        return state.generation, state.settings.demonstrator_deg, state.refusals

    def show(self, state: PageState) -> None:
        self._sliders.show(state, given(state.settings.demonstrator_deg))
