"""The documentation's blocks add a command, a panel and a preset to a page."""

import re
from pathlib import Path

import pytest
from quiet_page import QuietPage
from viewimit.app.commands import COMMANDS
from viewimit.app.model import choices
from viewimit.app.panels import PANELS

PAGE = Path(__file__).parent.parent.parent / "docs/how-to/page.md"


@pytest.fixture
def extended(monkeypatch):
    """A page with what the blocks add."""
    monkeypatch.setattr(choices, "PRESETS", choices.PRESETS)
    before, panels = dict(COMMANDS), list(PANELS)
    for block in re.findall(r"```python\n(.*?)```", PAGE.read_text("utf-8"), re.S):
        exec(compile(block, str(PAGE), "exec"), {})
    yield QuietPage()
    COMMANDS.clear(), COMMANDS.update(before)
    PANELS[:] = panels


def test_the_blocks_of_the_documentation_add_a_command_a_panel_and_a_preset(extended):
    extended.tick(1.0)
    extended.click("Last point")
    extended.tick(1.0)
    last = len(extended.page.model.session.world.body) - 1
    assert extended.page.model.view.chosen == last and f"Point {last} is chosen." in extended.shown
    extended.choose("Preset", "Three pixels")
    extended.tick(1.0)
    assert extended.page.model.settings.noise_px == 3.0 and "how well can it tell?" in extended.shown
