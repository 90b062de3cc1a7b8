"""The tab Duel: the opponent's method, both paths, standings."""

from viser import Icon

from ..commands.tools import ChooseOpponent, ToggleDuel
from ..drawing import duel as drawing
from ..model.choices import servo_names, transfer_names
from ..model.state import PageState
from .panel import Layout, Panel
from .widgets import put, put_html, put_label


class DuelPanel(Panel):
    """In a wide window with room for the errors beneath the paths."""

    inside = "Duel"

    def build(self, layout: Layout, state: PageState) -> None:
        gui, queue = layout.gui, layout.queue
        transfers, servos = transfer_names(), servo_names()
        with layout.tab(self.inside):
            with gui.add_folder(None):
                gui.add_html('<span class="vi-row"></span>')
                self._transfer = gui.add_dropdown(
                    "Opponent's transfer", list(transfers.values()), initial_value=transfers[state.duel.transfer]
                )
                self._servo = gui.add_dropdown(
                    "Opponent's servo", list(servos.values()), initial_value=servos[state.duel.servo]
                )
                self._switch = gui.add_button("Begin duel", icon=Icon.SWORDS)
            self._ground, self._race = gui.add_html(drawing.draw_empty()), gui.add_html("")
            self._errors = gui.add_html("")
        queue.on_value(self._transfer, ChooseOpponent.transfer)
        queue.on_value(self._servo, ChooseOpponent.servo)
        queue.on_click(self._switch, ToggleDuel())

    def depends_on(self, state: PageState) -> tuple:
        duel = state.duel
        present = None if duel.opponent is None else (state.present, duel.opponent.snapshot)
        return *(present or (None, None)), duel.transfer, duel.servo, state.ground, state.view.wide, state.refusals

    def show(self, state: PageState) -> None:
        duel, opponent = state.duel, state.duel.opponent
        put(self._transfer, transfer_names()[duel.transfer])
        put(self._servo, servo_names()[duel.servo])
        put_label(self._switch, *(("End duel", Icon.PLAYER_STOP) if opponent else ("Begin duel", Icon.SWORDS)))
        put_html(self._ground, state.ground)
        race = errors = ""
        if opponent is not None:
            standings, scene = duel.standings, state.session.scene
            race = drawing.draw_race(scene, (state.session, opponent), standings)
            if state.view.wide and len(scene.moving_joints) == 2:
                errors = drawing.draw_errors_alone(standings)
        put_html(self._race, race)
        put_html(self._errors, errors)
