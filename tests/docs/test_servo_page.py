"""The servo that the documentation writes from scratch arrives and follows."""

import re
from pathlib import Path

import numpy as np

from viewimit import Session, Settings

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "servo.md"
CODE = re.search(r":::\{file\} secant\.py\n:language: python\n\n(.*?)\n:::", PAGE.read_text("utf-8"), re.DOTALL)[1]


def test_it_arrives_and_follows_a_demonstrator_that_moves():
    found = {}
    exec(compile(CODE, "secant.py", "exec"), found)
    session = Session(Settings(demonstrator_deg=(45, -90), start_deg=(25, -45)), servo=found["Secant"]())
    result = session.run(60)
    assert np.abs(np.degrees(result.theta) - (45, -90)).max() < 0.01  # the length of its last step
    assert np.abs(session.observation(result.last).residual).max() < 0.01
    session.pose(np.radians((50, -80)))
    assert np.abs(np.degrees(session.run(120).theta) - (50, -80)).max() < 0.01
