"""What is large, and the links that make it so, in every tab of the upper panel: a browser has only the open one's."""

from viser import GuiHtmlHandle

from ..drawing.overlays import LESS, MORE, link
from ..model.state import LARGE, PageState
from .panel import Layout, Panel
from .widgets import put_html


class LargerPanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        self._links: list[GuiHtmlHandle] = []
        for tab in layout.upper_tabs:
            with tab:
                self._links.append(layout.gui.add_html(""))

    def depends_on(self, state: PageState) -> tuple:
        return (state.view.large,)

    def show(self, state: PageState) -> None:
        for html in self._links:
            put_html(html, _large(state.view.large))


def _large(large: str | None) -> str:
    """Links that enlarge the panels, and which of them or of the images is large: layout.css does it."""
    icon = f'<svg viewBox="-6 -6 12 12" aria-hidden="true"><path d="{LESS if large else MORE}"/></svg>'
    links = "".join(
        f'<div class="vi-enlarge vi-enlarge-{what}">{link(f"large/{LARGE.index(shown)}", name, icon)}</div>'
        for what, shown, name in (
            ("images", large if large not in (None, "figures") else "images", "Images, large or not"),
            ("figures", "figures", "Figures, large or not"),
        )
    )
    mark = f'<i class="vi-large vi-large-{large}"></i>' if large else ""
    return f'<div class="vi-larger-links">{links}</div>{mark}'
