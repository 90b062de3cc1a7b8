"""The four images."""

from functools import partial
from typing import Any

from viewimit.drawing.images.rectified import draw_rectified

from ..drawing.overlays import point_links, point_places, proposed_marks
from ..model.page_model import PageModel
from .panel import Layout, put_html


def images(layout: Layout, model: PageModel) -> None:
    with layout.upper_tab("Images"):
        shown, links, proposed = (layout.gui.add_html("") for k in range(3))
        layout.named["images"] = shown
        layout.drawing(_key, partial(_draw, shown, proposed))
        layout.drawing(_links_key, partial(_draw_links, links))


def _key(model: PageModel) -> tuple:
    view, displayed = model.view, model.displayed
    switches = view.goal, view.truth, view.chosen, view.whole_frames, view.rectified, displayed.stage
    snapshots = displayed.image_snapshot, displayed.preview
    return model.generation, *snapshots, model.points.shown, *switches, *displayed.pictures.values()


def _draw(shown: Any, proposed: Any, model: PageModel) -> None:
    view, displayed = model.view, model.displayed
    (bodies, windows), now = displayed.arms_in_images, displayed.image_snapshot
    if view.rectified:
        put_html(shown, draw_rectified(now, bodies))
        put_html(proposed, "")
        return
    marks = model.points.shown.proposed_in
    put_html(proposed, "" if marks is None else proposed_marks(marks, windows, view.whole_frames))
    standing = None if displayed.preview is None else displayed.look_at(model.snapshot)[0]
    seen = now.views
    places = point_places(seen.demo, seen.own, seen.visible, windows, view.whole_frames)
    put_html(shown, displayed.draw_images(displayed.stage, standing) + places)


def _links_key(model: PageModel) -> tuple:
    points = len(model.displayed.image_snapshot.views.demo)
    return None if model.view.rectified else points, model.view.whole_frames


def _draw_links(links: Any, model: PageModel) -> None:
    """Draw the links again only when they change: a click on one is not lost while the arm moves."""
    points, whole_frames = _links_key(model)
    put_html(links, "" if points is None else point_links(points, whole_frames))
