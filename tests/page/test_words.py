"""All that the page writes: real minus signs, how many motions there are, a tab for motions."""

import re

import pytest
from quiet_page import QuietPage
from viewimit.app.model.choices import PRESETS
from viewimit.app.model.motions import NAMES

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


def test_history_shows_which_of_how_many():
    page = QuietPage(Settings())
    page.tick(1.0)
    assert "0 of 0" in page.shown
    page.click("Play")
    page.tick_until(lambda: page.page.model.session.snapshot.status == "converged")
    last = page.page.model.session.cursor
    page.tick(1.0)
    assert f"{last} of {last}" in page.shown
    page.choose("History", 2)
    page.tick(1.0)
    assert f"2 of {last}" in page.shown


def test_a_motions_time_is_in_seconds():
    page = QuietPage(Settings())
    slider = page.widget("Time (s)")
    page.tick(1.0)
    assert (slider.min, slider.max, slider.step) == (0, 5.95, 0.05)
    assert page.widget("Chosen motion").options == tuple(NAMES.values())
    before = page.page.model.session.snapshot.theta_demo
    page.choose("Time (s)", 1.5)
    page.tick_until(lambda: (page.page.model.session.snapshot.theta_demo != before).any())
    assert page.page.model.motions.moment == (1.5, 5.95)
    page.tick(1.0)
    assert slider.value == 1.5
