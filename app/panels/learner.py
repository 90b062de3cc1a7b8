"""The learner's joints beside the demonstrator's, as bars."""

from numpy.typing import NDArray

from viewimit.drawing.learner_bars import draw_learner

from ..control.state import PageState
from .panel import Layout, Panel
from .widgets import put_html


class LearnerPanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        with layout.gui.add_folder("Learner"):
            self._bars = layout.gui.add_html("")

    def depends_on(self, state: PageState) -> tuple:
        return state.generation, _stands(state).tobytes(), state.present.theta_demo.tobytes()

    def show(self, state: PageState) -> None:
        put_html(self._bars, draw_learner(state.session.scene, _stands(state), state.present.theta_demo))


def _stands(state: PageState) -> NDArray:
    """(m,) rad, where the arm is seen; a see-through one is another."""
    return state.present.theta if state.on_its_way is None else state.on_its_way
