"""The shipped lessons: their order, their times, their words, and questions that length does not answer."""

import re

import pytest
from viewimit.app.lab.lessons import checks, source
from viewimit.app.lab.lessons.format import Choice, Do, Place, texts_with_measures
from viewimit.app.lab.lessons.page import terms

LESSONS = source.shipped()
STEPS = [(name, step) for name, lesson in LESSONS.items() for step in lesson.step]
NAMES = [f"{name}/{step.id}" for name, step in STEPS]
BOLD = re.compile(r"\*\*(.+?)\*\*")
WITH_UNIT = re.compile(r"\d+(?:\.\d+)?(?: ?(?:°|px|mm|cm|m|%|steps|degrees))(?!\w)")
TERMS_OF_THE_FIELD = (
    *("epipolar line", "correspondences", "fundamental matrix", "affine camera", "baseline", "rectification"),
    *("image Jacobian", "visual servoing", "residual", "conditioning", "bias", "noise", "perspective"),
)
THOUGHT_OF = {  # numbers that a step supposes, and no picture shows
    "jacobian/turned": {"90°", "180°", "2 px"},  # a fixed state; the goal of a turn
    "sign/sign": {"1°", "50 %"},  # the claim; a bet without an idea
    "limits/crossing-angle": {"95 %"},  # what an ellipse is
}


def test_lessons_go_from_the_ray_to_the_claim():
    assert list(LESSONS) == ["ray", "tour", "limits", "jacobian", "motion", "sign"]
    assert [lesson.questions for lesson in LESSONS.values()] == [name == "tour" for name in LESSONS]


@pytest.mark.parametrize("name", LESSONS)
def test_a_lesson_has_no_fault_in_its_scenes_either(name):
    assert not list(checks.faults_in_scenes(LESSONS[name]))


@pytest.mark.parametrize("name", LESSONS)
def test_the_minutes_are_those_of_a_reader_who_acts(name):
    least = checks.least_minutes(LESSONS[name])
    assert least <= LESSONS[name].minutes + 0.5 <= 1.5 * least + 1.5


@pytest.mark.parametrize(("name", "step"), STEPS, ids=NAMES)
def test_a_step_says_no_number_that_could_be_computed(name, step):
    for where, words in texts_with_measures(step):
        found = set(WITH_UNIT.findall(re.sub(r"\{[^{}]*\}", "", words)))
        assert found <= THOUGHT_OF.get(f"{name}/{step.id}", set()), where


@pytest.mark.parametrize(("name", "step"), STEPS, ids=NAMES)
def test_each_wrong_answer_gets_its_own_reply(name, step):
    ask = step.ask
    answers = ask.answers if isinstance(ask, Choice) else ()
    replies = [answer.because for answer in answers]
    if isinstance(ask, Place):
        replies = [ask.close, ask.far, *(other.because for other in ask.elsewhere)]
    assert len(set(replies)) == len(replies) and all(len(reply.split()) >= 4 for reply in replies)


def test_the_fields_terms_are_named_in_bold_and_explained():
    bold = {word.lower() for _, step in STEPS for _, words in texts_with_measures(step) for word in BOLD.findall(words)}
    said = " ".join(words for _, step in STEPS for _, words in texts_with_measures(step))
    known = {term.lower() for term in terms()}
    for term in TERMS_OF_THE_FIELD:
        assert term.lower() in known, term
        named = {"conditioning": "ill-conditioned", "correspondences": "matched points"}.get(term, term.lower())
        assert named in bold, term
    assert "correspondences" in said


def test_all_kinds_of_questions_are_asked():
    kinds = {type(step.ask).__name__ for _, step in STEPS}
    assert kinds == {"Choice", "Place", "Number", "Do", "Pose", "Predict", "Bet"}


def test_no_question_in_a_lesson_is_answered_by_the_longest_text_as_a_rule():
    choices = [step.ask.answers for _, step in STEPS if isinstance(step.ask, Choice) and step.ask.right is None]
    longest = sum(max(answers, key=lambda answer: len(answer.text)).right for answers in choices)
    assert longest <= len(choices) / 3


def test_the_right_answer_is_the_longest_in_two_of_eight_at_most():
    items = source.questions().item
    assert sum(max(item.answers, key=lambda answer: len(answer.text)).right for item in items) <= 2


def test_each_wrong_answer_of_the_eight_questions_is_a_belief_of_its_own():
    for item in source.questions().item:
        beliefs = [answer.belief for answer in item.answers if not answer.right]
        assert len(set(beliefs)) == 3 and all(re.fullmatch(r"[a-zE-][\w-]+", belief) for belief in beliefs)


def test_goals_are_where_a_deal_can_reach_them():
    """A goal for E is above twice the least E of the sampled demonstrators, which is below 1.5 px²."""
    for _, step in STEPS:
        if isinstance(step.ask, Do) and step.randomise:
            assert step.ask.below is not None and step.ask.below >= 3
