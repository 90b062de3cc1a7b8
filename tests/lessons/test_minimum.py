"""Step "minimum": the eyes move back, the arms stay as large, and the affine transfers' bias goes."""

import time

import numpy as np
import pytest
from viewimit.app.lessons.card import draw_lesson
from viewimit.app.lessons.measures import MEASURES
from viewimit.app.lessons.reveal import verdict
from viewimit.app.lessons.scenes import at_distance, spread
from viewimit.app.lessons.sliders import draw_sliders
from viewimit.app.lessons.works.minimum import TIMES
from walking import course_at, told, works_kept

from viewimit.analysis.landscape import conflict_at, grid_axes, landscape_over
from viewimit.analysis.minima import descend
from viewimit.estimation.transfers import TRANSFERS
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World


@pytest.fixture(scope="module", autouse=True)
def kept_works():
    """All of these courses begin with the same works."""
    with works_kept():
        yield


@pytest.fixture
def course():
    return course_at("minimum")


def by_descent(world, theta_demo, name):
    """Degrees from the smallest E to the demonstrator, by another way than the lesson's."""
    demo, visible = world.demo_images(theta_demo)
    fit = TRANSFERS[name]
    axes = grid_axes(world, 3.0)
    start = landscape_over(world, fit, demo, visible, axes).minimum
    bounds = np.array([[axis.min(), axis.max()] for axis in axes])
    ends, _ = descend(lambda at: conflict_at(world, fit, demo, visible, at)[0], start[None], bounds, np.radians(3))
    return float(np.degrees(np.abs(ends[0] - theta_demo).max()))


def test_the_head_goes_back_so_many_times_as_far_and_the_arms_stay_as_large():
    scene = load_scene()
    gazes = np.array([scene.head.gaze_demonstrator, scene.head.gaze_learner])
    far = lambda one: np.sqrt(((np.array(one.head.position) - gazes) ** 2).sum(1).mean())
    for times in (1.0, 3.0, 30.0):
        moved = at_distance(scene, 10, times)
        assert far(moved) == pytest.approx(times * far(scene))
        assert spread(moved, 10) == pytest.approx(spread(scene, 10))
        assert moved.head.baseline == scene.head.baseline
    same = at_distance(scene, 10, 1.0).head
    np.testing.assert_allclose((*same.position, same.focal), (*scene.head.position, scene.head.focal))


def test_no_image_grows_or_shrinks_by_more_than_a_tenth(course):
    def sizes():
        views = course.moments[-1].views
        images = np.concatenate([views.demo, views.own], 1).reshape(-1, 4, 2)
        return np.sqrt(((images - images.mean(0)) ** 2).sum(2).mean(0))

    near = sizes()
    course.guess(0.8)
    course.show()
    for times in (3, 10, 30):
        course.turn(0, times)
        np.testing.assert_allclose(sizes() / near, 1, atol=0.1)


def test_the_learner_stands_in_the_demonstrator_s_posture_and_depth_makes_all_of_E(course):
    moment = course.moments[-1]
    np.testing.assert_allclose(moment.theta, moment.theta_demo)
    assert told(course, "E") > 5
    assert told(course, "E without depth") < 1e-6 * told(course, "E")


def test_told_biases_are_those_of_descent_in_a_world_set_up_anew(course):
    scene, theta_demo = course.session.scene, course.moments[-1].theta_demo
    made = course.made["biases"]
    for name in TRANSFERS:
        for k in (0, list(TIMES).index(10.0)):
            world = World(at_distance(scene, 10, float(TIMES[k])), 10)
            assert made.degrees[name][k] == pytest.approx(by_descent(world, theta_demo, name), abs=0.006), name
    assert told(course, "bias at ten times the distance") == made.degrees["epipolar"][list(TIMES).index(10.0)]
    assert told(course, "bias at once the distance") == made.degrees["epipolar"][0]


def test_affine_biases_fall_at_every_distance_and_the_projective_one_is_none(course):
    made = course.made["biases"]
    for name in ("epipolar", "linear", "rank3"):
        assert (np.diff(made.degrees[name]) < 0).all()
    assert made.degrees["projective"].max() < 0.01
    assert told(course, "bias at ten times the distance") < told(course, "bias at once the distance") / 20


def test_the_slider_moves_the_cross_to_the_diamond(course):
    course.guess(0.8)
    course.show()
    off = []
    for times in (1, 3, 10, 30):
        course.turn(0, times)
        off.append(told(course, "bias"))
        demo = course.moments[-1].theta_demo
        assert off[-1] == pytest.approx(by_descent(course.session.world, demo, "epipolar"), abs=0.006)
    assert off == sorted(off, reverse=True) and off[-1] < 0.1 < 5 < off[0]


def test_the_guess_is_met_by_what_is_wrong_with_it(course):
    ask = course.step.ask
    for number, words in ((0.14, ask.close), (0.25, ask.close), (8, ask.far), (0.8, ask.far), (0.014, ask.less)):
        course.guess(number)
        assert verdict(course.stage) == words


def test_a_place_of_the_slider_is_kept_when_one_comes_back(course):
    course.guess(0.8)
    course.show()
    course.turn(0, 10)
    far = course.session.scene.head
    course.go(1)
    assert course.session.scene.head != far
    course.go(-1)
    assert course.session.scene.head == far
    assert course.session.snapshot.E < 0.1


def test_it_is_drawn_before_and_after_and_the_works_are_quick(course):
    hidden = draw_lesson(course, "/x")
    assert "rank 3" not in hidden and "here" in hidden
    course.guess(0.8)
    course.show()
    shown = draw_lesson(course, "/x")
    assert (
        "rank 3" in shown
        and "you: 0.8°" in shown
        and MEASURES["bias at ten times the distance"].told(course.stage) in shown
    )
    begun = time.process_time()
    course.turn(0, 5)
    assert time.process_time() - begun < 2


def test_a_reader_is_told_what_a_logarithmic_slider_shows(course):
    course.guess(1.0)
    course.show()
    course.turn(0, 10.0)
    drawn = draw_sliders(course, "/x")
    assert 'value="1" aria-valuetext="10 ×"' in drawn and "<output>10 ×</output>" in drawn
