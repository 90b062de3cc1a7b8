"""The tab Duel: the opponent's method, both paths, standings."""

from viser import Icon

from viewimit.estimation.transfers import TRANSFERS
from viewimit.language import _
from viewimit.servo import SERVOS

from ..drawing import duel as drawing
from ..model.choices import servo_names, transfer_names
from ..model.page_model import PageModel
from .panel import Layout, put_html

BEGIN, END = (_("Begin duel"), Icon.SWORDS), (_("End duel"), Icon.PLAYER_STOP)


def duel(layout: Layout, model: PageModel) -> None:
    transfers, servos = list(transfer_names().values()), list(servo_names().values())
    with layout.tab(_("Duel")):
        with layout.row():
            layout.dropdown(
                _("Opponent's transfer"),
                transfers,
                lambda model: TRANSFERS[model.duel.transfer].title,
                "opponent_transfer",
            )
            layout.dropdown(
                _("Opponent's servo"), servos, lambda model: SERVOS[model.duel.servo].title, "opponent_servo"
            )
            layout.button(lambda model: BEGIN if model.duel.opponent is None else END, "duel")
        layout.html(lambda model: model.duel_landscapes.html)
        race, errors = layout.gui.add_html(""), layout.gui.add_html("")

        def key(model: PageModel) -> tuple:
            opponent = model.duel.opponent
            both = (None, None) if opponent is None else (model.snapshot, opponent.snapshot)
            return *both, model.player.playing

        def draw(model: PageModel) -> None:
            opponent, scene = model.duel.opponent, model.session.scene
            paths = plot = ""
            if opponent is not None:
                standings = model.duel.standings
                paths = drawing.draw_race(scene, (model.session, opponent), standings, model.player.playing)
                if len(scene.moving_joints) == 2:
                    plot = drawing.draw_errors_alone(standings)
            put_html(race, paths)
            put_html(errors, plot)

        layout.drawing(key, draw)
