"""How often what has changed is drawn."""

import numpy as np
import pytest
from quiet_page import QuietPage
from viewimit.app.model.page_model import EARLY, Redraw

from viewimit.loop.settings import Settings

PERIOD = 0.1


@pytest.mark.parametrize("jitter", [0.0, 0.02, 0.045])
def test_what_is_asked_late_keeps_its_pace(jitter):
    redraw, rng = Redraw(), np.random.default_rng(2)
    ticks = [0.05 * k + jitter * rng.random() for k in range(2000)]  # each so many s late
    done = sum(redraw.due("panels", now, PERIOD) for now in ticks)
    assert 100.0 / PERIOD - 1 <= done <= 100.0 / (EARLY * PERIOD)


def test_motions_at_the_pace_of_drawings_are_nearly_all_drawn_though_ticks_jitter():
    page = QuietPage(Settings.paper(servo="gradient-retuned", start_deg=(25.0, -45.0)))
    player, panel, rng = page.page.model.player, page.page.layout.named["images"], np.random.default_rng(4)
    player.speed = 1 / PERIOD
    player.toggle()
    drawn = 0
    for _ in range(1000):
        html = panel.content
        page.tick(rng.uniform(0.04, 0.06))
        drawn += panel.content != html
    assert player.cursor == pytest.approx(500, abs=20) and drawn >= 0.95 * player.cursor
