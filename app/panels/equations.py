"""The paper's equations with their present numbers; in a wide window some stand under what they belong to."""

from viewimit.drawing.equations import draw_conflict, draw_equations, draw_law

from ..control.state import PageState
from .panel import SLOWEST, Layout, Panel
from .widgets import put_html


class EquationsPanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        with layout.tab("Equations"):
            self._equations = layout.gui.add_html("")

    def period(self, state: PageState) -> float:
        return SLOWEST

    def depends_on(self, state: PageState) -> tuple:
        return state.present, state.view.chosen

    def show(self, state: PageState) -> None:
        put_html(self._equations, draw_equations(state.present, state.view.chosen))


class ConflictPanel(Panel):
    """Eq. (6), under the images."""

    def build(self, layout: Layout, state: PageState) -> None:
        self._wide = layout.wide
        with layout.upper_tab("Images"):
            self._conflict = layout.gui.add_html("", visible=layout.wide)

    def period(self, state: PageState) -> float:
        return SLOWEST

    def depends_on(self, state: PageState) -> tuple:
        return (state.see_through or state.present,) if self._wide else ()

    def show(self, state: PageState) -> None:
        if self._wide:
            put_html(self._conflict, draw_conflict(state.see_through or state.present))


class LawPanel(Panel):
    """The servo's law, under the landscape."""

    def build(self, layout: Layout, state: PageState) -> None:
        self._wide = layout.wide
        with layout.tab("Landscape"):
            self._law = layout.gui.add_html("", visible=layout.wide)

    def period(self, state: PageState) -> float:
        return SLOWEST

    def depends_on(self, state: PageState) -> tuple:
        return (state.present,) if self._wide else ()

    def show(self, state: PageState) -> None:
        if self._wide:
            put_html(self._law, draw_law(state.present))
