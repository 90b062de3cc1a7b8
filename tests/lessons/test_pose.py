"""A posture that is asked for is given to a see-through arm by two sliders, and told how far off it is."""

import numpy as np
import pytest
from quiet_page import QuietPage
from viewimit.app.lessons.course import MOST_PATH
from viewimit.app.lessons.measures import MEASURES
from viewimit.app.lessons.reveal import verdict
from viewimit.app.lessons.sliders import draw_sliders
from viewimit.app.lessons.source import load
from walking import begun, course_at

from viewimit.loop.settings import Settings

LESSON = """
title = "Guess"
short = "Guess"
about = "One posture."
minutes = 1
[[step]]
id = "guess"
title = "Where is it smallest?"
text = "Turn the joints."
say = "There."
main = [{ figure = "landscape", reveal = ["relief", "smallest"] }]
side = [{ figure = "L", show = ["guessed"], reveal = ["guessed arrows"] }]
sliders = [
  { name = "guess 1", label = "Shoulder", low = 0, high = 90, start = 25 },
  { name = "guess 2", label = "Elbow", low = -180, high = 0, start = -25 },
]
[step.ask]
kind = "pose"
question = "Which posture has the smallest E?"
truth = "place of the smallest E"
near = 5
close = "Close."
far = "Off by {degrees apart}."
"""


@pytest.fixture
def course(tmp_path):
    (tmp_path / "mine.toml").write_text(LESSON)
    return begun(load(tmp_path / "mine.toml", tried=True))


@pytest.mark.parametrize(("posture", "said"), [((46.0, -90.0), "Close."), ((20.0, -90.0), "Off by {degrees apart}.")])
def test_it_is_answered_by_turning_both_joints(course, posture, said):
    """The learner itself stays where it is; once the truth is shown nothing is answered any more."""
    learner = course.moments[-1].theta
    assert not course.answered
    np.testing.assert_allclose(course.see_through, learner)
    for k, angle in enumerate(posture):
        course.turn(k, angle)
    assert course.answered and course.given.place == posture and len(course.moments) == 1
    np.testing.assert_allclose(np.degrees(course.see_through), posture)
    course.show()
    assert verdict(course.stage) == said
    with pytest.raises(ValueError, match="has been answered"):
        course.turn(0, 80.0)
    assert course.given.place == posture and course.moments[-1].theta is learner
    assert draw_sliders(course, "/x") == ""


def test_the_images_show_what_would_be_seen_there(course):
    """Points and arrows as a session sees them whose learner stands there."""
    for k, angle in enumerate((60.0, -120.0)):
        course.turn(k, angle)
    course.session.begin(Settings.paper(demonstrator_deg=(45.0, -90.0), start_deg=(60.0, -120.0)))
    there, seen = course.session.snapshot, course.stage.guessed
    np.testing.assert_allclose(seen.views.own, there.views.own)
    assert seen.E == pytest.approx(there.E)


def test_a_posture_is_off_by_its_joint_that_is_farthest_off():
    course = course_at("alike")
    for k, angle in enumerate((50.0, -110.0)):
        course.turn(k, angle)
    course.show()
    words = verdict(course.stage)
    assert words == course.step.ask.far and "off by" in course.step.told.label
    off = np.abs(np.array([50.0, -110.0]) - np.degrees(course.moments[-1].theta_demo))
    assert course.step.ask.near < off.max() == pytest.approx(MEASURES[course.step.told.measure].of(course.stage))


def test_the_arm_is_seen_in_3d_beside_the_learner_until_the_step_is_left():
    page = QuietPage(address="/touch/0.x")
    page.page.touch("lesson", "begin,motion")
    page.tick(1.0)
    model = page.page.model
    for verb in ("turn,0,70", "turn,1,-100"):
        page.page.touch("lesson", verb)
        page.tick(1.0)
    learner, _, guess = model.poses(page.now)
    np.testing.assert_allclose(np.degrees(guess), (70, -100))
    page.page.touch("lesson", "show")
    page.tick(1.0)
    learner, demonstrator, guess = model.poses(page.now)
    np.testing.assert_allclose(learner, demonstrator)
    np.testing.assert_allclose(np.degrees(guess), (70, -100))
    page.page.touch("lesson", "next")
    page.tick(1.0)
    assert len(model.poses(page.now)) == 2


def test_motions_by_hand_have_an_end():
    course = course_at("servo")
    for k in range(MOST_PATH):
        course.turn(0, 80.0 + k % 2)
    shown = len(course.moments)
    with pytest.raises(ValueError, match="begin the step again"):
        course.turn(0, 60.0)
    assert len(course.moments) == shown == len(course.given.path) == len(course.given.E)


@pytest.mark.parametrize(
    ("was", "becomes", "told"),
    [
        ('  { name = "guess 2", label = "Elbow", low = -180, high = 0, start = -25 },\n', "", "two joints"),
        ("guess 1", "own 1", "two joints"),
        ('kind = "pose"', 'kind = "do"\nmeasure = "E"\nbelow = 3', "see-through arm is turned where"),
    ],
)
def test_it_needs_the_sliders_of_two_joints_and_these_need_it(tmp_path, was, becomes, told):
    text = LESSON.replace(was, becomes)
    if "do" in becomes:
        text = "\n".join(line for line in text.splitlines() if not line.startswith(("truth", "near", "close", "far")))
    (tmp_path / "mine.toml").write_text(text)
    with pytest.raises(ValueError, match=f"mine.toml, line .*{told}"):
        load(tmp_path / "mine.toml")
