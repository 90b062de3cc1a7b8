"""The sentence under the scene: a message while it stays, else what is recorded or replayed, else that
nothing is saved, else the diagnosis."""

from viewimit.drawing.curves import following
from viewimit.drawing.status import describe, draw_status

from ..control.state import PageState
from .panel import Layout, Panel
from .widgets import put_html

LOOKS_BACK = 5  # motions


class StatusPanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        self._status = layout.gui.add_html("")

    @property
    def html(self) -> str:
        """As it is shown."""
        return self._status.content

    def depends_on(self, state: PageState) -> tuple:
        return state.message, state.unsaved, state.present, state.playing, _busy(state)

    def show(self, state: PageState) -> None:
        session, busy = state.session, _busy(state)
        if state.message is not None:
            self.show_message(state.message)
        elif busy is not None:
            kind, sentence = busy
            off = following(state.errors_deg)
            put_html(self._status, draw_status(kind, sentence.rstrip(".") + f"; learner {off}." if off else sentence))
        elif state.unsaved is not None:
            self.show_message(f"not saved: {state.unsaved}; a reload would lose this session.")
        else:
            before = session.history[max(session.cursor - LOOKS_BACK, 0) : session.cursor]
            put_html(self._status, draw_status(*describe(state.present, before, state.playing)))

    def show_message(self, text: str) -> None:
        """Whatever the state."""
        put_html(self._status, draw_status("message", text))


def _busy(state: PageState) -> tuple[str, str] | None:
    """State and sentence while a motion is recorded or replayed."""
    motions = state.motions
    return motions.describe() if motions.recording or motions.replaying else None
