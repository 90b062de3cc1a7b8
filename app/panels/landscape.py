"""E over the postures and the learner's path in it; or all transfers' landscapes. A posture is touched there."""

from functools import partial

from viser import Icon

from viewimit.drawing.glossary import ask

from ..drawing.glossary import asks
from ..drawing.overlays import draw_see_through, posture_links
from ..model.page_model import PageModel
from .panel import SLOW, Layout, put_html, put_visible

COMPARE, ALONE = ("Compare all transfers", Icon.LAYOUT_GRID), ("This transfer alone", Icon.SQUARE)
WORDS = asks(("bias", "basin"))  # in the lines under all transfers' landscapes
FROM_STARTS = "From these starts", Icon.CHART_DOTS
CANCEL, HIDE = ("Cancel", Icon.PLAYER_STOP), ("Hide the starts", Icon.EYE_OFF)
STARTS = "twenty learners, at most 300 motions each: where they end, within 2°, and whether they claim to have arrived"
WAITING = '<div class="vi-basin">twenty learners set out …</div>'
LOOK_ONLY = "a posture that is clicked is shown by a see-through arm, and nothing moves; else the learner starts there"


def landscape(layout: Layout, model: PageModel) -> None:
    gui = layout.gui
    alone = lambda model: model.comparison.html is None
    with layout.tab("Landscape"):
        ground, path = gui.add_html(""), gui.add_html("")
        preview, links = gui.add_html(""), gui.add_html("")
        cost = gui.add_html(f'<div class="vi-corner">{ask("cost")}</div>')
        basin = layout.html(_draw_basin)
        layout.html(lambda model: model.comparison.html or "", visible=lambda model: not alone(model))
        layout.html(WORDS, visible=lambda model: not alone(model))
        with layout.row(quiet=True):
            layout.button(lambda model: COMPARE if alone(model) else ALONE, "compare")
            layout.button(_starts_look, "starts", hint=STARTS)
            layout.checkbox("Look only", lambda model: model.view.look_only, "switch", "look_only", hint=LOOK_ONLY)
        for over in (ground, path, preview, links, cost, basin):
            layout.bind(alone, partial(put_visible, over))
        drawn: list = [None]  # the landscape that lies under the path

        def key(model: PageModel) -> tuple:
            on_its_way = model.displayed.interpolated_theta
            theta = model.snapshot.theta if on_its_way is None else on_its_way
            return model.landscape.made, model.snapshot, theta.tobytes()

        def draw(model: PageModel) -> None:
            made, session = model.landscape.made, model.session
            drawn[0] = made
            if made is not None:
                put_html(ground, made.picture.html)
                on_its_way = model.displayed.interpolated_theta
                put_html(path, made.picture.draw_path(session.history, session.cursor, on_its_way))

        def period(model: PageModel) -> float:
            """The marker on the path is drawn as often as the arm in the images, and a landscape that has come at once;
            else the path as often as the other plots."""
            at_once = model.displayed.interpolated_theta is not None or model.landscape.made is not drawn[0]
            return 0.0 if at_once else SLOW

        def draw_preview(model: PageModel) -> None:
            moment = model.displayed.preview
            put_html(preview, "" if moment is None else draw_see_through(model.session.scene, moment))

        layout.drawing(key, draw, period)
        layout.drawing(lambda model: (model.displayed.preview, model.generation), draw_preview)
        layout.drawing(
            lambda model: (model.generation,), lambda model: put_html(links, posture_links(model.session.scene))
        )


def _draw_basin(model: PageModel) -> str:
    run = model.basins.run
    return "" if run is None else run.figure or WAITING


def _starts_look(model: PageModel) -> tuple:
    run = model.basins.run
    return FROM_STARTS if run is None or model.comparison.on else CANCEL if run.goes_on else HIDE
