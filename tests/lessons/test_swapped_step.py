"""A swapped pair: no posture explains the images, and the learner says which pair does not fit."""

import re
from dataclasses import replace

import msgspec
import numpy as np
import pytest
from drawn import SWAPPED, SWAPPED_NAME, written_path
from viewimit.app.lessons.answers import right_answer
from viewimit.app.lessons.card import draw_lesson
from viewimit.app.lessons.figures import FIGURES
from viewimit.app.lessons.measures import MEASURES
from viewimit.app.lessons.measures.exchange import named, true_pairs
from walking import course_at, words

from viewimit.loop.session import Session


@pytest.fixture(scope="module")
def course():
    course = course_at("swapped")
    assert SWAPPED not in draw_lesson(course, "/x") and "seem to be swapped" not in words(course)
    course.choose(0)
    course.show()
    return course


@pytest.fixture(scope="module")
def pair(course):
    """Whose images differ from those of a session in which nothing is swapped."""
    clean = Session(msgspec.structs.replace(course.session.settings, swapped=0.0)).snapshot
    return tuple(np.flatnonzero((course.stage.moments[0].views.demo != clean.views.demo).any(-1)).tolist())


def test_one_pair_of_the_ten_points_is_swapped_and_the_learner_names_it(course, pair):
    assert len(pair) == 2 and true_pairs(course.stage) == (pair,) == named(course.stage)
    told = words(course)
    assert f"points {pair[0]} and {pair[1]} seem to be swapped" in told
    assert f"Swapped are points {pair[0]} and {pair[1]}." in told


def test_both_points_are_ringed_and_named_in_the_images_where_they_are_seen(course, pair):
    stage = course.stage
    for view in "lL":
        drawn = FIGURES[view].draw(stage, ["pair"], True)
        body = stage.moment.views.demo if view == "l" else stage.moment.views.own
        window_centres = written_path(drawn, SWAPPED)
        starts = np.array(re.findall(r"M([\d.-]+) ([\d.-]+)m", window_centres), float)
        shown = re.findall(rf"{SWAPPED_NAME}[^>]*>(\d+)<", drawn)
        assert [int(name) for name in shown] == list(pair) and len(starts) == 2
        apart = body[list(pair), :2]
        (dx, dy), (sx, sy) = np.diff(apart, axis=0)[0], np.diff(starts, axis=0)[0]
        assert sx * dy == pytest.approx(sy * dx, rel=0.02)  # as in the image, but for its scale


def test_E_is_large_wherever_the_arm_goes_and_smallest_at_a_wrong_posture(course):
    session, stage = course.session, course.stage
    theta_demo = session.snapshot.theta_demo
    at_demo = session.observe(theta_demo, session.snapshot).E
    smallest = MEASURES["smallest E"].of(stage)
    assert 50 < smallest < at_demo
    place = MEASURES["place of the smallest E"].of(stage)
    assert session.observe(np.radians(place), session.snapshot).E == pytest.approx(smallest)
    assert np.abs(place - np.degrees(theta_demo)).max() == pytest.approx(MEASURES["smallest E is off"].of(stage))
    assert MEASURES["smallest E is off"].of(stage) > 20
    assert course.step.ask.answers[right_answer(stage, course.step.ask)].text.endswith("at a wrong posture")


def test_the_other_eight_points_have_long_arrows_too_where_both_arms_stand_alike(course, pair):
    clean = Session(msgspec.structs.replace(course.session.settings, swapped=0.0))
    eight = np.delete(np.arange(10), pair)
    alike = [one.observe(one.snapshot.theta_demo, one.snapshot).e[eight] for one in (course.session, clean)]
    assert np.linalg.norm(alike[0]) > 10 > 0.01 > np.linalg.norm(alike[1])


def test_with_the_pair_changed_back_it_arrives(course):
    assert MEASURES["off at rest"].of(course.stage) < 0.5 and MEASURES["E at rest"].of(course.stage) < 0.01
    assert MEASURES["least E as seen"].of(course.stage) >= MEASURES["smallest E"].of(course.stage)
    assert "I have arrived." in words(course) and "–" not in words(course)


def test_without_a_swap_nothing_is_told_of_one(course):
    clean = course_at("swapped")
    clean.session.change(swapped=0.0)
    assert true_pairs(replace(clean.stage, moments=[clean.session.snapshot])) == ()
