"""How long a lesson takes to be read."""

from collections.abc import Iterator

from .format import Choice, Do, Lesson, Select, Step

WORDS_A_MINUTE = 200


def reading_minutes(lesson: Lesson) -> float:
    """Of all that somebody reads who answers every question: of a question's replies, the longest."""
    return sum(len(words.split()) for words in _read(lesson)) / WORDS_A_MINUTE


def _read(lesson: Lesson) -> Iterator[str]:
    for question in lesson.question:
        yield from (question.before, question.after, *question.answers, *question.answers_after)
    for step in lesson.step:
        yield from (step.title, step.text, step.after, step.say, *(slider.label for slider in step.sliders))
        if step.told is not None:
            yield from (step.told.label, step.told.note)
        yield from _asked(step)


def _asked(step: Step) -> Iterator[str]:
    ask = step.ask
    if ask is None:
        return
    yield ask.question
    if isinstance(ask, Choice):
        yield from (answer.text for answer in ask.answers)
        yield _longest(*(answer.because for answer in ask.answers))
    elif isinstance(ask, Select):
        yield from (f"{field.label} {' '.join(value.text for value in field.values)}" for field in ask.fields)
    elif not isinstance(ask, Do):
        yield _longest(ask.close, ask.far)


def _longest(*texts: str) -> str:
    return max(texts, key=lambda text: len(text.split()))
