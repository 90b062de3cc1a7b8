"""On a student's page: a banner while the lecturer leads or has locked it, and a name, if they want to give one."""

from viewimit.drawing.svg import escape

from ...classroom.messages import MOST_NAME
from ...control.commands.classroom import NameYourself
from ...control.state import PageState
from ..panel import Layout, Panel
from ..widgets import put, put_html

LEADS = "<b>The lecturer leads.</b> This page follows."
FREEZES = "<b>The controls are frozen</b> by the lecturer."
ASKS = "<b>The class is asked.</b>"
HINT = f"optional: shown to the lecturer alone, {MOST_NAME} characters at most, kept with this session"


class StudentPanel(Panel):
    in_lessons = True

    def build(self, layout: Layout, state: PageState) -> None:
        self._name = None
        if state.name is None:
            return
        self._banner = layout.gui.add_html("")
        self._name = layout.gui.add_text("Your name", state.name, hint=HINT)
        layout.queue.on_value(self._name, NameYourself.parse)

    def depends_on(self, state: PageState) -> tuple:
        return state.holds, state.follows, state.name, state.asked is None

    def show(self, state: PageState) -> None:
        if self._name is None:
            return
        put_html(self._banner, _banner(state))
        put(self._name, state.name or "")


def _banner(state: PageState) -> str:
    if state.holds is None:
        return ""
    words = ASKS if state.asked is not None else LEADS if state.follows else FREEZES
    kind = "asks" if state.asked is not None else "leads" if state.follows else "freezes"
    name = escape(state.holds)
    return f'<div class="vi-banner vi-banner-{kind}" role="alert" title="{name}"><p>{words}</p></div>'
