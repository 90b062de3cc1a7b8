"""E and the joint errors, motion by motion; and the paper's equations with their present numbers."""

from viewimit.drawing.curves import axis_end, draw_curves
from viewimit.drawing.equations import draw_equations

from ..drawing.glossary import asks
from ..drawing.overlays import hide_later_motions, motion_links
from ..model.page_model import PageModel
from .panel import SLOW, SLOWEST, Layout, put_html, put_visible

CARD_WIDTH, TAB_WIDTH = 860, 424  # px


def curves(layout: Layout, model: PageModel) -> None:
    """A card over a wide window's scene, or a tab. Each motion is touched there."""
    gui = layout.gui
    card, over_card = gui.add_html("", visible=False), gui.add_html("", visible=False)
    with layout.tab("Curves"):
        tab, over_tab = gui.add_html(""), gui.add_html("")

        def key(model: PageModel) -> tuple:
            return model.snapshot, model.player.cursor, model.player.last, model.landscape.made, model.view.wide

        def draw(model: PageModel) -> None:
            session, wide, made = model.session, model.view.wide, model.landscape.made
            E_true, width = None if made is None else made.E_true, CARD_WIDTH if wide else TAB_WIDTH
            joints, errors = session.scene.moving_joints, model.displayed.errors_deg
            drawn = draw_curves(session.history, session.cursor, E_true, joints, width, errors)
            drawn += hide_later_motions(len(session.history) - 1)
            put_html(card if wide else tab, f'<div class="vi-card">{drawn}</div>' if wide else drawn)
            for handle in (card, over_card):
                put_visible(handle, wide)

        def draw_links(model: PageModel) -> None:
            """Made anew only when they change."""
            end, wide = links_key(model)
            links = motion_links(end, CARD_WIDTH if wide else TAB_WIDTH)
            put_html(over_card, f'<div class="vi-card-over">{links}</div>' if wide else "")
            put_html(over_tab, "" if wide else f'<div class="vi-over">{links}</div>')

        def links_key(model: PageModel) -> tuple:
            return axis_end(len(model.session.history) - 1), model.view.wide

        seen = lambda model: model.view.wide or card.visible  # the card is, wherever it stands still
        layout.drawing(key, draw, SLOW, seen)
        layout.drawing(links_key, draw_links, SLOW, seen)


def equations(layout: Layout, model: PageModel) -> None:
    with layout.tab("Equations"):
        shown = layout.gui.add_html("")
        layout.gui.add_html(asks(("lambda", "rho", "D")))
        layout.drawing(
            lambda model: (model.displayed.snapshot, model.view.chosen),
            lambda model: put_html(shown, draw_equations(model.displayed.snapshot, model.view.chosen)),
            period=SLOWEST,
        )
