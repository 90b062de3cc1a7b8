"""What is said of a session, in Python or as a command, is run, and ends at the same posture to the last bit."""

import argparse
import json
import shlex
import subprocess
import sys

import numpy as np
import pytest
from viewimit.app.model.choices import PRESETS

from viewimit.commands import reproduce
from viewimit.commands.json_output import plain
from viewimit.commands.options import settings_from
from viewimit.loop.codegen import MAX_LINES, as_command, as_python, as_reproduction
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.simulation.scene import load_scene

SEEN_BY_POINTS = [preset.settings for preset in PRESETS if preset.settings.sensor == "projected"]


def ran(lines: str) -> np.ndarray:
    """The posture at which lines of Python end."""
    names: dict = {"print": lambda *what: None}
    exec(lines, names)  # as a person would run them
    return names["session"].snapshot.theta


@pytest.mark.parametrize("settings", SEEN_BY_POINTS, ids=[p.name for p in PRESETS if p.settings.sensor == "projected"])
def test_every_preset_after_some_motions_is_said_in_python(settings):
    session = Session(settings)
    session.run(5)
    lines = as_python(session.script)
    assert len(lines.splitlines()) <= MAX_LINES and max(map(len, lines.splitlines())) < 320
    assert ran(lines).tobytes() == session.snapshot.theta.tobytes()


def test_what_was_done_by_hand_is_said_line_by_line_and_much_of_it_as_data():
    session = Session(Settings())
    session.step()
    session.pose((0.5, -1.0))
    session.change(noise_px=0.25)
    session.step()
    lines = as_python(session.script)
    assert "session.pose((0.5, -1.0))" in lines and "session.change(noise_px=0.25)" in lines
    assert ran(lines).tobytes() == session.snapshot.theta.tobytes()
    for k in range(8):
        session.pose((0.5 + 0.01 * k, -1.0))
        session.step()
    lines = as_python(session.script)
    assert len(lines.splitlines()) <= MAX_LINES
    assert ran(lines).tobytes() == session.snapshot.theta.tobytes()


BY_HAND = Settings(body_points=tuple(load_scene("panda").points["16"][2:14]))
BOUND = Settings(max_step_deg=6.5, workspace_deg=((5, 80), (-120.5, -20)), start_deg=(25, -45))
LOSSY = Settings.paper(points=16, missing=0.15, start_deg=(25.1, -45), transfer="linear", seed=3)


@pytest.mark.parametrize("settings", [Settings.paper(), Settings(), LOSSY, SEEN_BY_POINTS[5], BOUND])
def test_the_command_prints_the_same_posture(settings):
    session = Session(settings)
    session.run(4)
    words = shlex.split(as_command(session.script))
    assert words[0] == "viewimit"
    made = subprocess.run([sys.executable, "-m", "viewimit", *words[1:]], capture_output=True, text=True)
    assert made.returncode in (0, 1), made.stderr
    found = json.loads(made.stdout)
    assert found["final_deg"] == plain(np.degrees(session.snapshot.theta))  # all digits that it prints
    assert found["history"] == plain(
        [{"theta_deg": np.degrees(m.theta), "E": m.E, "probe": m.probe} for m in session.history]
    )


@pytest.mark.parametrize("settings", [Settings.paper(), Settings(), LOSSY, SEEN_BY_POINTS[5]])
def test_a_figure_is_reproduced_with_the_same_settings(settings):
    parser = argparse.ArgumentParser()
    reproduce.add_options(parser)
    settings = Session(settings).settings  # with the scene's postures
    words = shlex.split(as_reproduction("fig10", settings, "circle"))
    asked = parser.parse_args(words[2:])
    assert words[:2] == ["viewimit", "reproduce"] and (asked.figures, asked.motion) == (["fig10"], "circle")
    assert settings_from(asked) == settings
    with pytest.raises(ValueError, match="by hand"):
        as_reproduction("fig7", BY_HAND)
    with pytest.raises(ValueError, match="how far the arm goes"):
        as_reproduction("fig7", BOUND)
