"""The lesson on carrying a motion over: what it reveals is what happens, by another computation."""

import re

import msgspec
import numpy as np
import pytest
from viewimit.app.lessons.card import draw_lesson
from viewimit.app.lessons.course import Course
from viewimit.app.lessons.measures import MEASURES
from viewimit.app.lessons.measures.carried import ELSEWHERE, LIKE, OTHER
from viewimit.app.lessons.playing import PLAYED
from viewimit.app.lessons.progress import Progress
from viewimit.app.lessons.source import shipped
from viewimit.app.lessons.works import WORKS
from viewimit.app.lessons.works.work import Task
from walking import at_once

from viewimit.loop.session import Session
from viewimit.loop.settings import Settings


def begun():
    return Course(shipped()["motion"], Progress(lesson="motion"), at_once)


@pytest.fixture(scope="module")
def course():
    return begun()


def told(course, name):
    return MEASURES[name].of(course.stage)


def go_to(course, step):
    ids = [screen.id for screen in course.screens]
    while (away := ids.index(step) - ids.index(course.screen.id)) != 0:
        assert course.go(int(np.sign(away)))


def hands_of(course, thetas, base, cameras):
    """(T, 2, 2) px: the last link's origin, camera by camera."""
    world = course.session.world
    ends = np.array([world.link_frames(theta, base)[-1, :3, 3] for theta in thetas]).T
    return np.stack([camera.project(ends)[0].T for camera in cameras], 1)


def test_it_is_walked_from_begin_to_end():
    course = begun()
    go_to(course, "frozen")
    for answer in (lambda: course.choose(0), lambda: course.guess(5)):
        with pytest.raises(ValueError, match="an answer comes first"):
            course.show()
        assert "Now you can say" not in draw_lesson(course, "/x")
        answer()
        course.show()
        drawn = draw_lesson(course, "/x")
        assert "Now you can say" in drawn and "–" not in re.sub("<[^>]+>", "", drawn), "every number is computed"
        course.go(1)


@pytest.mark.parametrize(("step", "start"), [("frozen", (30, -70)), ("overlap", (35, -90))])
def test_what_is_told_of_the_early_geometry_is_what_happens(course, step, start):
    go_to(course, step)
    world, run = course.session.world, course.stage.made["carried"].early.run
    session = Session(Settings.paper(demonstrator_deg=(45, -90), start_deg=start))
    np.testing.assert_array_equal(np.degrees(session.snapshot.theta).round(9), start)
    demo = hands_of(course, run.theta_demo, world.T_world_demo, world.demo_cameras)
    own = hands_of(course, run.theta, world.T_world_own, world.own_cameras)
    should = session.snapshot.transfer.recover(demo[:, 0], demo[:, 1])
    off = np.hypot(*(own.reshape(-1, 4) - should).reshape(-1, 2, 2).transpose(2, 0, 1)).mean(1)
    assert told(course, "px overlap, frozen early") == pytest.approx(np.median(off))
    hands = [world.link_frames(theta, np.eye(4))[-1, :3, 3] for theta in (*run.theta, *run.theta_demo)]
    apart = np.linalg.norm(np.subtract(*np.array(hands).reshape(2, -1, 3)), axis=1)
    assert told(course, "mm apart, frozen early") == pytest.approx(1e3 * np.median(apart))
    assert told(course, "off when frozen early") == pytest.approx(np.abs(np.subtract(start, (45, -90))).max())


def test_the_circle_has_the_width_that_is_told(course):
    go_to(course, "frozen")
    demo = course.stage.made["carried"].right.demo_side[:, -1]
    assert told(course, "circle's width") == pytest.approx(1e3 * np.ptp(demo, 0).max(), rel=0.01)


def test_a_loop_comes_over_near_where_the_arm_stood_and_not_where_the_demonstrator_stands(course):
    go_to(course, "frozen")
    early = course.stage.made["carried"].early
    assert told(course, "what the early geometry draws") == ELSEWHERE
    first = np.degrees(early.run.theta[0])
    assert np.abs(first - (30, -70)).max() < 0.5 * np.abs(first - (45, -90)).max()
    assert told(course, "mm apart, frozen early") > 20 * told(course, "mm apart, frozen at agreement")
    assert told(course, "mm apart, frozen at agreement") < 10


def test_the_wrong_geometry_overlaps_as_well_as_the_right_one_while_hands_are_a_hand_apart(course):
    go_to(course, "overlap")
    assert told(course, "px overlap, frozen early") < 1
    assert told(course, "px overlap, frozen early") <= told(course, "px overlap, frozen at agreement")
    assert told(course, "mm apart, frozen early") > 10 * told(course, "mm apart, frozen at agreement")
    assert told(course, "px from the true path, frozen early") > 10


@pytest.mark.parametrize(("start", "drawn"), [((45, -90), LIKE), ((30, -70), ELSEWHERE), ((25, -25), OTHER)])
def test_which_answer_is_right_is_computed(course, start, drawn):
    go_to(course, "frozen")
    session = Session(Settings.paper(demonstrator_deg=(45, -90), start_deg=start, transfer="projective"))
    made = WORKS["carried"].make(Task(course.step, session.world, session.snapshot, session.settings, {}, 1))
    stage = course.stage
    object.__setattr__(stage, "made", {"carried": made})
    assert MEASURES["what the early geometry draws"].of(stage) == drawn


def test_it_waits_for_the_answer_and_is_then_played_motion_by_motion():
    course = Course(shipped()["motion"], Progress(lesson="motion"), at_once)
    go_to(course, "frozen")
    course.tick(0.0)
    assert course.played == 0, "nothing moves before the answer"
    course.choose(1)
    course.show()
    paths = set()
    for k in range(PLAYED):
        paths.add(draw_lesson(course, "/x"))
        course.tick(float(k))
    assert len(paths) == PLAYED and course.stage.played is None
    course.tick(1e3)
    assert course.played == PLAYED


def test_while_it_is_computed_the_step_says_so_and_marks_no_answer():
    given = Progress(lesson="motion")
    course = Course(shipped()["motion"], given, lambda name, make, take: None)
    go_to(course, "frozen")
    course.choose(1)
    course.show()
    drawn = draw_lesson(course, "/x")
    assert "the circle is being drawn" in drawn and "✓" not in drawn


def test_too_few_points_are_told():
    few = msgspec.structs.replace(Settings.paper(), missing=0.9, start_deg=(30.0, -70.0))
    session = Session(few)
    with pytest.raises(ValueError, match="too few points"):
        WORKS["carried"].make(Task(None, session.world, session.snapshot, session.settings, {}, 1))
