"""The four images."""

from viewimit.drawing.images import draw_images

from ..control.state import PageState
from .panel import Layout, Panel
from .widgets import put_html


class ImagesPanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        self._wide = layout.wide
        with layout.upper_tab("Images"):
            self._images = layout.gui.add_html("")

    @property
    def html(self) -> str:
        """As it is shown."""
        return self._images.content

    def depends_on(self, state: PageState) -> tuple:
        view = state.view
        return state.generation, state.looked, view.chosen, view.whole_frames, *state.pictures.values()

    def show(self, state: PageState) -> None:
        view, (bodies, windows) = state.view, state.arms_in_images
        drawn = draw_images(
            state.looked,
            bodies,
            windows,
            view.chosen,
            view.whole_frames,
            wide=self._wide,
            pictures=state.pictures,
        )
        put_html(self._images, drawn)
