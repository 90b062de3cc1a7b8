"""The four images."""

from viewimit.drawing.images import draw_images
from viewimit.drawing.over.points import point_links, point_places

from ..control.state import PageState
from .panel import Layout, Panel
from .widgets import put_html


class ImagesPanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        self._address = layout.address
        with layout.upper_tab("Images"):
            self._images, self._links = layout.gui.add_html(""), layout.gui.add_html("")

    @property
    def html(self) -> str:
        """As it is shown."""
        return self._images.content

    def depends_on(self, state: PageState) -> tuple:
        view = state.view
        return state.generation, state.looked, view.chosen, view.whole_frames, view.wide, *state.pictures.values()

    def show(self, state: PageState) -> None:
        view, (bodies, windows) = state.view, state.arms_in_images
        drawn = draw_images(
            state.looked,
            bodies,
            windows,
            view.chosen,
            view.whole_frames,
            wide=view.wide,
            pictures=state.pictures,
            standing=None if state.see_through is None else state.look_at(state.present)[0],
        )
        if self._address is not None:
            views = state.looked.views
            put_html(self._links, point_links(self._address, len(views.demo), view.whole_frames))
            drawn += point_places(views.demo, views.own, views.visible, windows, view.whole_frames)
        put_html(self._images, drawn)
