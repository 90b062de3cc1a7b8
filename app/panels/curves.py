"""E and the joint errors, motion by motion: a card over the scene of a wide window, or a tab."""

from contextlib import nullcontext

from viewimit.drawing.curves import draw_curves
from viewimit.drawing.over.links import sink

from ..control.state import PageState
from .panel import SLOW, Layout, Panel
from .widgets import put_html

CARD_WIDTH, TAB_WIDTH = 860, 424  # px


class CurvesPanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        self._wide, self._address = layout.wide, layout.address
        with nullcontext() if layout.wide else layout.tab("Curves"):
            self._curves = layout.gui.add_html("")
            if self._address is not None:
                layout.gui.add_html(sink())

    def period(self, state: PageState) -> float:
        return SLOW

    def depends_on(self, state: PageState) -> tuple:
        return state.present, state.cursor, state.last, state.landscape

    def show(self, state: PageState) -> None:
        session = state.session
        E_true = None if state.landscape is None else state.landscape.E_true
        width = CARD_WIDTH if self._wide else TAB_WIDTH
        drawn = draw_curves(
            session.history,
            session.cursor,
            E_true,
            session.scene.moving_joints,
            width,
            state.errors_deg,
            self._address,
        )
        put_html(self._curves, f'<div class="vi-card">{drawn}</div>' if self._wide else drawn)
