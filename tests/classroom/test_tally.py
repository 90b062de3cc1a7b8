"""What a class has answered, counted: against a count by hand, and drawn with what is true only once it is revealed."""

import dataclasses
import random
import re

import msgspec
import numpy as np
import pytest
from drawn import ANSWERS_NOW, DEMONSTRATORS_POINTS, OTHERS_MARKS, written_path
from viewimit.app.classroom.messages import Answer
from viewimit.app.control.classroom.tally import tally_of
from viewimit.app.lessons.course import Course
from viewimit.app.lessons.format import Pose
from viewimit.app.lessons.measures import MEASURES
from viewimit.app.lessons.progress import Progress
from viewimit.app.lessons.source import shipped
from viewimit.app.panels.classroom.question import tally_html

from viewimit.drawing.classroom.tally import draw_moves


def course_at(lesson, step):
    """At one step, whose works are done at once."""
    steps = [one.id for one in shipped()[lesson].step]
    at = len(shipped()[lesson].question) + steps.index(step)
    work = lambda kind, make, take: later.append((make, take))
    later: list = []
    course = Course(shipped()[lesson], Progress(lesson=lesson, at=at), work)
    while later:
        make, take = later.pop(0)
        take(make())
    return course


@pytest.fixture(scope="module")
def choice():
    return course_at("tour", "arrows").stage


def test_choices_are_counted_and_moves_between_them(choice):
    rng, people = random.Random(3), [f"{k:016x}" for k in range(25)]
    first, again = ({one: Answer(choice=rng.randrange(3)) for one in rng.sample(people, 20)} for _ in range(2))
    tally = tally_of(choice, again, first)
    right = lambda answers, one: answers[one].choice == 0  # as the lesson's file has it
    assert tally.counts == tuple(sum(a.choice == k for a in again.values()) for k in range(3))
    assert tally.total == 20 and tally.right == sum(right(again, one) for one in again)
    assert tally.before == tuple(sum(a.choice == k for a in first.values()) for k in range(3))
    both = set(first) & set(again)
    moved = [(right(first, one), right(again, one)) for one in both]
    assert tally.moved == tuple(moved.count(m) for m in ((True, True), (False, True), (True, False), (False, False)))
    assert sum(tally.moved) == len(both) < 20


def test_what_answers_another_question_is_not_counted(choice):
    answers = {"a": Answer(choice=9), "b": Answer(number=1.0), "c": Answer(place=(1.0, 2.0)), "d": Answer()}
    tally = tally_of(choice, {**answers, "e": Answer(choice=1)}, {})
    assert (tally.total, tally.counts, tally.places, tally.moved) == (1, (0, 1, 0), (), None)


def test_what_is_true_is_drawn_only_once_it_is_revealed(choice):
    tally = tally_of(choice, {"a": Answer(choice=0), "b": Answer(choice=1)}, {})
    hidden, revealed = (tally_html(tally, choice, shown) for shown in (False, True))
    assert "✓" not in hidden and "right" not in hidden
    assert revealed.count("✓") == 1 and "1 of 2 are right" in revealed


def test_numbers_are_counted_at_the_nearest_on_the_scale():
    stage = course_at("limits", "minimum").stage
    ask = stage.step.ask
    answers = {str(k): Answer(number=number) for k, number in enumerate((ask.low, ask.low, ask.high))}
    tally = tally_of(stage, {**answers, "x": Answer(number=ask.high * 2)}, {})
    assert tally.total == 3 and tally.counts[0] == 2 and tally.counts[-1] == 1 and sum(tally.counts) == 3
    assert tally_html(tally, stage, False).count(ANSWERS_NOW) == 2


def test_postures_are_a_cloud_in_the_plane_of_both_joints():
    truth = np.array([46.0, -90.0])
    ask = Pose(question="?", truth="place of the smallest E", near=5, close="", far="")
    stage = course_at("tour", "bowl").stage
    stage = dataclasses.replace(stage, step=msgspec.structs.replace(stage.step, ask=ask))
    assert np.allclose(MEASURES[ask.truth].of(stage), truth, atol=3)
    tally = tally_of(stage, {"a": Answer(place=(46.0, -90.0)), "b": Answer(place=(5.0, -5.0))}, {})
    assert tally.right == 1 and tally.places == ((46.0, -90.0), (5.0, -5.0))
    hidden, revealed = (tally_html(tally, stage, shown) for shown in (False, True))
    crosses = written_path(hidden, OTHERS_MARKS)
    assert crosses.count("M") == 2 and DEMONSTRATORS_POINTS not in hidden and DEMONSTRATORS_POINTS in revealed


def test_the_gain_is_of_those_who_could_gain():
    drawn = draw_moves((4, 4, 1, 3))
    gain = float(re.search(r"gain <b>([\d.]+)", drawn)[1])
    assert gain == pytest.approx((8 - 5) / (12 - 5), abs=0.005)
    heights = [float(one) for one in re.findall(r'<rect[^>]*height="([\d.]+)"', drawn)]
    assert heights == pytest.approx([500 / 12, 700 / 12, 800 / 12, 400 / 12], abs=0.06)
    assert "All were right at first" in draw_moves((3, 0, 2, 0)) and draw_moves((0, 0, 0, 0)) == ""
