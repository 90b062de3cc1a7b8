"""The learner's joints beside the demonstrator's, as bars; what it has seen of itself before; and where it starts,
folded: a slider a joint, which asks for the same as a click on the landscape."""

from numpy.typing import NDArray

from viewimit.loop.settings import given

from ..commands.session import StartJoint
from ..drawing.joint_bars import draw_learner
from ..model.state import PageState
from .panel import SLOW, Layout, Panel
from .rehearsal import RehearsalButton
from .widgets import JointSliders, put_html


class LearnerPanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        with layout.gui.add_folder("Learner"):
            self._bars = layout.gui.add_html("")
            self._rehearsal = RehearsalButton(layout)
            inside = layout.gui.add_folder("Start", expand_by_default=False)
        hint = "degrees; the learner begins anew there"
        self._start = JointSliders(layout, inside, "Start {}", StartJoint.parse, hint)

    def depends_on(self, state: PageState) -> tuple:
        own = _stands(state).tobytes()
        shown = own, state.seen.theta_demo.tobytes(), state.present.status, state.imitated is None
        return state.generation, *shown, state.settings.start_deg, state.rehearsal, state.refusals

    def period(self, state: PageState) -> float:
        """Its own position moves along with the arm; numbers that change with every motion nobody reads faster."""
        return 0.0 if state.on_its_way is not None else SLOW

    def show(self, state: PageState) -> None:
        arms = _stands(state), state.seen.theta_demo
        assessment = state.assessment if state.imitated is None else None  # which is of the session's moment
        put_html(self._bars, draw_learner(state.session.scene, *arms, assessment))
        self._rehearsal.show(state)
        self._start.show(state, given(state.settings.start_deg))


def _stands(state: PageState) -> NDArray:
    """(m,) rad, where the arm is seen; a see-through one is another."""
    return state.seen.theta if state.on_its_way is None or state.imitated is not None else state.on_its_way
