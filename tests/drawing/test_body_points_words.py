"""What is said of body points that are edited: the numbers given, joints that are not told, and no more than fits."""

import re

import numpy as np
import pytest
from viewimit.app.drawing.joint_bars import describe_body_points, draw_body_points

from viewimit.analysis.observability import PointInformation, Proposal
from viewimit.simulation.robot import BodyPoints

POINT = BodyPoints(np.array([1]), np.zeros((1, 3)))
SEVEN = tuple(range(1, 8))


def information(*costs_deg, seen=11, flat=12.3):
    return PointInformation(11, seen, np.radians(costs_deg) if costs_deg else None, flat)


def test_few_joints_are_named_with_their_costs():
    said = describe_body_points((2, 4), information(2.2, 1.84), None, False)
    assert said == "11 points; noise of 1 px: θ₂ 2.2°, θ₄ 1.8°; σ₁/σ₃ 12. Click an arm to place one."


def test_of_many_joints_the_costliest_and_all_that_are_not_told_are_named():
    said = describe_body_points(SEVEN, information(2.0, 2.1, 30.0, 1.9, 1.8, 5.2, np.inf), None, False)
    assert "noise of 1 px: at most θ₆ 5.2°; θ₃, θ₇ unobservable" in said
    assert "θ₁" not in said


def test_too_few_points_and_those_out_of_sight_are_said():
    said = describe_body_points((2, 4), information(seen=4, flat=np.inf), None, False)
    assert said.startswith("11 points, 4 in all images; a transfer needs 5.") and "σ" not in said


@pytest.mark.parametrize(
    "searching, words", [(True, "Looking for"), (False, "would help most: noise of 1 px: θ₂ 1.9°, θ₄ 1.5°.")]
)
def test_a_further_point_is_announced_and_then_said_with_what_it_changes(searching, words):
    before, after = information(2.2, 1.8), information(1.9, 1.5)
    proposal = None if searching else Proposal(POINT, before, after)
    for told in (describe_body_points, draw_body_points):
        assert words in told((2, 4), before, proposal, searching)
    assert "Click an arm" not in describe_body_points((2, 4), before, proposal, searching)


def test_each_joint_has_a_bar_as_long_as_its_cost():
    drawn = draw_body_points(SEVEN, information(1, 2, 3, 4, 5, 6, 7), None, False)
    widths = [float(width) for width in re.findall(r'<rect[^>]* width="([\d.]+)"', drawn)]
    np.testing.assert_allclose(np.array(widths) / widths[0], SEVEN, rtol=0.01)
