"""E over the postures and the learner's path in it; or all transfers' landscapes."""

from viser import Icon

from viewimit.drawing.glossary import ask, asks

from ..control.commands.display import ToggleComparison
from ..control.state import PageState
from .panel import SLOW, Layout, Panel
from .widgets import put_html, put_label, put_visible

COMPARE, ALONE = (
    ("Compare all transfers", Icon.LAYOUT_GRID),
    ("This transfer alone", Icon.SQUARE),
)  # what the button does
WORDS = asks(("bias", "basin"))  # in the lines under all transfers' landscapes


class LandscapePanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        gui = layout.gui
        with layout.tab("Landscape"):
            self._landscape, self._path = gui.add_html(""), gui.add_html("")
            self._cost = gui.add_html(f'<div class="vi-corner">{ask("cost")}</div>')
            self._transfers, self._words = gui.add_html("", visible=False), gui.add_html(WORDS, visible=False)
            with gui.add_folder(None):
                gui.add_html('<span class="vi-row vi-quiet"></span>')
                self._compare = gui.add_button(COMPARE[0], icon=COMPARE[1])
        layout.queue.on_click(self._compare, ToggleComparison())
        self._here: tuple = ()  # what lies under the path

    def period(self, state: PageState) -> float:
        """The marker that moves along the path is drawn as often as the arm in the images, and a landscape that has
        come at once; else the path as often as the other plots."""
        here = state.landscape, state.transfers
        return 0.0 if state.on_its_way is not None or here != self._here else SLOW

    def depends_on(self, state: PageState) -> tuple:
        seen = state.present.theta if state.on_its_way is None else state.on_its_way
        return state.present, seen.tobytes(), state.last, state.landscape, state.transfers

    def show(self, state: PageState) -> None:
        self._here = state.landscape, state.transfers
        if state.landscape is not None:
            picture, session = state.landscape.picture, state.session
            put_html(self._landscape, picture.html)
            put_html(self._path, picture.draw_path(session.history, session.cursor, state.on_its_way))
        alone = state.transfers is None
        put_html(self._transfers, state.transfers or "")
        put_visible(self._landscape, alone)
        put_visible(self._path, alone)
        put_visible(self._cost, alone)
        put_visible(self._transfers, not alone)
        put_visible(self._words, not alone)
        put_label(self._compare, *(COMPARE if alone else ALONE))
