"""E over the postures and the learner's path in it; or all transfers' landscapes. A posture is touched there."""

from functools import partial

from viser import Icon

from viewimit.drawing.glossary import ask
from viewimit.simulation.scene import Scene

from ..commands.display import FromStarts, Switch, ToggleComparison
from ..drawing.glossary import asks
from ..drawing.overlays import draw_see_through, posture_links
from ..model.state import PageState
from .panel import SLOW, Layout, Panel
from .widgets import put, put_html, put_label, put_visible

COMPARE, ALONE = (
    ("Compare all transfers", Icon.LAYOUT_GRID),
    ("This transfer alone", Icon.SQUARE),
)  # what the button does
WORDS = asks(("bias", "basin"))  # in the lines under all transfers' landscapes
FROM_STARTS, CANCEL, HIDE = (
    ("From these starts", Icon.CHART_DOTS),
    ("Cancel", Icon.PLAYER_STOP),
    ("Hide the starts", Icon.EYE_OFF),
)
STARTS = "twenty learners, at most 300 motions each: where they end, within 2°, and whether they claim to have arrived"
WAITING = '<div class="vi-basin">twenty learners set out …</div>'
LOOK_ONLY = "a posture that is clicked is shown by a see-through arm, and nothing moves; else the learner starts there"


class LandscapePanel(Panel):
    inside = "Landscape"

    def build(self, layout: Layout, state: PageState) -> None:
        gui = layout.gui
        with layout.tab(self.inside):
            self._landscape, self._path = gui.add_html(""), gui.add_html("")
            self._see_through, self._links = gui.add_html(""), gui.add_html("")
            self._cost = gui.add_html(f'<div class="vi-corner">{ask("cost")}</div>')
            self._basin, self._transfers = gui.add_html(""), gui.add_html("", visible=False)
            self._words = gui.add_html(WORDS, visible=False)
            with gui.add_folder(None):
                gui.add_html('<span class="vi-row vi-quiet"></span>')
                self._compare = gui.add_button(COMPARE[0], icon=COMPARE[1])
                self._starts = gui.add_button(FROM_STARTS[0], icon=FROM_STARTS[1], hint=STARTS)
                self._look_only = gui.add_checkbox("Look only", False, hint=LOOK_ONLY)
        layout.queue.on_click(self._compare, ToggleComparison())
        layout.queue.on_click(self._starts, FromStarts())
        layout.queue.on_value(self._look_only, partial(Switch.parse, "look_only"))
        self._here: tuple = ()  # what lies under the path
        self._linked: Scene | None = None  # whose postures are links

    def period(self, state: PageState) -> float:
        """The marker that moves along the path is drawn as often as the arm in the images, and a landscape that has
        come at once; else the path as often as the other plots."""
        here = state.landscape, state.transfers
        return 0.0 if state.on_its_way is not None or here != self._here else SLOW

    def depends_on(self, state: PageState) -> tuple:
        seen = state.present.theta if state.on_its_way is None else state.on_its_way
        looks = state.see_through, state.view.look_only, state.basin, state.refusals
        return state.present, seen.tobytes(), state.last, state.landscape, state.transfers, *looks

    def show(self, state: PageState) -> None:
        self._here = state.landscape, state.transfers
        if state.landscape is not None:
            picture, session = state.landscape.picture, state.session
            put_html(self._landscape, picture.html)
            put_html(self._path, picture.draw_path(session.history, session.cursor, state.on_its_way))
        scene, moment = state.session.scene, state.see_through
        put_html(self._see_through, "" if moment is None else draw_see_through(scene, moment))
        if scene is not self._linked:
            self._linked = scene
            put_html(self._links, posture_links(scene))
        put(self._look_only, state.view.look_only)
        alone = state.transfers is None
        put_html(self._transfers, state.transfers or "")
        put_visible(self._landscape, alone)
        run = state.basin
        put_html(self._basin, "" if run is None else run.figure or WAITING)
        put_label(self._starts, *(FROM_STARTS if run is None else CANCEL if run.goes_on else HIDE))
        for over in (self._path, self._see_through, self._links, self._cost, self._basin):
            put_visible(over, alone)
        put_visible(self._transfers, not alone)
        put_visible(self._words, not alone)
        put_label(self._compare, *(COMPARE if alone else ALONE))
