"""The button by which the learner watches itself before it imitates, or forgets what it saw; and what it remembers."""

from viser import Icon

from viewimit.loop.self_calibration import DEFAULT_POSTURES

from ..commands.session import ToggleRehearsal
from ..model.displayed import Rehearsal
from ..model.state import PageState
from .panel import Layout
from .widgets import put_html, put_label

WATCH, STOP, FORGET = ("Watch yourself first", Icon.EYE), ("Stop", Icon.PLAYER_STOP), ("Forget", Icon.ERASER)

HINT = f"the learner goes through {DEFAULT_POSTURES} postures, with nobody to imitate, and needs no probes then"


class RehearsalButton:
    """In the folder that is open as it is made, on a line of its own with the words beneath."""

    def __init__(self, layout: Layout):
        gui = layout.gui
        with gui.add_folder(None):
            gui.add_html('<span class="vi-row vi-quiet"></span>')
            self._button = gui.add_button(WATCH[0], icon=WATCH[1], hint=HINT)
            self._said = gui.add_html("")
        layout.queue.on_click(self._button, ToggleRehearsal())

    def show(self, state: PageState) -> None:
        rehearsal = state.rehearsal
        put_label(self._button, *_does(rehearsal))
        put_html(self._said, f'<div class="vi-remembers">{rehearsal.words}</div>')
        if self._button.disabled == rehearsal.offered:
            self._button.disabled = not rehearsal.offered


def _does(rehearsal: Rehearsal):
    return STOP if rehearsal.to_go else FORGET if rehearsal.held else WATCH
