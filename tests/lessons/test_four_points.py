"""Step "four-points": any four matches fit exactly, and points near a plane cross lines flatly."""

import time

import numpy as np
import pytest
from viewimit.app.lessons.answers import right_answer
from viewimit.app.lessons.card import draw_lesson
from viewimit.app.lessons.measures import MEASURES
from viewimit.app.lessons.works.four_points import best_order, fit_any, pressed
from walking import course_at

from viewimit.estimation.transfers import epipolar
from viewimit.estimation.views import FourViews
from viewimit.geometry.affine import flatness
from viewimit.simulation.world import World


@pytest.fixture(scope="module")
def course():
    return course_at("four-points")


def test_four_random_points_fit_whatever_the_images_are():
    rng = np.random.default_rng(3)
    views = FourViews(rng.uniform(0, 500, (4, 4)), rng.uniform(0, 500, (50, 4, 4)), np.ones(1, bool))
    assert np.max(fit_any(views).conflict(views)) < 1e-12
    five = FourViews(rng.uniform(0, 500, (5, 4)), rng.uniform(0, 500, (50, 5, 4)), np.ones(1, bool))
    assert np.min(fit_any(five).conflict(five)) > 1


def test_with_five_points_and_more_it_is_the_paper_s_transfer(course):
    views = course.moments[-1].views
    used = views.used
    np.testing.assert_allclose(fit_any(used).matrix, epipolar.fit(used).matrix)


def test_the_right_answer_is_right_in_this_scene(course):
    made = course.made["matches"]
    assert right_answer(course.stage, course.step.ask) == 1
    assert np.nanmax(made.by_count[4].E) < 1e-12 * np.nanmax(made.by_count[10].E)
    assert np.isfinite(made.by_count[4].E).all()
    assert MEASURES["largest E of four matches"].told(course.stage) == "0 px²"
    for count in range(5, 11):
        assert np.nanmax(made.by_count[count].E) > 1


def test_with_all_matches_it_is_the_session_s_own_conflict(course):
    found, session = course.made["matches"].by_count[10], course.session
    assert len(found.local_minima()) == 1
    for i, j in ((10, 40), (50, 100)):
        theta = np.array([found.axes[0][i], found.axes[1][j]])
        assert session.observe(theta, session.snapshot).E == pytest.approx(found.E[i, j])


def test_the_four_are_the_least_flat_of_all(course):
    stereo = course.moments[-1].views.demo
    order = best_order(stereo)
    assert sorted(order) == list(range(10))
    rng = np.random.default_rng(1)
    third = lambda rows: np.linalg.svd(stereo[rows] - stereo[rows].mean(0), compute_uv=False)[2]
    best = third(order[:4]) * (1 + 1e-9)
    assert all(best >= third(rng.choice(10, 4, replace=False)) for _ in range(100))


def test_pressed_points_stay_near_one_plane_at_every_posture_and_are_in_it_with_nothing_left(course):
    world, theta_demo = course.session.world, course.moments[-1].theta_demo
    for left in (0.1, 0.0):
        flat = World(world.scene, body=pressed(world, theta_demo, left))
        for theta in ([0.2, -0.4], [1.2, -2.5]):
            before, after = (w.points_world(np.array(theta), w.T_world_own) for w in (world, flat))
            y = lambda points: points[:, 1] - points[:, 1].mean()  # across the plane in which this arm moves
            np.testing.assert_allclose(y(after), left * y(before), atol=1e-9)
            np.testing.assert_allclose(after[:, [0, 2]], before[:, [0, 2]], atol=1e-9)
    assert flatness(flat.demo_images(theta_demo)[0]) > 1e6


def test_near_a_plane_lines_cross_more_flatly_and_most_ways_downhill_end_early(course):
    plane, whole = course.made["matches"].plane, course.made["matches"].by_count[10]
    assert np.median(plane.condition) > 2 * np.median(whole.condition)
    assert plane.basin_fraction() < 0.5 < whole.basin_fraction() == 1
    assert len(plane.local_minima()) > 5


def test_it_is_walked_and_drawn_and_the_work_is_quick(course):
    begun = time.process_time()
    course.go(-1)
    course.go(1)
    assert time.process_time() - begun < 3  # two steps' works
    assert "?</text>" in draw_lesson(course, "/x")
    course.choose(0)
    course.show()
    shown = draw_lesson(course, "/x")
    assert "E is 0 at every posture" in shown and "nearly in a plane" in shown
    for count in range(5, 11):
        course.turn(0, count)
        drawn = draw_lesson(course, "/x")
        assert f">{count} matches<" in drawn and "E is 0" not in drawn
