"""The sentence under the scene: a message while it stays, else what is recorded or replayed, else that
nothing is saved, else the diagnosis."""

from viewimit.drawing.curves import following
from viewimit.drawing.over.links import link, sink
from viewimit.drawing.over.postures import describe_see_through
from viewimit.drawing.status import describe, draw_status

from ..control.state import PageState
from .panel import Layout, Panel
from .widgets import put_html

LOOKS_BACK = 5  # motions


class StatusPanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        self._status, self._address = layout.gui.add_html(""), layout.address
        if self._address is not None:
            layout.gui.add_html(sink())

    @property
    def html(self) -> str:
        """As it is shown."""
        return self._status.content

    def depends_on(self, state: PageState) -> tuple:
        return state.message, state.unsaved, state.present, state.playing, state.see_through, _busy(state)

    def show(self, state: PageState) -> None:
        session, busy = state.session, _busy(state)
        if state.message is not None:
            self.show_message(state.message)
        elif busy is not None:
            kind, sentence = busy
            off = following(state.errors_deg)
            put_html(self._status, draw_status(kind, sentence.rstrip(".") + f"; learner {off}." if off else sentence))
        elif state.see_through is not None:
            sentence = describe_see_through(session.scene, state.see_through)
            put_html(self._status, draw_status("see-through", sentence, self._choices()))
        elif state.unsaved is not None:
            self.show_message(f"not saved: {state.unsaved}; a reload would lose this session.")
        else:
            before = session.history[max(session.cursor - LOOKS_BACK, 0) : session.cursor]
            put_html(self._status, draw_status(*describe(state.present, before, state.playing)))

    def _choices(self) -> str:
        """What may be done about a see-through arm."""
        if self._address is None:
            return ""
        choices = ("start/0", "Start here"), ("dismiss/0", "Let go")
        return "".join(link(self._address, what, words, words) for what, words in choices) + "<kbd>Esc</kbd>"

    def show_message(self, text: str) -> None:
        """Whatever the state."""
        put_html(self._status, draw_status("message", text))


def _busy(state: PageState) -> tuple[str, str] | None:
    """State and sentence while a motion is recorded or replayed."""
    motions = state.motions
    return motions.describe() if motions.recording or motions.replaying else None
