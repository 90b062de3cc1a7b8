"""The strip over the scene: what the learner says, and beneath it what is true.

What it says gives way to a message while that stays, to what is recorded or replayed, and to that nothing is saved.
"""

from viewimit.drawing.curves import following
from viewimit.drawing.status import Said, describe, describe_truth, draw_status

from ..control.state import PageState
from .panel import Layout, Panel
from .widgets import put_html

LOOKS_BACK = 5  # motions


class StatusPanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        self._status = layout.gui.add_html("")
        self._truth = ""

    @property
    def html(self) -> str:
        """As it is shown."""
        return self._status.content

    def depends_on(self, state: PageState) -> tuple:
        return state.message, state.unsaved, state.present, state.playing, _busy(state)

    def show(self, state: PageState) -> None:
        self._truth = _truth(state)
        put_html(self._status, draw_status(_said(state), self._truth))

    def show_message(self, text: str) -> None:
        """Whatever the state."""
        put_html(self._status, draw_status(Said("message", text), self._truth))


def _said(state: PageState) -> Said:
    session, busy = state.session, _busy(state)
    if state.message is not None:
        return Said("message", state.message)
    if busy is not None:
        return Said(*busy)
    if state.unsaved is not None:
        return Said("message", f"not saved: {state.unsaved}; a reload would lose this session.")
    before = session.history[max(session.cursor - LOOKS_BACK, 0) : session.cursor]
    return describe(state.present, before, state.playing, state.assessment, session.scene.moving_joints)


def _truth(state: PageState) -> str:
    off = following(state.errors_deg) if _busy(state) is not None else ""
    if off:
        return off + "."
    present = state.present
    return describe_truth(state.session.scene.moving_joints, present.theta, present.theta_demo)


def _busy(state: PageState) -> tuple[str, str] | None:
    """State and sentence while a motion is recorded or replayed."""
    motions = state.motions
    return motions.describe() if motions.recording or motions.replaying else None
