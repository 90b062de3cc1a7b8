"""The folder in which body points are edited: begin and end, remove, propose, save, and what the points tell."""

from viser import Icon

from ...commands.tools import BestNext, EditPoints, RemovePoint, SaveScene
from ...drawing.joint_bars import draw_body_points
from ...model.state import PageState
from ..panel import Layout, Panel
from ..widgets import put_html, put_label

EDIT, DONE = ("Edit points", Icon.POINT), ("Done", Icon.CHECK)
PROPOSE, TAKE = ("Best next", Icon.BULB), ("Take it", Icon.BULB)
ABOUT = "Mark both arms yourself: click an arm to place a point, or a point to choose it."


class PointsPanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        gui, queue = layout.gui, layout.queue
        with gui.add_folder("Points", expand_by_default=False):
            with gui.add_folder(None):
                gui.add_html('<span class="vi-row vi-quiet"></span>')
                self._edit = gui.add_button(EDIT[0], icon=EDIT[1], hint="on both arms, by clicks; E")
                save = gui.add_button("Save scene", icon=Icon.DOWNLOAD, hint="as a file for viewimit imitate --scene")
                self._best = gui.add_button(PROPOSE[0], icon=PROPOSE[1], hint="the point that would tell most; B")
                self._remove = gui.add_button("Remove", icon=Icon.TRASH, hint="the chosen point; Delete")
                self._told = gui.add_html("")
        for button, command in (
            (self._edit, EditPoints()),
            (save, SaveScene()),
            (self._best, BestNext()),
            (self._remove, RemovePoint()),
        ):
            queue.on_click(button, command)

    def depends_on(self, state: PageState) -> tuple:
        return state.points, state.view.chosen, state.generation

    def show(self, state: PageState) -> None:
        points, joints = state.points, state.session.scene.moving_joints
        put_label(self._edit, *(DONE if points.on else EDIT))
        put_label(self._best, *(PROPOSE if points.proposal is None else TAKE))
        for button, possible in (
            (self._best, points.on and not points.searching),
            (self._remove, points.on and state.view.chosen is not None),
        ):
            if button.disabled == possible:
                button.disabled = not possible
        told = ABOUT
        if points.information is not None:
            told = draw_body_points(joints, points.information, points.proposal, points.searching)
        put_html(self._told, f'<div class="vi-edited">{told}</div>')
