"""The folder in which body points are edited: begin and end, remove, propose, save, and what the points tell."""

from viser import Icon

from ..drawing.joint_bars import draw_body_points
from ..model.page_model import PageModel
from .panel import Layout, put_html

EDIT, DONE = ("Edit points", Icon.POINT), ("Done", Icon.CHECK)
PROPOSE, TAKE = ("Best next", Icon.BULB), ("Take it", Icon.BULB)
ABOUT = "Mark both arms yourself: click an arm to place a point, or a point to choose it."


def points(layout: Layout, model: PageModel) -> None:
    with layout.folder("Points", lambda model: str(len(model.session.world.body))), layout.row(quiet=True):
        layout.button(lambda model: DONE if model.points.on else EDIT, "edit_points", hint="on both arms, by clicks; E")
        layout.button(("Save scene", Icon.DOWNLOAD), "scene", hint="as a file for viewimit imitate --scene")
        layout.button(
            lambda model: PROPOSE if model.points.proposal is None else TAKE,
            "best",
            hint="the point that would tell most; B",
            enabled=lambda model: model.points.shown.on and not model.points.shown.searching,
        )
        layout.button(
            ("Remove", Icon.TRASH),
            "remove",
            hint="the chosen point; Delete",
            enabled=lambda model: model.points.on and model.view.chosen is not None,
        )
        told = layout.gui.add_html("")

    def draw(model: PageModel) -> None:
        points, joints = model.points.shown, model.session.scene.moving_joints
        content = ABOUT
        if points.information is not None:
            content = draw_body_points(joints, points.information, points.proposal, points.searching)
        put_html(told, f'<div class="vi-edited">{content}</div>')

    layout.drawing(lambda model: (model.points.shown, model.generation), draw)
