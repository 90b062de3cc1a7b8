"""A lesson tried out: each step is begun once, so that what names and types do not tell is told before anybody is
taught. Nothing long is computed."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from viewimit.loop.session import Session
from viewimit.loop.settings import Settings

from .course import Course
from .format import Do, Lesson, Number, Place, Pose, Step, settings_of
from .measures import MEASURES, named_in
from .progress import Progress
from .scenes import Staging
from .stage import Stage

Faults = Iterator[tuple[str, str]]


def faults_in_session(lesson: Lesson) -> Faults:
    """(field, what is wrong), of a lesson that has no other faults."""
    session = Session()
    for k, step in enumerate(lesson.step):
        for where, what in _of_world(step, session, {**lesson.settings, **step.settings}):
            yield f".step[{k}]{where}", what
    course = Course(lesson, Progress(lesson=""), lambda kind, make, take: None)
    for _ in course.screens:
        stage = course.stage
        if stage is not None:
            for where, what in _of_measures(stage):
                yield f".step[{course.screen.number}]{where}", what
        course.go(1)


def _of_world(step: Step, session: Session, fields: dict[str, Any]) -> Faults:
    """Joints and points that the scene does not have, settings that cannot be."""
    try:
        session.begin(settings_of(fields))
    except (ValueError, OSError) as error:
        yield ".settings", str(error)
        return
    if step.scene:
        try:
            session = Session(session.settings, open_eyes=Staging(step.scene).open_eyes)
        except (ValueError, OSError) as error:
            yield ".scene", str(error)
            return
    joints, points = len(session.snapshot.theta), len(session.world.body)
    if step.chosen is not None and not 0 <= step.chosen < points:
        yield ".chosen", f"no point {step.chosen}; there are {points}, counted from 0"
    for k, slider in enumerate(step.sliders):
        kind, _, number = slider.name.partition(" ")
        if kind in ("own", "demo", "guess") and number.isdigit() and not 1 <= int(number) <= joints:
            yield f".sliders[{k}].name", f"no joint {number} among those that move; there are {joints}, from 1"
        if slider.name in Settings.__struct_fields__:
            try:
                for end in (slider.low, slider.high):
                    session.begin(settings_of({**fields, slider.name: end}))
            except (ValueError, OSError) as error:
                yield f".sliders[{k}]", str(error)


def _of_measures(stage: Stage) -> Faults:
    """What is told must be a number; what a mark is compared with a place, a see-through arm a posture."""
    step, ask = stage.step, stage.step.ask
    words = {"text": step.text, "after": step.after, "say": step.say}
    numbers = [(f".{name}", measure) for name, said in words.items() for measure in named_in(said)]
    if step.told is not None:
        numbers.append((".told.measure", step.told.measure))
        numbers += [(".told.note", measure) for measure in named_in(step.told.note)]
    if isinstance(ask, Do):
        numbers.append((".ask.measure", ask.measure))
    if isinstance(ask, Number):
        numbers.append((".ask.truth", ask.truth))
    for where, measure in numbers:
        if np.ndim(MEASURES[measure].of(stage)) != 0:
            yield where, f"{measure!r} is no number"
    if isinstance(ask, Place | Pose):
        size = 2 if isinstance(ask, Place) else len(stage.moment.theta)
        if np.shape(MEASURES[ask.truth].of(stage)) != (size,):
            yield ".ask.truth", f"{ask.truth!r} is no {'place in an image' if size == 2 else 'posture'}"
