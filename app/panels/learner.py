"""The learner's joints beside the demonstrator's, as bars."""

from viewimit.drawing.learner_bars import draw_learner

from ..control.state import PageState
from .panel import Layout, Panel
from .widgets import put_html


class LearnerPanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        with layout.gui.add_folder("Learner"):
            self._bars = layout.gui.add_html("")

    def depends_on(self, state: PageState) -> tuple:
        return state.generation, state.shown.theta.tobytes(), state.present.theta_demo.tobytes(), state.present.status

    def show(self, state: PageState) -> None:
        arms = state.shown.theta, state.present.theta_demo
        put_html(self._bars, draw_learner(state.session.scene, *arms, state.assessment))
