"""The servo that the documentation writes from scratch follows the demonstrator, by a residual that makes E."""

import re
from pathlib import Path

import numpy as np
import pytest

from viewimit import Session, Settings, conflict

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


@pytest.mark.parametrize("transfer", ["epipolar", "projective"])
def test_the_residual_that_a_servo_sees_makes_the_E_that_it_sees(transfer):
    session = Session(Settings(transfer=transfer, noise_px=0.3, missing=0.1, frames=1, demonstrator_deg=(45, -90)))
    seen = session.observation(session.snapshot)
    known = np.isfinite(seen.residual).all(1)
    assert 5 <= known.sum() < 10  # of 10 points some are hidden
    np.testing.assert_array_equal(known, session.snapshot.usable)
    assert conflict(seen.residual[known]) == pytest.approx(seen.E)
