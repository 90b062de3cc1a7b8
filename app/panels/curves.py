"""E and the joint errors, motion by motion, each of which is touched there: a card over a wide window's scene, or a
tab."""

from viewimit.drawing.curves import axis_end, draw_curves

from ..drawing.overlays import hide_later_motions, motion_links
from ..model.state import PageState
from .panel import SLOW, Layout, Panel
from .widgets import put_html, put_visible

CARD_WIDTH, TAB_WIDTH = 860, 424  # px


class CurvesPanel(Panel):
    inside = "Curves"

    def build(self, layout: Layout, state: PageState) -> None:
        gui = layout.gui
        self._card, self._over_card = gui.add_html("", visible=False), gui.add_html("", visible=False)
        with layout.tab(self.inside):
            self._tab, self._over_tab = gui.add_html(""), gui.add_html("")
        self._linked: tuple[int, bool] | None = None  # what the links were made of

    def seen(self, state: PageState) -> bool:
        """The card is, wherever it stands still."""
        return state.view.wide or self._card.visible or super().seen(state)

    def period(self, state: PageState) -> float:
        return SLOW

    def depends_on(self, state: PageState) -> tuple:
        return state.present, state.cursor, state.last, state.landscape, state.view.wide

    def show(self, state: PageState) -> None:
        session, wide = state.session, state.view.wide
        E_true = None if state.landscape is None else state.landscape.E_true
        width, last = CARD_WIDTH if wide else TAB_WIDTH, len(session.history) - 1
        joints = session.scene.moving_joints
        drawn = draw_curves(session.history, session.cursor, E_true, joints, width, state.errors_deg)
        drawn += hide_later_motions(last)
        self._show_links(axis_end(last), wide)
        put_html(self._card if wide else self._tab, f'<div class="vi-card">{drawn}</div>' if wide else drawn)
        put_visible(self._card, wide)
        put_visible(self._over_card, wide)

    def _show_links(self, end: int, wide: bool) -> None:
        """Made anew only when they change. end: motions at the end of the axis."""
        if (end, wide) == self._linked:
            return
        self._linked = end, wide
        links = motion_links(end, CARD_WIDTH if wide else TAB_WIDTH)
        put_html(self._over_card, f'<div class="vi-card-over">{links}</div>' if wide else "")
        put_html(self._over_tab, "" if wide else f'<div class="vi-over">{links}</div>')
