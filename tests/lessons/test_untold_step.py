"""A joint nobody tells: E is a valley along the elbow, and the learner does not say that it has arrived."""

import msgspec
import numpy as np
import pytest
from viewimit.app.lessons.answers import right_answer
from viewimit.app.lessons.measures import MEASURES
from viewimit.app.lessons.reveal import verdict
from walking import course_at, words

from viewimit.loop.session import Session


@pytest.fixture(scope="module")
def course():
    course = course_at("untold")
    before = words(course)
    assert "The learner says" not in before and "off" not in before
    course.choose(0)
    course.show()
    return course


def E_at(course, elbow_deg, wrist_deg):
    session = course.session
    return session.observe(np.radians([elbow_deg, wrist_deg]), session.snapshot).E


def test_whatever_the_elbow_E_is_as_small_and_with_the_wrist_it_rises(course):
    right = np.degrees(course.session.snapshot.theta_demo)[1]
    (low, high), _ = course.session.scene.range_deg
    assert max(E_at(course, elbow, right) for elbow in np.linspace(low, high, 10)) < 1e-4
    assert all(E_at(course, -90, right + turn) > 0.5 for turn in (-30, -15, 15, 30))


def test_so_the_elbow_is_the_right_answer_and_every_other_one_is_answered_otherwise(course):
    ask = course.step.ask
    assert ask.answers[right_answer(course.stage, ask)].text == "The elbow"
    assert len({answer.because for answer in ask.answers}) == len(ask.answers) and "Right" in verdict(course.stage)


def test_the_learner_names_the_joint_and_does_not_claim_to_have_arrived(course):
    session = Session(msgspec.structs.replace(course.session.settings, servo="trust-region"))
    last = session.run().last
    off = np.degrees(np.abs(last.theta - last.theta_demo).max())
    assert last.status == "unobservable" and last.E < 1e-4 and off > 5
    assert MEASURES["off at rest"].of(course.stage) == pytest.approx(off)
    assert MEASURES["motions to rest"].of(course.stage) == last.motion
    told = words(course)
    assert "I cannot tell the elbow." in told and "I do not say that I have arrived." in told
    assert f"{off:.1f}° off, at the elbow." in told and "I have arrived." not in told.replace("that I have", "")


def test_turning_the_elbow_by_hand_leaves_E_and_turning_the_wrist_does_not(course):
    right = float(np.degrees(course.session.snapshot.theta_demo)[1])
    course.turn(1, right)
    course.turn(0, -120)
    assert course.stage.moment.E < 1e-4
    course.turn(1, right - 45)
    assert course.stage.moment.E == pytest.approx(E_at(course, -120, right - 45)) and course.stage.moment.E > 1
    assert course.step is not None and "–" not in words(course)
