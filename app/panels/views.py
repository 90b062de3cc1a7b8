"""How much there is room for, which the browser says by CSS pixels: widths of the panels, and the tabs of a window that
is too small for all at once. layout.css shows the one that is chosen, without the server."""

from ..model.state import PageState
from .panel import Layout, Panel

ICONS = {  # 24 x 24, strokes
    "images": '<path d="M4 4h6v16H4zM14 4h6v16h-6z"/>',
    "landscape": '<ellipse cx="12" cy="12" rx="9" ry="8"/><ellipse cx="12" cy="12" rx="4.5" ry="3.5"/>',
    "controls": '<path d="M3 8h12M19 8h2M3 16h2M9 16h12"/><circle cx="17" cy="8" r="2"/><circle cx="7" cy="16" r="2"/>',
    "scene": '<path d="M12 3l8 4.5v9L12 21l-8-4.5v-9zM4 7.5l8 4.5 8-4.5M12 12v9"/>',
}
VIEWS = {"images": "Images", "landscape": "Landscape", "controls": "Controls", "scene": "3-D"}


class ViewsPanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        self._layout, self._room = layout, 0
        tabs = "".join(_tab(name, label, checked=name == "images") for name, label in VIEWS.items())
        layout.gui.add_html(f'<div class="vi-views" role="radiogroup" aria-label="View">{tabs}</div>')

    def depends_on(self, state: PageState) -> tuple:
        return state.view.wide, state.view.vast

    def show(self, state: PageState) -> None:
        room = 2 if state.view.vast else int(state.view.wide)
        if room != self._room:
            self._room = room
            self._layout.widen(room)


def _tab(name: str, label: str, checked: bool) -> str:
    chosen = " checked" if checked else ""
    return (
        f'<input type="radio" name="vi-view" id="vi-view-{name}"{chosen}><label for="vi-view-{name}">'
        f'<svg viewBox="0 0 24 24" aria-hidden="true">{ICONS[name]}</svg>{label}</label>'
    )
