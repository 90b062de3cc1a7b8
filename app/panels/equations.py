"""The paper's equations with their present numbers; in a wide window some stand under what they belong to."""

from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import ClassVar

from viewimit.drawing.equations import draw_conflict, draw_equations, draw_law
from viewimit.loop.snapshot import Snapshot

from ..drawing.glossary import asks
from ..model.state import PageState
from .panel import SLOWEST, Layout, Panel
from .widgets import put_html, put_visible


class EquationsPanel(Panel):
    inside = "Equations"

    def build(self, layout: Layout, state: PageState) -> None:
        with layout.tab(self.inside):
            self._equations = layout.gui.add_html("")
            layout.gui.add_html(asks(("lambda", "rho", "D")))

    def period(self, state: PageState) -> float:
        return SLOWEST

    def depends_on(self, state: PageState) -> tuple:
        return state.seen, state.view.chosen

    def show(self, state: PageState) -> None:
        put_html(self._equations, draw_equations(state.seen, state.view.chosen))


class BesidePanel(Panel):
    """One equation under what it belongs to, in a window with room for it."""

    tab: ClassVar[Callable[[Layout, str], AbstractContextManager]]
    draw: ClassVar[Callable[[Snapshot], str]]

    def build(self, layout: Layout, state: PageState) -> None:
        with type(self).tab(layout, self.inside):
            self._equation = layout.gui.add_html("", visible=False)

    def period(self, state: PageState) -> float:
        return SLOWEST

    def depends_on(self, state: PageState) -> tuple:
        return (self._moment(state) if state.view.wide else None,)

    def show(self, state: PageState) -> None:
        if state.view.wide:
            put_html(self._equation, f'<div class="vi-beside">{type(self).draw(self._moment(state))}</div>')
        put_visible(self._equation, state.view.wide)

    def _moment(self, state: PageState) -> Snapshot:
        """Of which its numbers are."""
        return state.present


class ConflictPanel(BesidePanel):
    """Eq. (6), under the images."""

    inside, tab, draw = "Images", Layout.upper_tab, draw_conflict

    def _moment(self, state: PageState) -> Snapshot:
        return state.looked


class LawPanel(BesidePanel):
    """The servo's law, under the landscape."""

    inside, tab, draw = "Landscape", Layout.tab, draw_law
