"""What makes it harder: sliders, the less frequent ones folded."""

from functools import partial

from viewimit.settings import MOST_SEED, Settings

from ..control.commands.method import change_disturbance, change_seed
from ..control.disturbances import DISTURBANCES
from ..control.state import PageState
from .panel import Layout, Panel
from .widgets import put

FOLDED = ("gain_error", "quantum_deg")


class DisturbancesPanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        gui, settings = layout.gui, state.settings
        self._sliders: dict = {}
        with gui.add_folder("Disturbances"):
            for name in DISTURBANCES:
                if name not in FOLDED:
                    self._add(layout, name, settings)
            with gui.add_folder("Arm and chance", expand_by_default=False):
                for name in FOLDED:
                    self._add(layout, name, settings)
                self._seed = gui.add_number("Seed", settings.seed, min=0, max=MOST_SEED, step=1)
                layout.queue.on_value(self._seed, change_seed)

    def depends_on(self, state: PageState) -> tuple:
        return state.settings, state.refusals

    def show(self, state: PageState) -> None:
        for name, slider in self._sliders.items():
            put(slider, DISTURBANCES[name].shown(state.settings))
        put(self._seed, state.settings.seed)

    def _add(self, layout: Layout, name: str, settings: Settings) -> None:
        """It reaches farther if the page is asked to begin there."""
        asked, begun = DISTURBANCES[name], DISTURBANCES[name].shown(settings)
        low, high = min(asked.low, begun), max(asked.high, begun)
        slider = layout.gui.add_slider(asked.label, low, high, asked.step, asked.low, hint=asked.hint)
        layout.queue.on_value(slider, partial(change_disturbance, asked))
        self._sliders[name] = slider
