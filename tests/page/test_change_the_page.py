"""The documentation's blocks add a command, a panel and a preset to a page."""

import re
from pathlib import Path

import numpy as np
import pytest
from quiet_page import QuietPage
from viewimit.app.commands import COMMANDS
from viewimit.app.panels import PANELS
from viewimit.app.panels.guide import KEYS

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs/how-to/page.md"


@pytest.fixture
def extended():
    """A page with what the blocks add."""
    before, panels = dict(COMMANDS), list(PANELS)
    for block in re.findall(r"```python\n(.*?)```", PAGE.read_text("utf-8"), re.S):
        exec(compile(block, str(PAGE), "exec"), {})
    yield QuietPage()
    COMMANDS.clear(), COMMANDS.update(before)
    PANELS[:] = panels


def test_the_blocks_of_the_documentation_add_a_command_and_a_panel(extended):
    extended.tick(1.0)
    extended.click("Last point")
    extended.tick(1.0)
    last = len(extended.page.model.session.world.body) - 1
    assert extended.page.model.view.chosen == last and f"Point {last} is chosen." in extended.shown
    assert "Mean residual: " in extended.shown
    extended.page.queue.call("step")
    extended.tick(1.0)
    extended.page.queue.call("demonstrator_to_learner")
    extended.tick(1.0)
    snapshot = extended.page.model.snapshot
    assert np.allclose(snapshot.theta, snapshot.theta_demo) and snapshot.theta.any()


def test_no_two_keys_do_different_things_and_none_is_one_that_the_script_takes():
    keys = [str(key.hotkey).upper() for key in KEYS]
    assert len(set(keys)) == len(keys) and not {"P", "T"} & set(keys)
    script = (ROOT / "app/static/page.js").read_text("utf-8")
    assert re.search(r'key === "p" \|\| key === "P"', script) and re.search(r'key !== "t" && key !== "T"', script)
