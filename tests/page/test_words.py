"""All that the page writes: real minus signs, how many motions there are, a tab for motions."""

import re

import pytest
from quiet_page import QuietPage
from viewimit.app.model.choices import PRESETS

from viewimit.estimation.equations import with_minus
from viewimit.loop.settings import Settings

HYPHEN = re.compile(r"(?<![\w)\]])-[\d.]")


def written(page):
    """What every widget shows: its label, its hint, its choices, the words of its HTML."""
    for widget in page.gui.widgets:
        fields = vars(widget)
        html = re.sub(r"<style>.*?</style>|<[^>]*>", " ", fields.get("content", ""), flags=re.DOTALL)
        yield from (fields.get("label") or "", fields.get("hint") or "", html)
        yield from map(str, fields.get("options", ()))


def hyphens(page):
    return [words for words in written(page) if HYPHEN.search(words)]


@pytest.mark.parametrize("preset", [p for p in PRESETS if p.settings.sensor == "projected"], ids=lambda p: p.name)
def test_every_number_has_a_real_minus(preset):
    page = QuietPage(Settings())
    page.choose("Preset", preset.name)
    page.click("Begin duel")
    page.click("Compare all transfers")
    for _ in range(4):
        page.page.queue.call("step")
        page.tick(1.0)
    page.choose("Experiment", "Fig. 9: posture imitation")
    assert any("−" in words for words in written(page)) and not hyphens(page)


def test_messages_have_it_too():
    page = QuietPage(Settings.paper())
    page.page.model.say("joint 4 at -200° is outside its limits -180° … 0°, see run-5 of 2026-01-02", 1e9)
    page.tick(1.0)
    assert "joint 4 at −200° is outside its limits −180° … 0°, see run-5 of 2026-01-02" in page.shown
    assert with_minus("(-1.5, -.5) [-2]") == "(−1.5, −.5) [−2]"
