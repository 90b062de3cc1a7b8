"""E and the joint errors, motion by motion; and the paper's equations with their present numbers."""

from viewimit.drawing.curves import axis_end, draw_curves
from viewimit.drawing.equations import draw_equations
from viewimit.language import _

from ..drawing.glossary import asks
from ..drawing.overlays import hide_later_motions, motion_links
from ..model.page_model import PageModel
from .panel import SLOW, SLOWEST, Layout, put_html


def curves(layout: Layout, model: PageModel) -> None:
    """Each motion is touched there."""
    with layout.tab(_("Curves")):
        shown, over = layout.gui.add_html(""), layout.gui.add_html("")

        def draw(model: PageModel) -> None:
            session, made = model.session, model.landscape.made
            E_true, joints = None if made is None else made.E_true, session.scene.moving_joints
            drawn = draw_curves(session.history, session.cursor, E_true, joints, errors_deg=model.displayed.errors_deg)
            put_html(shown, drawn + hide_later_motions(len(session.history) - 1))

        def links_key(model: PageModel) -> tuple:
            return (axis_end(len(model.session.history) - 1),)

        def draw_links(model: PageModel) -> None:
            """Made again only when they change."""
            put_html(over, f'<div class="vi-over">{motion_links(*links_key(model))}</div>')

        layout.drawing(lambda model: (model.snapshot, len(model.session.history), model.landscape.made), draw, SLOW)
        layout.drawing(links_key, draw_links, SLOW)


def equations(layout: Layout, model: PageModel) -> None:
    with layout.tab(_("Equations")):
        shown = layout.gui.add_html("")
        layout.gui.add_html(asks(("lambda", "rho", "D")))
        layout.drawing(
            lambda model: (model.displayed.snapshot, model.view.chosen),
            lambda model: put_html(shown, draw_equations(model.displayed.snapshot, model.view.chosen)),
            period=SLOWEST,
        )
