"""The glossary's cards, unseen until a "?" opens one, and what its numbers are now."""

import numpy as np

from viewimit.drawing.images.panel import residual_lengths

from ...drawing.glossary import current_values, linked_cards
from ...model.state import PageState
from ..panel import SLOWEST, Layout, Panel
from ..widgets import put_html


class GlossaryPanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        layout.gui.add_html(f'<div class="vi-words">{linked_cards()}</div>')
        self._now = layout.gui.add_html("")

    def period(self, state: PageState) -> float:
        return SLOWEST

    def depends_on(self, state: PageState) -> tuple:
        return state.present, state.word

    def show(self, state: PageState) -> None:
        """Which card is open is the browser's own matter."""
        put_html(self._now, current_values(numbers_now(state), state.word))


def numbers_now(state: PageState) -> dict[str, float]:
    """By their keys in the glossary, in the units of their scales; NaN where there is none."""
    moment = state.present
    lengths = residual_lengths(moment)
    known = moment.transfer is not None
    mean = float(lengths.mean()) if known else np.nan
    return {
        "E": moment.E,
        "mean_e": mean,
        "largest_e": float(lengths.max()) / mean if known and mean > 0 else np.nan,
        "condition": float(moment.transfer.condition) if moment.transfer is not None else np.nan,
        "flatness": moment.flatness,
        "points_seen": float(moment.usable.sum()),
        "truth": state.errors_deg[-1],
    }
