"""A rehearsal that turns each joint by itself foretells every posture: what is left of an imitation is its evidence."""

import numpy as np
import pytest
from sameness import error_deg

from viewimit import Session, Settings

SEVEN = (1, 2, 3, 4, 5, 6, 7)


@pytest.mark.parametrize("postures", [10, pytest.param(12, marks=pytest.mark.slow)])
def test_seven_joints_are_imitated_at_once_and_then_checked_one_by_one(postures):
    for seed in range(2):
        settings = Settings.paper(transfer="projective", servo="likelihood", joints=SEVEN, points=16)
        session = Session(settings)
        session.calibrate(postures, seed, within_deg=60.0)
        session.reset()
        lower, upper = session.embodiment.lower, session.embodiment.upper
        aside = np.random.default_rng(seed).uniform(-0.5, 0.5, 7)
        session.pose(np.clip(session.snapshot.theta + aside, lower, upper))
        last = session.run(60).last
        assert last.status == "converged" and error_deg(last) < 0.01 and last.motion <= 7 + 2


def test_a_head_that_has_moved_is_noticed_though_kinematics_foretold_everything():
    session = Session(Settings.paper(transfer="projective", servo="likelihood"))
    body = session.calibrate(12, 0)
    moved = Session(Settings.paper(transfer="projective", servo="likelihood", scene="panda-verged"))
    moved.use_calibration(body)
    moved.pose((moved.embodiment.lower + moved.embodiment.upper) / 2)
    last = moved.run(60).last
    assert not last.servo_state.calibration and error_deg(last) < 0.5
