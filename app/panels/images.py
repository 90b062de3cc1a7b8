"""The four images."""

from viewimit.drawing.images.rectified import draw_rectified

from ..drawing.overlays import point_links, point_places, proposed_marks
from ..model.images import draw_shown
from ..model.state import PageState, View
from .panel import Layout, Panel
from .widgets import put_html


class ImagesPanel(Panel):
    inside = "Images"

    def build(self, layout: Layout, state: PageState) -> None:
        with layout.upper_tab(self.inside):
            self._images, self._links = layout.gui.add_html(""), layout.gui.add_html("")
            self._proposed = layout.gui.add_html("")
        self._linked: tuple | None = None  # what the links were made of

    @property
    def html(self) -> str:
        """As it is shown."""
        return self._images.content

    def depends_on(self, state: PageState) -> tuple:
        view = state.view
        shown = view.goal, view.truth, view.chosen, view.whole_frames, view.rectified, state.stage
        return state.generation, state.looked, state.points, *shown, *state.pictures.values()

    def show(self, state: PageState) -> None:
        view, (bodies, windows) = state.view, state.arms_in_images
        if view.rectified:
            put_html(self._images, draw_rectified(state.looked, bodies))
            self._show_links(None, view)
            put_html(self._proposed, "")
            return
        marks = state.points.proposed_in
        put_html(self._proposed, "" if marks is None else proposed_marks(marks, windows, view.whole_frames))
        standing = None if state.see_through is None else state.look_at(state.present)[0]
        drawn = draw_shown(state, state.stage, standing)
        views = state.looked.views
        self._show_links(len(views.demo), view)
        drawn += point_places(views.demo, views.own, views.visible, windows, view.whole_frames)
        put_html(self._images, drawn)

    def _show_links(self, points: int | None, view: View) -> None:
        """Made anew only when they change. points: how many there are; None: none that can be chosen."""
        of = points, view.whole_frames
        if of == self._linked:
            return
        self._linked = of
        put_html(self._links, "" if points is None else point_links(points, view.whole_frames))
