"""The shipped lessons: their order, their times, their words, and questions that length does not answer."""

import pytest
from viewimit.app.lab.lessons import checks, source
from viewimit.app.lab.lessons.format import Choice, Place

LESSONS = source.shipped()
STEPS = [(name, step) for name, lesson in LESSONS.items() for step in lesson.step]
NAMES = [f"{name}/{step.id}" for name, step in STEPS]


@pytest.mark.parametrize("name", LESSONS)
def test_a_lesson_has_no_fault_in_its_scenes_either(name):
    assert not list(checks.faults_in_scenes(LESSONS[name]))


@pytest.mark.parametrize("name", LESSONS)
def test_the_minutes_are_those_of_a_reader_who_acts(name):
    least = checks.least_minutes(LESSONS[name])
    assert least <= LESSONS[name].minutes + 0.5 <= 1.5 * least + 1.5


@pytest.mark.parametrize(("name", "step"), STEPS, ids=NAMES)
def test_each_wrong_answer_gets_its_own_reply(name, step):
    ask = step.ask
    answers = ask.answers if isinstance(ask, Choice) else ()
    replies = [answer.because for answer in answers]
    if isinstance(ask, Place):
        replies = [ask.close, ask.far, *(other.because for other in ask.elsewhere)]
    assert len(set(replies)) == len(replies) and all(len(reply.split()) >= 4 for reply in replies)
