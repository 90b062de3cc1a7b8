"""The glossary's cards, unseen until a "?" opens one."""

from viewimit.drawing.glossary import cards

from ..control.state import PageState
from .panel import Layout, Panel


class GlossaryPanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        layout.gui.add_html(f'<div class="vi-words">{cards()}</div>')

    def depends_on(self, state: PageState) -> tuple:
        return ()

    def show(self, state: PageState) -> None:
        """Which one is open is the browser's own matter."""
