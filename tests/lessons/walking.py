"""A lesson walked without a page: every question is answered, rightly or wrongly, and everything that is to be done is
done, by what only the simulator knows."""

import contextlib
import re
from dataclasses import replace
from functools import partial
from xml.etree import ElementTree

import numpy as np
import pytest
from sameness import assert_same
from viewimit.app.lessons.answers import right_answer
from viewimit.app.lessons.card import draw_lesson
from viewimit.app.lessons.course import Course
from viewimit.app.lessons.figures import FIGURES
from viewimit.app.lessons.format import Choice, Do, Number, Place, Pose, Select
from viewimit.app.lessons.measures import MEASURES, named_in
from viewimit.app.lessons.progress import Progress
from viewimit.app.lessons.sliders import draw_sliders
from viewimit.app.lessons.source import shipped
from viewimit.app.lessons.works import WORKS

ADDRESS = "/touch/0.x"
TRIED = 13  # places of a slider, until what is to be reached is


def at_once(kind, make, take):
    take(make())


def course_at(step):
    """A course that has just come to a step of a shipped lesson, by its id."""
    name, lesson = next((name, one) for name, one in shipped().items() if step in {each.id for each in one.step})
    course = Course(lesson, Progress(lesson=name), at_once)
    assert course.go(next(k for k, screen in enumerate(course.screens) if screen.id == step))
    return course


@contextlib.contextmanager
def works_kept():
    """Inside, the same inputs of works are computed with twice, which comes to the same, and then no more."""
    found = {}

    def make(name, work, task):
        times, made = found.get(key := (name, *_inputs(task)), (0, None))
        if times < 2:
            again = work(task)
            if times:
                assert_same(again, made)
            found[key] = times + 1, again
        return found[key][1]

    with pytest.MonkeyPatch.context() as patch:
        for name, work in WORKS.items():
            patch.setitem(WORKS, name, replace(work, make=partial(make, name, work.make)))
        yield


def _inputs(task):
    """All that a work is computed from, to the last bit: of its world, what is seen of it."""
    plain = task.step, task.settings, task.sliders, task.seed, task.staging, task.selected, task.made
    views = task.snapshot.views
    seen = task.snapshot.theta, task.snapshot.theta_demo, views.demo, views.own, views.visible
    return repr(plain), *(array.tobytes() for array in seen)


def begun(lesson, name="lesson", progress=None):
    """A course whose works are done at once."""
    return Course(lesson, progress or Progress(lesson=name), at_once)


def told(course, name):
    """A number that its step tells."""
    return float(MEASURES[name].of(course.stage))


def answer(course, rightly=True):
    """What its screen asks for, and show what is true."""
    step, ask = course.step, course.step.ask if course.step else None
    if course.screen.kind in ("before", "after"):
        asked, answers = course.lesson.question[course.screen.number], course.question()[1]
        right = answers.index((asked.answers if course.screen.kind == "before" else asked.answers_after)[0])
        course.choose(right if rightly else (right + 1) % len(answers))
    elif isinstance(ask, Choice):
        right = right_of(course, ask)
        course.choose(right if rightly else (right + 1) % len(ask.answers))
    elif isinstance(ask, Place):
        course.place(np.array([60.0, 60.0]))
        if rightly:
            course.place(drawn_at(course, ask))
    elif isinstance(ask, Number):
        truth = float(MEASURES[ask.truth].of(course.stage))
        course.guess(truth if rightly and np.isfinite(truth) else ask.high)
    elif isinstance(ask, Do):
        do(course, ask)
    elif isinstance(ask, Pose):
        pose(course, ask, rightly)
    elif isinstance(ask, Select):
        for k, field in enumerate(ask.fields):
            course.select(k, 0 if rightly else len(field.values) - 1)
    if step is not None and not course.given.revealed:
        course.show()
    course.tick(0.0, still=True)  # what would be played is shown


def right_of(course, ask):
    """The right answer; where it is computed only once something was answered, by another walk."""
    if (known := right_answer(course.stage, ask)) >= 0:
        return known
    other = begun(course.lesson, course.progress.lesson, course.progress)
    other.choose(0)
    other.show()
    return right_answer(other.stage, ask)


def drawn_at(course, ask):
    """The place of the truth, in units of the figure, as a click there would be; by search, as clicks are."""
    stage, truth = course.stage, MEASURES[ask.truth].of(course.stage)
    at, reach = np.array([350.0, 350.0]), 350.0
    while reach > 0.5:  # units; the figure's own are straight lines, so that nearest is nearest
        steps = np.stack(np.meshgrid(*[np.linspace(-reach, reach, 15)] * 2, indexing="ij"), -1).reshape(-1, 2)
        at = min(at + steps, key=lambda one: np.linalg.norm(FIGURES[ask.figure].unplace(stage, one) - truth))
        reach /= 5
    return at


def do(course, ask):
    """Turn own joints to where the demonstrator's are; then every slider to where it is best."""
    for k, slider in enumerate(course.step.sliders):
        kind, _, joint = slider.name.partition(" ")
        if kind == "own" and not course.given.done:
            course.turn(k, float(np.degrees(course.moments[-1].theta_demo[int(joint) - 1])))
    for k, slider in enumerate(course.step.sliders):
        if course.given.done:
            return
        values = np.geomspace if slider.logarithmic else np.linspace
        found = []
        for value in values(slider.low, slider.high, TRIED):
            course.turn(k, float(value))
            if course.given.done:
                return
            found.append(float(MEASURES[ask.measure].of(course.stage)))
        best = np.nanargmax(found) if ask.below is None else np.nanargmin(found)
        course.turn(k, float(values(slider.low, slider.high, TRIED)[best]))
    assert course.given.done, f"{course.step.id}: {ask.measure} cannot be reached"


def pose(course, ask, rightly):
    truth = MEASURES[ask.truth].of(course.stage)
    for k, slider in enumerate(course.step.sliders):
        course.turn(k, float(truth[k]) if rightly else slider.low)


def words(course):
    """All that is written on the lesson's page."""
    html = draw_lesson(course, ADDRESS) + draw_sliders(course, ADDRESS)
    root = ElementTree.fromstring(f"<div>{html.replace('&nbsp;', ' ')}</div>")
    return " ".join(" ".join(root.itertext()).split())


def said(course):
    """What the words of its step have in braces."""
    step = course.step
    named = [step.after, step.say, *([step.told.note] if step.told else [])]
    named += [getattr(step.ask, name, None) or "" for name in ("close", "far", "on_line")]
    return {m for text in named for m in named_in(text)} | ({step.told.measure} if step.told else set())


def unfilled(text):
    """What should have been a number."""
    return re.findall(r"[{}]|\bnan\b|\binf\b|\bNone\b|computing", text)
