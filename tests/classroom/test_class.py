"""A class without browsers: what the lecturer does, what the students' pages make of it, and what comes back."""

import csv
import io

import numpy as np
import pytest
from class_pages import NAME, Class
from drawn import OTHERS_MARKS, RIGHT_ANSWERS, TALLY
from quiet_page import QuietPage
from viewimit.app.classroom.board import LED_S
from viewimit.app.classroom.classroom import Classroom
from viewimit.app.classroom.member import Member, Seen
from viewimit.app.classroom.messages import Summary
from viewimit.app.control.classroom.following import rest
from viewimit.app.control.commands.classroom import NameYourself, OfClass
from viewimit.app.control.commands.display import FitView
from viewimit.app.control.commands.lessons import BeginLesson, InLesson, LeaveLesson
from viewimit.app.control.commands.method import change_transfer
from viewimit.app.control.commands.session import Play, PoseJoint, Reset, Step, Undo
from viewimit.app.control.memory import memory_of

from viewimit.loop.script import ChangeSettings, MoveDemonstrator, Script, Steps
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings


@pytest.fixture
def of():
    return Class(students=2)


def model(page):
    return page.page.model


def step(page, count=1):
    for _ in range(count):
        page.page.put(Step())
        page.tick(0.6)


def same(one, other):
    """To the last bit, and by the same way."""
    here, there = model(one).session, model(other).session
    assert here.snapshot.theta.tobytes() == there.snapshot.theta.tobytes()
    assert here.snapshot.E == there.snapshot.E and here.settings == there.settings
    assert here.script == there.script
    return True


def test_who_leads_is_followed_motion_for_motion_and_back(of):
    lecturer, (student, other) = of.lecturer, of.students
    step(student, 2)
    own = model(student).session.snapshot
    step(lecturer, 3)
    of.do("lead")
    assert same(student, lecturer) and same(other, lecturer)
    for command in (Play(), Play(), PoseJoint.parse(0, 30), PoseJoint.parse(1, -80), Undo(), Step(), Step(), Reset()):
        lecturer.page.put(command)
        of.go_on(2.0)
        assert same(student, lecturer) and same(other, lecturer)
    lecturer.page.put(change_transfer("Projective combination"))
    step(lecturer)
    of.go_on()
    assert same(student, lecturer) and model(student).session.settings.transfer == "projective"
    of.do("lead")  # let go
    assert model(student).role.holds is None
    student.page.put(Undo())
    of.go_on(0.5)
    assert model(student).session.snapshot.theta.tobytes() == own.theta.tobytes()


def test_who_reloads_while_all_follow_follows_on_and_has_their_own_back_when_the_lecturer_lets_go(of):
    lecturer, (student, _) = of.lecturer, of.students
    student.choose("Preset", "Linear combination of views")
    step(student, 2)
    own = model(student).session.snapshot
    step(lecturer, 3)
    of.do("lead")
    assert same(student, lecturer)
    student.page.close()
    kept = memory_of(model(student))
    of.students[0] = again = of.open(key="student 0", resumed=kept)
    of.go_on()
    assert same(again, lecturer) and model(again).role.holds is not None
    of.do("lead")  # let go
    step(again)
    assert memory_of(model(again)).history[-1].motion == model(again).session.cursor == 4
    for _ in range(2):
        again.page.put(Undo())
        of.go_on(0.5)
    assert model(again).session.snapshot.theta.tobytes() == own.theta.tobytes()
    assert model(again).session.settings == own.settings and model(again).preset.name == "Linear combination of views"


def test_who_comes_late_follows_too_and_what_was_sent_before_is_not_sent_again(of):
    step(of.lecturer, 2)
    of.do("send")
    of.do("reset")
    of.do("reset")
    assert same(of.students[0], of.students[1]) and model(of.students[0]).session.cursor == 0
    of.students.append(of.open(key="late"))
    of.go_on()
    assert model(of.students[2]).session.script == Session(Settings.paper()).script
    of.do("lead")
    of.students.append(of.open(key="later"))
    of.go_on()
    assert same(of.students[3], of.lecturer)


def test_controls_are_locked_while_all_follow_or_are_frozen_but_views_are_not(of):
    student = of.students[0]
    for verb, words in (("lead", "leads"), ("freeze", "frozen")):
        of.do(verb)
        before, fits = model(student).session.snapshot, model(student).view.fits
        for command in (Step(), PoseJoint.parse(0, 10), Play(), BeginLesson("tour"), FitView()):
            student.page.put(command)
            of.go_on(0.5)
        assert words in model(student).message.text and model(student).session.snapshot is before
        assert model(student).view.fits == fits + 1 and words in student.shown.lower()
        of.do(verb)
        student.page.put(Step())
        of.go_on(1.0)
        assert model(student).session.cursor > before.motion
        student.page.put(Reset())


def test_a_lecturer_who_goes_away_lets_go_and_one_who_comes_back_leads(of):
    of.do("lead")
    of.do("freeze")
    student = of.students[0]
    assert model(student).role.holds is not None
    of.lecturer.page.close()
    left, of.lecturer = of.lecturer, of.students[1]  # nobody else sees to it
    of.students.pop()
    of.go_on(LED_S + 2)
    assert model(student).role.holds is None
    of.lecturer = of.open(lecturer=True)
    of.go_on()
    assert model(of.lecturer).role.leads and not model(of.lecturer).role.orders.frozen
    assert model(student).role.holds is None and left is not of.lecturer


def test_of_two_pages_of_the_lecturer_the_newest_leads_and_the_other_is_told(of):
    first, of.lecturer = of.lecturer, of.open(lecturer=True)
    of.students.append(first)  # is ticked as well
    of.go_on()
    assert model(of.lecturer).role.leads and "Another of your pages leads" in first.shown
    first.page.put(OfClass("freeze"))
    of.go_on()
    assert "another of the lecturer's pages" in model(first).message.text
    assert model(of.students[0]).role.holds is None
    first.page.put(OfClass("take"))
    of.go_on()
    assert model(first).role.leads and "Another of your pages leads" in of.lecturer.shown


def test_the_lecturer_sees_who_is_here_and_opens_a_copy(of):
    student = of.students[0]
    student.page.put(NameYourself.parse(" Mira  "))
    step(student, 3)
    of.go_on()
    lecturer = model(of.lecturer).role
    seen = {one.name: one for one in lecturer.seen.students}
    mira = seen["Mira"]
    assert set(seen) == {"Mira", ""} and mira.motions == 3 and len(mira.path) == 8 and mira.state == "paused"
    assert mira.off == round(float(np.degrees(np.abs(np.subtract(*_postures(student))).max())), 2)
    assert (
        "2 here" in of.lecturer.shown and "Mira" in of.lecturer.shown and f"class/open,{mira.id}" in of.lecturer.shown
    )
    of.do(f"open,{mira.id}", 3.0)
    assert same(of.lecturer, student)
    of.do("sort,motions")
    assert lecturer.view(0.0).students[0] == mira
    student.page.close()
    of.students.pop(0)
    of.go_on()
    assert "1 here" in of.lecturer.shown


def _postures(page):
    present = model(page).session.snapshot
    return present.theta, present.theta_demo


def test_nobody_but_the_lecturer_gives_orders(of):
    student = of.students[0]
    for verb in ("lead", "freeze", "ask", "save", "take"):
        student.page.put(OfClass.parse(verb))
        of.go_on(0.5)
        assert "not the lecturer's" in model(student).message.text
    assert model(of.students[1]).role.holds is None
    alone = QuietPage()
    alone.page.put(OfClass.parse("lead"))
    alone.tick()
    assert "not the lecturer's" in alone.page.model.message.text


def answer(of, *choices):
    for page, choice in zip(of.students, choices):
        page.page.put(InLesson("choose", (float(choice),)))
    of.go_on(3.0)


def test_a_question_is_asked_counted_revealed_and_asked_again():
    of = Class(students=4)
    student = of.students[0]
    student.page.put(BeginLesson("limits"))
    step(of.students[1], 2)
    of.lecturer.page.put(BeginLesson("tour"))
    of.go_on(0.5)
    model(of.lecturer).guided.go_to_step("tour", "arrows")
    of.do("ask")
    course = model(student).guided.course
    assert course.step.id == "arrows" and not course.given.revealed
    for command in (InLesson("next"), InLesson("show"), LeaveLesson()):
        student.page.put(command)
        of.go_on(0.25)
    assert model(student).guided.course is course and not course.given.revealed
    answer(of, 0, 1, 1)
    tally = model(of.lecturer).role.view(0.0).tally
    assert (tally.total, tally.counts) == (3, (1, 2, 0)) and "3</b> of 4 answered" in of.lecturer.shown
    assert TALLY not in of.lecturer.shown + student.shown
    of.do("tell")
    assert TALLY in of.lecturer.shown and RIGHT_ANSWERS not in of.lecturer.shown
    of.do("again")
    assert "0</b> of 4 answered" in of.lecturer.shown and model(student).guided.course.given.choice is None
    answer(of, 0, 0, 1, 0)
    of.do("reveal", 3.0)
    tally = model(of.lecturer).role.view(0.0).tally
    assert (tally.total, tally.counts, tally.right, tally.moved) == (4, (3, 1, 0), 3, (1, 1, 0, 1))
    for page in (of.lecturer, student):
        assert "1 moved from wrong to right" in page.shown and RIGHT_ANSWERS in page.shown
    files = []
    of.lecturer.page.model.send = lambda name, data: files.append((name, data.decode()))
    of.do("save")
    rows = list(csv.DictReader(io.StringIO(files[0][1])))
    assert [row["asked"] for row in rows] == ["1"] * 3 + ["2"] * 4 and {row["step"] for row in rows} == {"arrows"}
    moves = {row["person"]: [] for row in rows}
    for row in rows:
        moves[row["person"]].append(row["number"])
    assert sorted(map(tuple, moves.values())) == [("1",), ("1", "1"), ("2", "1"), ("2", "2")]
    assert not any(one.id in files[0][1] for one in model(of.lecturer).role.seen.students)
    of.do("close")
    assert model(student).guided.course.lesson.short == model(student).guided.lessons["limits"].short
    assert model(of.students[1]).guided.course is None and model(of.students[1]).session.cursor == 2


@pytest.mark.parametrize("comes_back", ["before it is known", "later"])
def test_a_question_ends_with_the_lecturer_who_asked_it(of, comes_back):
    of.lecturer.page.put(BeginLesson("limits"))
    of.go_on(0.5)
    of.lecturer.page.put(InLesson("next"))
    of.go_on(0.5)
    step_shown = model(of.lecturer).guided.course.step.id
    of.do("ask")
    student = of.students[0]
    assert model(student).guided.asked and model(student).role.holds is not None
    of.lecturer.page.close()
    of.lecturer = of.students.pop()
    if comes_back == "later":
        of.go_on(LED_S + 2)
        new = of.open(key="a newcomer")
        of.students.append(new)
        of.go_on()
        for page in of.students:
            assert model(page).guided.course is None and model(page).role.holds is None
    of.lecturer = of.open(lecturer=True)
    of.go_on()
    asked = model(of.lecturer).role.orders.asked
    if comes_back == "later":
        assert asked is None and not model(student).guided.asked
    else:
        assert asked.round.step == step_shown and model(student).guided.asked


def test_a_question_that_goes_on_is_shown_wherever_the_lecturer_is_and_can_be_closed(of):
    of.lecturer.page.put(BeginLesson("tour"))
    of.go_on(0.5)
    model(of.lecturer).guided.go_to_step("tour", "arrows")
    of.do("ask")
    waits = "The class is asked.</b> 2 pages wait until the question is closed."
    assert waits not in of.lecturer.shown  # the card says it
    of.lecturer.page.put(LeaveLesson())
    of.do("lead")
    assert waits in of.lecturer.shown and "follow this one" not in of.lecturer.shown
    assert not any(model(page).role.follows for page in of.students)
    of.do("close")
    assert waits not in of.lecturer.shown and "2 pages follow this one" in of.lecturer.shown
    assert all(model(page).role.follows for page in of.students)


def test_who_rests_where_E_is_not_0_is_not_counted_as_there(of):
    counts = {"settled": "1 at rest", "arrived": "1 there"}
    for state, words in counts.items():
        seen = Seen(students=(Summary(id="0" * 16, state=state, E=45.0),))
        model(of.lecturer).role.see(seen)
        of.lecturer.tick(0.25)
        assert [other in of.lecturer.shown for other in counts.values()] == [one == words for one in counts.values()]


def test_clicks_of_a_class_are_a_cloud_in_the_figure_of_all_once_it_is_revealed():
    of = Class(students=2)
    of.lecturer.page.put(BeginLesson("tour"))
    of.go_on(0.5)
    model(of.lecturer).guided.go_to_step("tour", "crossing")
    of.do("ask")
    for page, x in zip(of.students, (100.0, 200.0)):
        page.page.put(InLesson("place", (x, 250.0)))
    of.go_on(3.0)
    assert OTHERS_MARKS not in of.students[0].shown + of.lecturer.shown
    of.do("reveal", 3.0)
    places = model(of.lecturer).role.view(0.0).tally.places
    given = [model(page).guided.course.given.place for page in of.students]
    assert np.allclose(sorted(places), sorted(given), atol=0.051)
    assert all(OTHERS_MARKS in page.shown for page in of.pages)


def test_what_a_student_has_answered_elsewhere_is_not_touched_by_a_question(of):
    student = of.students[0]
    student.page.put(BeginLesson("tour"))
    of.go_on(0.25)
    model(student).guided.go_to_step("tour", "eyes")
    student.page.put(InLesson("choose", (2.0,)))
    of.go_on(0.25)
    before = model(student).guided.kept
    of.lecturer.page.put(BeginLesson("tour"))
    of.go_on(0.25)
    model(of.lecturer).guided.go_to_step("tour", "eyes")
    of.do("ask")
    answer(of, 0)
    assert model(student).guided.kept == before and memory_of(model(student)).head.lesson == "tour"
    of.do("close")
    assert model(student).guided.kept == before and not model(student).guided.asked


def test_a_lesson_of_the_lecturer_is_followed_screen_for_screen(of):
    of.do("lead")
    of.lecturer.page.put(BeginLesson("limits"))
    of.go_on()
    for _ in range(2):
        of.lecturer.page.put(InLesson("next"))
        of.go_on()
        courses = [model(page).guided.course for page in of.pages]
        assert len({(course.progress.lesson, course.progress.at) for course in courses}) == 1
    of.lecturer.page.put(LeaveLesson())
    of.go_on()
    assert all(model(page).guided.course is None for page in of.pages) and same(of.students[0], of.lecturer)


class Broken:
    """A store that does not answer."""

    look_every = 0.1

    def __getattr__(self, name):
        def fails(*_):
            raise OSError("the store is away")

        return fails


def test_a_store_that_fails_is_told_to_the_lecturer_with_one_line_in_the_log(caplog):
    seen = []
    classroom = Classroom(Broken(), NAME)
    classroom.join(Member("0" * 16, lambda heard: None, seen.append))
    for _ in range(3):
        classroom.turn()
    assert [one.problem for one in seen] == ["the store is away"] and len(caplog.records) == 1


def test_an_id_is_the_same_when_a_page_comes_back_and_tells_nothing_of_its_key(of):
    assert of.classroom.id_of("key") == of.classroom.id_of("key") != of.classroom.id_of("other")
    assert of.classroom.id_of("key") != Classroom(of.board, "d" * 32).id_of("key")
    assert of.classroom.id_of(None) != of.classroom.id_of(None)


@pytest.mark.parametrize("points, state, words", [(5, "unobservable", "1 stuck"), (10, "arrived", "1 there")])
def test_the_class_is_shown_at_which_status_a_student_ends(points, state, words):
    of = Class(students=1, settings=Settings(points=points, start_deg=(25, -45)))
    step(of.students[0], 30)
    of.go_on()
    assert model(of.students[0]).role.summary.state == state
    assert f'data-state="{state}"' in of.lecturer.shown and words in of.lecturer.shown


def test_a_summary_is_small_whatever_was_done(of):
    student = of.students[0]
    step(student, 30)
    of.go_on()
    summary = model(student).role.summary
    from viewimit.app.classroom.messages import MOST_SUMMARY, encode

    assert isinstance(summary, Summary) and len(encode(summary)) < MOST_SUMMARY / 2


SETTINGS = Session(Settings.paper()).settings
ACTIONS = (Steps(2), MoveDemonstrator((0.5, -1.0)), Steps(1), ChangeSettings({"noise_px": 0.5}), Steps(3))


@pytest.mark.parametrize("count", range(len(ACTIONS) + 1))
def test_the_rest_of_a_script_leads_on_to_the_same_state(count):
    whole, begun = Session(Settings.paper()), Session(Settings.paper())
    whole.play(Script(SETTINGS, ACTIONS))
    begun.play(Script(SETTINGS, ACTIONS[:count]))

    for action in rest(begun.script, whole.script):
        begun.do(action)
    assert begun.snapshot.theta.tobytes() == whole.snapshot.theta.tobytes() and begun.script == whole.script


def test_what_went_elsewhere_has_no_rest():
    done = Script(SETTINGS, (Steps(3),))
    assert rest(done, Script(SETTINGS, (Steps(2), MoveDemonstrator((0.5, -1.0))))) is None
    assert rest(done, Script(Settings.paper(seed=1), (Steps(4),))) is None
    assert rest(done, done) == () and rest(done, Script(SETTINGS, (Steps(4),))) == (Steps(1),)
