"""Eyes turned inwards: E is smallest far off until images are rectified, by matches alone."""

import msgspec
import numpy as np
import pytest
from viewimit.app.lessons.answers import right_answer
from viewimit.app.lessons.card import draw_lesson
from viewimit.app.lessons.figures import FIGURES
from viewimit.app.lessons.measures import MEASURES
from walking import course_at, words

from viewimit.analysis.minima import study_transfer
from viewimit.loop.session import Session


@pytest.fixture(scope="module")
def course():
    course = course_at("toed-in")
    course.choose(2)
    course.show()
    return course


@pytest.mark.parametrize(
    "name, changed, tolerance",
    [("as seen", {}, 0.2), ("rectified", {"rectify": "auto"}, 0.2), ("more points", {"points": 20}, 0.2)],
)
def test_how_far_the_smallest_E_is_off_is_what_another_search_finds(course, name, changed, tolerance):
    session = Session(msgspec.structs.replace(course.session.settings, **changed))
    found = study_transfer(session.world, session.snapshot, session.settings.transfer)
    assert MEASURES[f"off with {name}" if name == "more points" else f"off {name}"].of(course.stage) == pytest.approx(
        np.abs(found.bias_deg).max(), abs=tolerance
    )


def test_rows_that_are_made_equal_put_it_right_and_more_points_do_not(course):
    off = {name: MEASURES[name].of(course.stage) for name in ("off as seen", "off rectified", "off with more points")}
    assert off["off as seen"] > 15 and off["off with more points"] > 15 and off["off rectified"] < 2
    right = course.step.ask.answers[right_answer(course.stage, course.step.ask)]
    assert "equal rows" in right.text


def test_rectification_is_of_the_matches_that_are_told(course):
    rectified = course.made["mendings"]["rectified"].rectification
    views = course.stage.moments[0].views
    matches = np.concatenate([views.demo, views.own])
    assert MEASURES["matches"].of(course.stage) == len(matches)
    level = rectified.apply(matches)
    assert np.abs(level[:, 3] - level[:, 1]).max() < 0.01 < 1 < np.abs(matches[:, 3] - matches[:, 1]).max()
    assert course.made["mendings"]["as seen"].rectification is None


def test_what_comes_after_is_hidden_before_and_both_are_told_then(course):
    before = course_at("toed-in")
    drawn = FIGURES["rows"].draw(before.stage, ["as seen"], True)
    assert (
        "rectified" not in drawn
        and "Rectified" not in draw_lesson(before, None)
        and "rows differ by less than 0.01 px" not in words(before)
    )
    told = words(course)
    assert "rows differ by less than 0.01 px" in told and "–" not in told
    for name in ("off as seen", "off rectified"):
        assert f"{MEASURES[name].of(course.stage):.1f}° off" in told


def test_nothing_is_told_right_while_it_is_computed():
    course = course_at("toed-in")
    course.works.made = {}
    assert right_answer(course.stage, course.step.ask) == -1 and np.isnan(MEASURES["off rectified"].of(course.stage))
    assert "computing …" in words(course)
