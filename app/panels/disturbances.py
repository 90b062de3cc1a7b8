"""What makes it harder: sliders, the less frequent ones folded."""

from functools import partial

from viewimit.drawing.glossary import key_of
from viewimit.loop.settings import MAX_SEED, Settings

from ..commands.method import change_disturbance, change_seed
from ..drawing.glossary import beside
from ..model.choices import OF_ARMS, OF_IMAGES, Amount
from ..model.state import PageState
from .panel import Layout, Panel
from .widgets import put


class DisturbancesPanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        gui, settings = layout.gui, state.settings
        self._sliders: list[tuple] = []
        with gui.add_folder("Disturbances"):
            for amount in OF_IMAGES:
                self._add(layout, amount, settings)
            with gui.add_folder("Arm and chance", expand_by_default=False):
                for amount in OF_ARMS:
                    self._add(layout, amount, settings)
                self._seed = gui.add_number("Seed", settings.seed, min=0, max=MAX_SEED, step=1)
                layout.queue.on_value(self._seed, change_seed)

    def depends_on(self, state: PageState) -> tuple:
        return state.generation, state.settings, state.refusals

    def show(self, state: PageState) -> None:
        for slider, amount in self._sliders:
            put(slider, amount.shown(state.settings))
        put(self._seed, state.settings.seed)

    def _add(self, layout: Layout, amount: Amount, settings: Settings) -> None:
        """It reaches farther if the page is asked to begin there."""
        begun = amount.shown(settings)
        low, high = min(amount.low, begun), max(amount.high, begun)
        if (key := key_of(amount.label)) is not None:
            layout.gui.add_html(beside(key))
        slider = layout.gui.add_slider(amount.label, low, high, amount.step, amount.low, hint=amount.hint)
        layout.queue.on_value(slider, partial(change_disturbance, amount))
        self._sliders.append((slider, amount))
