"""A posture that is asked for is answered by two sliders, and told how far off it is."""

import numpy as np
import pytest
from viewimit.app.lessons.course import MOST_PATH
from viewimit.app.lessons.reveal import verdict
from viewimit.app.lessons.source import load
from walking import begun

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
sliders = [
  { name = "own 1", label = "Shoulder", low = 0, high = 90, start = 25 },
  { name = "own 2", label = "Elbow", low = -180, high = 0, start = -25 },
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
    assert not course.answered
    for k, angle in enumerate(posture):
        course.turn(k, angle)
    assert course.answered and course.given.place == posture
    course.show()
    assert verdict(course.stage) == said
    course.turn(0, 80.0)  # what is turned once it is revealed answers nothing
    assert course.given.place == posture and verdict(course.stage) == said
    course.turn(0, posture[0])
    np.testing.assert_allclose(np.degrees(course.moments[-1].theta), posture)


def test_motions_by_hand_have_an_end(course):
    for k in range(MOST_PATH):
        course.turn(0, 30.0 + k % 2)
    shown = len(course.moments)
    with pytest.raises(ValueError, match="begin the step again"):
        course.turn(0, 60.0)
    assert len(course.moments) == shown == len(course.given.path) == len(course.given.E)


def test_it_needs_two_sliders(tmp_path):
    lines = [line for line in LESSON.splitlines() if "own 2" not in line]
    (tmp_path / "mine.toml").write_text("\n".join(lines))
    with pytest.raises(ValueError, match="two joints"):
        load(tmp_path / "mine.toml")
