"""A pixel costs degrees, most at the joint that E hardly tells; averaging makes it less by the root of the images."""

import numpy as np
import pytest
from viewimit.app.lessons.answers import right_answer
from viewimit.app.lessons.measures import MEASURES
from viewimit.app.lessons.reveal import verdict
from walking import course_at, words

from viewimit.analysis.observability import sample_estimates

RUNS = 300


@pytest.fixture(scope="module")
def noise():
    course = course_at("noise")
    course.choose(1)
    course.show()
    return course


def own_scatter(course, noise_px=0.02):
    """(2,) degrees a pixel of the own images, by runs of another seed, not by derivatives."""
    world, moment, rng = course.session.world, course.stage.moments[0], np.random.default_rng(99)
    found = sample_estimates(world, moment.fit, moment.theta_demo, noise_px, 1, RUNS, rng, noisy_demo=False)
    return np.degrees(found.std(0)) / noise_px


def test_the_joint_that_costs_most_is_the_one_that_runs_scatter_most(noise):
    by_runs = own_scatter(noise)
    ask = noise.step.ask
    assert right_answer(noise.stage, ask) == by_runs.argmax() == 0
    told = [MEASURES[f"cost at the {which} joint"].of(noise.stage) for which in ("first", "second")]
    assert told == pytest.approx(by_runs, rel=5 / np.sqrt(2 * RUNS))
    assert verdict(noise.stage) == ask.answers[1].because


def test_noise_in_all_images_scatters_the_same_joint_most_and_more_than_that_of_the_own_alone(noise):
    scattered = [MEASURES[f"scatter of the {which} joint"].of(noise.stage) for which in ("first", "second")]
    assert scattered[0] > 1.3 * scattered[1]
    assert (np.array(scattered) > 1.1 * 0.5 * own_scatter(noise)).all()


def test_dots_are_shown_only_once_it_was_asked_and_how_many_runs_they_are():
    course = course_at("noise")
    assert "one image each time" not in words(course)
    course.choose(0)
    course.show()
    told = words(course)
    assert "one image each time" in told and "a dot a run, 600 runs, noise 0.50 px" in told and "–" not in told


@pytest.mark.parametrize("guess, close", [(5, True), (25, False), (1, False)])
def test_twenty_five_images_bring_the_cloud_together_by_about_five(guess, close):
    course = course_at("frames")
    assert "25 images averaged each time" not in words(course)
    course.guess(guess)
    course.show()
    clouds, ask = course.made["clouds"], course.step.ask
    wide, narrow = (np.linalg.norm(clouds[frames] - clouds[frames].mean(0)) for frames in (1, 25))
    assert len(clouds[1]) == len(clouds[25]) == 600
    assert MEASURES["times the cloud shrinks"].of(course.stage) == pytest.approx(wide / narrow)
    assert wide / narrow == pytest.approx(5, rel=4 / np.sqrt(600))
    assert verdict(course.stage) == (ask.close if close else ask.far)
    assert "25 images averaged each time" in words(course)


def test_of_what_the_shoulder_does_to_the_images_arrows_show_less_than_of_the_elbow(noise):
    """By going there: a degree to either side of the demonstrator's posture."""
    stage, turn = noise.stage, np.radians(1)
    world, theta = stage.session.world, stage.moments[0].theta_demo
    for joint, which in enumerate(("first", "second")):
        aside = turn * np.eye(2)[joint]
        looks = [world.look(theta, theta + sign * aside) for sign in (-1, 1)]
        e = [stage.moments[0].fit(views).residual(views) for views in looks]
        moved = (looks[1].own - looks[0].own).reshape(-1, 2) / 2
        shown = (e[1] - e[0]).reshape(-1, 2) / 2
        for name, change in (("moves", moved), ("shows", shown)):
            rms = np.sqrt(np.square(change).sum(-1).mean())
            assert MEASURES[f"{which} joint {name}"].of(stage) == pytest.approx(rms, rel=0.01)
    moves, shows = (
        [MEASURES[f"{which} joint {name}"].of(stage) for which in ("first", "second")] for name in ("moves", "shows")
    )
    assert moves[0] > moves[1] and shows[0] < shows[1]
