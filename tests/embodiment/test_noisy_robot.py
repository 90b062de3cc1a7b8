"""A robot of one's own whose image points are noisy is found, and the run ends in a claim."""

import runpy
from pathlib import Path

import numpy as np
import pytest

from viewimit import Session

FakeRobot = runpy.run_path(str(Path(__file__).parents[2] / "examples" / "fake_robot.py"))["FakeRobot"]
DEMONSTRATOR_DEG = (30, -45, 80)
MOST_MOTIONS = 15
TIMES = 3.0  # the expected error, beyond which a claim is false


@pytest.mark.parametrize(
    "noise_px, seed",
    [(0.1, 0), (0.5, 1), *(pytest.param(px, k, marks=pytest.mark.slow) for px in (0.1, 0.25, 0.5) for k in (2, 3, 4))],
)
def test_a_noisy_robot_with_parallel_cameras_converges_in_few_motions(noise_px, seed):
    """E that noise leaves was judged by weights of affine cameras: above all of its noise at the right posture."""
    robot = FakeRobot(DEMONSTRATOR_DEG, noise_px, seed)
    ended = Session.of(robot, robot).run()
    error = np.abs(ended.theta - robot.demonstrator).max()
    assert ended.status == "converged" and ended.motions <= MOST_MOTIONS
    assert error <= TIMES * ended.last.expected_error
