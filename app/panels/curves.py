"""E and the joint errors, motion by motion: a card over the scene of a wide window, or a tab."""

from viewimit.drawing.curves import draw_curves
from viewimit.drawing.over.links import sink

from ..control.state import PageState
from .panel import SLOW, Layout, Panel
from .widgets import put_html, put_visible

CARD_WIDTH, TAB_WIDTH = 860, 424  # px


class CurvesPanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        self._address = layout.address
        self._card = layout.gui.add_html("", visible=False)
        with layout.tab("Curves"):
            self._tab = layout.gui.add_html("")
            if self._address is not None:
                layout.gui.add_html(sink())

    def period(self, state: PageState) -> float:
        return SLOW

    def depends_on(self, state: PageState) -> tuple:
        return state.present, state.cursor, state.last, state.landscape, state.view.wide

    def show(self, state: PageState) -> None:
        session, wide = state.session, state.view.wide
        E_true = None if state.landscape is None else state.landscape.E_true
        width = CARD_WIDTH if wide else TAB_WIDTH
        drawn = draw_curves(
            session.history,
            session.cursor,
            E_true,
            session.scene.moving_joints,
            width,
            state.errors_deg,
            self._address,
        )
        put_html(self._card if wide else self._tab, f'<div class="vi-card">{drawn}</div>' if wide else drawn)
        put_visible(self._card, wide)
