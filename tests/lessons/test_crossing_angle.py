"""Step "crossing-angle": a pixel throws the crossing of nearly parallel lines by 1 / sin of their angle."""

import numpy as np
import pytest
from viewimit.app.lessons.card import draw_lesson
from viewimit.app.lessons.measures import MEASURES
from viewimit.app.lessons.measures.crossing_angle import crossing, lines, moved
from viewimit.app.lessons.reveal import verdict
from walking import course_at, told


@pytest.fixture
def course():
    return course_at("crossing-angle")


def test_a_pixel_moves_the_crossing_by_one_over_the_sine(course):
    for cm in (10, 5, 60):
        course.turn(0, cm)
        assert told(course, "baseline") == pytest.approx(cm)
        assert told(course, "crossing moves") == pytest.approx(1 / np.sin(np.radians(told(course, "crossing angle"))))


def test_the_line_aside_is_parallel_and_a_pixel_off_and_the_crossing_is_on_both(course):
    two = lines(course.stage)
    aside = moved(two)
    at = crossing(aside)
    assert abs(aside[0] @ [*at, 1]) < 1e-6 and abs(aside[1] @ [*at, 1]) < 1e-6
    assert abs(two[1] @ [*at, 1]) / np.hypot(*two[1, :2]) == pytest.approx(1)
    assert abs(two[0] @ [*at, 1]) < 1e-6


def test_the_crossing_is_where_the_learner_recovers_the_point(course):
    for cm in (5, 10, 30, 60):
        course.turn(0, cm)
        stage = course.stage
        recovered = stage.moment.recovered[stage.step.chosen, :2]
        assert np.linalg.norm(crossing(lines(stage)) - recovered) < 0.5


def test_eyes_farther_apart_cross_lines_more_steeply(course):
    names = ("crossing angle", "crossing moves", "uncertain by", "cond A")
    rows = []
    for cm in (5, 10, 20, 40, 60):
        course.turn(0, cm)
        rows.append([told(course, name) for name in names])
    angle, *others = np.transpose(rows)
    assert (np.diff(angle) > 0).all()
    assert (np.diff(others) < 0).all()


def test_so_many_of_noisy_pictures_recover_the_point_in_the_ellipse(course):
    """The transfer as it is fitted, of a point whose pixels in l and r are off by one, standard deviation."""
    from viewimit.app.lessons.measures.crossing_angle import construction

    stage = course.stage
    found, moment, point = construction(stage), stage.moment, stage.step.chosen
    noisy = moment.views.demo[point] + np.random.default_rng(5).standard_normal((4000, 4))
    away = moment.transfer.recover(noisy[:, :2], noisy[:, 2:])[:, :2] - found.recovered[0]
    turn = np.array([np.cos(found.direction[0]), np.sin(found.direction[0])])
    along, across = away @ turn, away @ [-turn[1], turn[0]]
    inside = (along / found.half_axes[0, 0]) ** 2 + (across / found.half_axes[0, 1]) ** 2 < 1
    assert inside.mean() == pytest.approx(0.95, abs=0.015)


def test_guesses_are_met_and_the_picture_shows_the_ellipse_only_then(course):
    ask = course.step.ask
    for number, words in ((1, ask.less), (16, ask.close), (23, ask.close), (45, ask.far)):
        course.guess(number)
        assert verdict(course.stage) == words
    assert "<ellipse" not in draw_lesson(course, "/x")
    course.show()
    shown = draw_lesson(course, "/x")
    assert shown.count("<ellipse") == 3 and MEASURES["crossing moves"].told(course.stage) in shown
