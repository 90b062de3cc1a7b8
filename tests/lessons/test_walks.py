"""Every shipped lesson, walked from begin to end: all that is to be done can be, all that is told is computed, and who
comes back finds all as it was left."""

import re

import msgspec
import numpy as np
import pytest
from sameness import assert_same
from viewimit.app.lessons import figures, measures, works
from viewimit.app.lessons.card import draw_lesson
from viewimit.app.lessons.course import MOST_SEED, Course
from viewimit.app.lessons.format import MOST_WORDS, Choice, Do, Lesson, Place, Select
from viewimit.app.lessons.measures import MEASURES
from viewimit.app.lessons.progress import Given, Progress
from viewimit.app.lessons.reading import WORDS_A_MINUTE, reading_minutes
from viewimit.app.lessons.source import shipped
from viewimit.app.static import stylesheet
from walking import ADDRESS, answer, begun, said, unfilled, words, works_kept

LESSONS = shipped()
PHONE, LOW = {"width": 390, "height": 844}, {"width": 1280, "height": 720}
LABELS = """html => {
  document.body.innerHTML = html;
  const faults = [], sides = ["left", "right", "top", "bottom"];
  for (const svg of document.querySelectorAll(".vi-guide-stage svg")) {
    const drawing = svg.getBoundingClientRect(), seen = [];
    for (const text of svg.querySelectorAll("text")) {
      const box = text.getBoundingClientRect(), scale = Math.hypot(text.getScreenCTM().a, text.getScreenCTM().b);
      if (!text.textContent.trim() || !box.width) continue;
      const px = parseFloat(getComputedStyle(text).fontSize) * scale, spare = Math.max(0, box.height - px) * 0.55;
      const [top, bottom] = [box.top + spare, box.bottom - spare];
      const it = {words: text.textContent, left: box.left, right: box.right, top, bottom};
      if (px < 11) faults.push(`${it.words}: ${px.toFixed(1)} px`);
      if (it.left < drawing.left - 1 || it.right > drawing.right + 1) faults.push(`${it.words}: cut off`);
      for (const one of seen)
        if (Math.min(it.right, one.right) - Math.max(it.left, one.left) > 0.5 &&
            Math.min(it.bottom, one.bottom) - Math.max(it.top, one.top) > 0.5 && it.words !== one.words)
          faults.push(`${it.words} on ${one.words}`);
      seen.push(it);
    }
  }
  return faults;
}"""
drawn_narrow = {}  # screens as a phone shows them, once they are answered, by the lesson's name
decode = msgspec.msgpack.Decoder(Progress).decode


@pytest.fixture(scope="module", autouse=True)
def few_rounds():
    """Twenty of them take a minute, and are walked by nobody twice; `test_rounds` sees to what they come to."""
    with pytest.MonkeyPatch.context() as patch:
        for room in (works.rounds, measures.rounds, figures.rounds):
            patch.setattr(room, "ROUNDS", 3)
        yield


@pytest.fixture(scope="module", autouse=True)
def kept_works(few_rounds):
    """All of these walks lead through the same works."""
    with works_kept():
        yield


@pytest.fixture(scope="module", params=LESSONS)
def name(request):
    return request.param


@pytest.fixture(scope="module")
def walks(name, kept_works):
    """All of a lesson's screens, answered rightly, and answered wrongly."""
    found, drawn_narrow[name] = [], []
    for rightly in (True, False):
        course, screens = begun(LESSONS[name]), []
        for _ in course.screens:
            before = words(course)
            if course.screen.kind != "end":
                answer(course, rightly)
            told = {m: MEASURES[m].told(course.stage) for m in said(course)} if course.step else {}
            course.fit(narrow=True)
            drawn_narrow[name].append((course.screen.id, draw_lesson(course, ADDRESS)))
            course.fit(narrow=False)
            screens.append((course.screen, before, words(course), told, course.given, course.progress))
            course.go(1)
        found.append(screens)
    return found


def test_it_is_walked_to_its_end(name, walks):
    for screens in walks:
        assert len(screens) == len(begun(LESSONS[name]).screens)
        assert all(given.revealed for screen, *_, given, _ in screens if screen.kind == "step")


@pytest.mark.browser
def test_labels_on_a_phone_are_large_enough_and_do_not_touch(name, walks, browser):
    """In all drawings of all screens, answered rightly and wrongly: 11 px and more."""
    page = browser.new_page(viewport=PHONE)
    page.set_content(f"<style>body{{margin:0}}{stylesheet()}</style>")
    faults = {id: found for id, html in drawn_narrow[name] if (found := page.evaluate(LABELS, html))}
    page.close()
    assert faults == {}


@pytest.mark.browser
def test_what_is_told_of_an_answer_is_seen_without_scrolling_in_a_low_window(name, walks, browser):
    page = browser.new_page(viewport=LOW)
    page.set_content(f"<style>body{{margin:0}}{stylesheet()}</style>")
    hidden = "html => { document.body.innerHTML = html; const c = document.querySelector('.vi-guide-card');"
    hidden += " return c.scrollHeight - c.clientHeight; }"
    cut = {id: px for id, html in drawn_narrow[name] if (px := page.evaluate(hidden, html)) > 0}
    page.close()
    assert cut == {}


def test_all_that_is_to_be_done_can_be(name, walks):
    asked = {step.id for step in LESSONS[name].step if isinstance(step.ask, Do)}
    done = {screen.id for screen, *_, given, _ in walks[0] if given.done}
    assert done == asked


def test_all_that_is_told_is_computed(walks):
    for screens in walks:
        for screen, before, after, told, *_ in screens:
            assert not unfilled(before.replace("computing …", "")) and not unfilled(after), (screen.id, before, after)
            assert all(value != "–" for value in told.values()), (screen.id, told)


def test_what_is_right_is_called_right(name, walks):
    """Of the questions before and after, all or none; of a step, what is said meets the answer."""
    count = len(LESSONS[name].question)
    steps = {step.id: step.ask for step in LESSONS[name].step}
    for screens, rightly in zip(walks, (True, False)):
        right = count if rightly else 0
        if count:
            assert f"{right} of {count} were right before, {right} of {count} after." in screens[-1][2]
        for screen, _, after, _, given, _ in screens:
            ask = steps.get(screen.id)
            if isinstance(ask, Choice):
                assert after.count("✓") == 1 and after.count("✗") == (not rightly)
                assert constant(ask.answers[given.choice].because) in after
            elif isinstance(ask, Place) and rightly:
                assert constant(ask.close) in after


def constant(words):
    """Their longest part without a number that is computed."""
    return max(re.sub(r"\*\*", "", words).replace("}", "{").split("{")[::2], key=len).strip()


def test_words_are_few_and_read_in_its_time(name):
    lesson = LESSONS[name]
    assert all(len(step.text.split()) <= MOST_WORDS for step in lesson.step)
    assert lesson.minutes >= reading_minutes(lesson) - 0.5


def test_reading_time_is_that_of_the_words():
    step = {"id": "a", "title": "one two", "text": "three four", "say": "five"}
    asked = {"kind": "number", "question": "six", "unit": "", "low": 1, "high": 2, "truth": "E"}
    asked |= {"close": "seven", "far": "seven eight", "within": 1}
    fields = {"title": "-", "short": "-", "about": "-", "minutes": 1, "step": [{**step, "ask": asked}]}
    assert reading_minutes(msgspec.convert(fields, Lesson)) == 8 / WORDS_A_MINUTE


def test_who_comes_back_is_where_one_was(name, walks):
    """What is kept and read again shows the same screen, the same answers, and for the same postures the same E."""
    for screens in walks:
        for k in {min(1, len(screens) - 1), len(screens) // 2, max(len(screens) - 2, 0), len(screens) - 1}:
            screen, _, after, *_, progress = screens[k]
            course = begun(LESSONS[name], progress=decode(msgspec.msgpack.encode(progress)))
            course.tick(0.0, still=True)
            assert course.progress == progress and course.screen == screen
            assert words(course) == after


def test_back_and_on_again_change_no_answer(name, walks):
    progress = walks[0][-1][-1]
    course = begun(LESSONS[name], progress=progress)
    for by in (-1, 1):
        for _ in course.screens:
            course.go(by)
    assert course.progress == progress
    assert not course.go(1) and course.screen == course.screens[-1]


def test_before_a_class_a_lesson_goes_on_though_nobody_answers(name):
    """What is true is shown first, where it needs no answer, and nothing is told that needs one."""
    course = begun(LESSONS[name])
    for screen in course.screens[:-1]:
        asks = course.step and course.step.ask and not isinstance(course.step.ask, Do | Select)
        if asks:
            course.present()
            assert course.screen == screen and course.given.revealed and course.given.choice is None
            assert "✗" not in words(course) and not unfilled(words(course).replace("computing …", ""))
        course.present()
        assert course.screen != screen
    assert course.screen == course.screens[-1]


def test_every_step_can_be_skipped(name):
    course = begun(LESSONS[name])
    for _ in course.screens[:-1]:
        assert course.go(1)
        assert not unfilled(words(course).replace("computing …", ""))
    assert course.screen == course.screens[-1]


def test_a_start_has_a_number_that_others_can_play(name):
    for k, step in enumerate(LESSONS[name].step):
        if not step.deal:
            continue
        starts = {}
        for seed in (3, 4, 3, MOST_SEED):
            course = at_step(name, k)
            course.again(seed)
            starts.setdefault(seed, []).append(course.moments[0].theta)
            assert course.given.seed == seed and f'value="{seed}"' not in words(course)
        assert_same(*starts[3])
        assert (starts[3][0] != starts[4][0]).any() and (starts[3][0] != starts[MOST_SEED][0]).any()
        course.again()
        assert course.given.seed == 1
        for seed in (0, -3, MOST_SEED + 1, 10**300):
            kept = course.progress
            with pytest.raises(ValueError, match="from 1 to"):
                course.again(seed)
            assert course.progress == kept


def at_step(name, k):
    course = begun(LESSONS[name])
    course.go(len(LESSONS[name].question) + k)
    return course


def test_again_begins_without_what_was_done(name):
    for k, step in enumerate(LESSONS[name].step):
        if step.deal:
            course = at_step(name, k)
            first = words(course)
            if course.step.ask is not None:
                answer(course)
            course.again(course.given.seed)
            kept = Given(seed=course.given.seed, sliders=course.given.sliders, outcomes=course.given.outcomes)
            assert course.given == kept and (kept.outcomes or words(course) == first)


def test_what_comes_late_from_another_start_is_not_shown():
    waiting = []
    course = Course(LESSONS["tour"], Progress(lesson="tour"), lambda kind, make, take: waiting.append((make, take)))
    while course.step is None or not course.step.deal:
        course.go(1)
    course.go(1)
    (make, take), made = waiting[-1], dict(course.made)
    course.go(-1)
    course.go(1)
    take(make())
    assert course.made == made
    waiting[-1][1](ValueError("no such place"))
    assert "Not computed: landscape: no such place." in words(course)


@pytest.mark.parametrize(
    "given",
    [
        {"choice": 7},
        {"choice": -1},
        {"place": (np.nan, 0.0)},
        {"sliders": (1.0,) * 9},
        {"path": ((1.0, 2.0),)},
        {"path": ((1.0, 2.0), (1.0,)), "E": (1.0, 2.0)},
        {"number": np.inf},
    ],
    ids=str,
)
def test_what_was_answered_to_another_lesson_is_no_answer(name, given):
    lesson = LESSONS[name]
    ids = ["before 0", "after 0", "nowhere", *(step.id for step in lesson.step)]
    kept = msgspec.convert({"lesson": name, "at": 10**6, "given": {id: given for id in ids}}, Progress)
    course = begun(lesson, progress=kept)
    assert course.progress.given == {} and course.screen == course.screens[-1]
    while course.progress.at:
        course.go(-1)
        words(course)
