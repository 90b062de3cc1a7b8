"""Which motion is shown, out of those that are kept; and how many a second are made."""

from ..commands.session import ChooseSpeed, Scrub
from ..model.choices import SPEEDS
from ..model.state import PageState
from .panel import SLOW, Layout, Panel
from .widgets import put, put_html, put_most

LONG = 1000  # motions, whose number leaves no room for another beside the slider


class HistoryPanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        gui = layout.gui
        self._count = gui.add_html("")
        self._history = gui.add_slider("History", 0, 1, 1, 0)
        self._speed = gui.add_dropdown("Speed", list(SPEEDS), initial_value=speed_name(state.speed))
        layout.queue.on_value(self._history, Scrub.parse)
        layout.queue.on_value(self._speed, ChooseSpeed.parse)

    def period(self, state: PageState) -> float:
        return SLOW

    def depends_on(self, state: PageState) -> tuple:
        return state.cursor, state.last, state.speed, state.refusals

    def show(self, state: PageState) -> None:
        put_most(self._history, max(state.last, 1))
        put(self._history, state.cursor)
        at = f"{state.cursor} " if state.last < LONG else ""  # it stands in the slider's box too
        put_html(self._count, f'<div class="vi-count"><span>{at}of {state.last}</span></div>')
        put(self._speed, speed_name(state.speed))


def speed_name(motions_per_second: float) -> str:
    return next(name for name, value in SPEEDS.items() if value == motions_per_second)
