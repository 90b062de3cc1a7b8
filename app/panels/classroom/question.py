"""The part of a lesson's card that is the class's: asked, counted, revealed. HTML."""

from viewimit.drawing.classroom.cloud import draw_postures
from viewimit.drawing.classroom.tally import Bar, draw_bars, draw_moves

from ...classroom.messages import Tally
from ...control.classroom.lecturer import CAN_BE_ASKED, ClassView
from ...control.state import PageState
from ...drawing.links import button
from ...lessons.answers import right_answer, scale_of
from ...lessons.course import Course
from ...lessons.format import Choice, Number, Pose
from ...lessons.judging import is_right
from ...lessons.measures import MEASURES
from ...lessons.stage import Stage
from ...lessons.words import shown


def question_html(state: PageState, course: Course, address: str | None) -> str:
    """Nothing where there is no class, or nothing that it could be asked."""
    view, stage = state.classroom, course.stage if state.classroom is not None or state.asked is not None else None
    if stage is None or not isinstance(stage.step.ask, CAN_BE_ASKED):
        return ""
    if view is not None:
        return _boxed("The class", _for_lecturer(view, course, stage, address))
    asked = state.asked
    if asked is None or not course.shows(asked.round.lesson, asked.round.step):
        return ""
    if not asked.revealed:
        words = "Your answer counts; you may change it." if course.answered else "The class is asked: what do you say?"
        return _boxed("The class", f"<p>{words} Nobody's name goes with it.</p>")
    return "" if asked.tally is None else _boxed("The class", tally_html(asked.tally, stage, True))


def _boxed(title: str, inside: str) -> str:
    return f'<section class="vi-class-question" aria-label="{title}">{inside}</section>'


def _for_lecturer(view: ClassView, course: Course, stage: Stage, address: str | None) -> str:
    asked, here = view.orders.asked, len(view.students)
    links = _Links(address)
    if not view.leads:
        return f"<p>Another of your pages leads the class.</p>{links.of('take', 'Take over')}"
    if asked is None or not course.shows(asked.round.lesson, asked.round.step):
        other = "" if asked is None else "<p>Another question is asked now.</p>"
        once = any(course.shows(one.lesson, one.step) for one in view.orders.rounds)
        words = f"Ask the class{' again' if once else ''}"
        save = links.of("save", "Save as CSV", "vi-text") if view.orders.rounds else ""
        return f"<p>{_count(here, 'page')} here.</p>{other}{links.of('ask', words, 'vi-filled')}{save}"
    tally = view.tally
    total = 0 if tally is None else tally.total
    told = view.told or asked.revealed
    shows = " vi-class-told" if told else ""
    parts = [f'<p class="vi-class-count vi-class-asked{shows}"><b>{total}</b> of {here} answered</p>']
    if told and tally is not None:
        parts.append(tally_html(tally, stage, asked.revealed))
    if not asked.revealed:
        parts.append(links.of("reveal", "Reveal to all", "vi-filled"))
        pair = [links.of("tell", "Hide answers" if view.told else "Show answers"), links.of("again", "Ask again")]
    else:
        pair = [links.of("again", "Ask again", "vi-filled"), links.of("save", "As CSV")]
    parts.append(f'<div class="vi-class-pair">{"".join(pair)}</div>')
    parts.append(links.of("close", "Close the question", "vi-text"))
    return "".join(parts)


class _Links:
    def __init__(self, address: str | None):
        self._address = address

    def of(self, verb: str, words: str, kind: str = "vi-plain") -> str:
        inside = f'<span class="vi-button vi-wide {kind}">{words}</span>'
        return "" if self._address is None else button(self._address, f"class/{verb}", words, inside)


def tally_html(tally: Tally, stage: Stage, revealed: bool) -> str:
    """revealed: with what is right."""
    ask, parts = stage.step.ask, []
    if isinstance(ask, Choice | Number):
        parts.append(draw_bars(_bars(tally, stage, revealed)))
    if isinstance(ask, Pose):
        truth = MEASURES[ask.truth].of(stage) if revealed else None
        parts.append(draw_postures(stage.session.scene, tally.places, truth))
    if revealed and tally.right is not None:
        near = "" if isinstance(ask, Choice) else " or close"
        parts.append(f"<p>{tally.right} of {tally.total} are right{near}.</p>")
    if revealed and tally.moved is not None:
        parts.append(draw_moves(tally.moved))
    return "".join(parts)


def _bars(tally: Tally, stage: Stage, revealed: bool) -> list[Bar]:
    ask = stage.step.ask
    before: list[int | None] = [*tally.before] if tally.before else [None] * len(tally.counts)
    if isinstance(ask, Choice):
        right = right_answer(stage, ask) if revealed else None
        words = [answer.text.replace("**", "") for answer in ask.answers]
        return [
            Bar(one, count, first, k == right if revealed else None)
            for k, (one, count, first) in enumerate(zip(words, tally.counts, before))
        ]
    assert isinstance(ask, Number)
    scale = [f"{shown(value)}{ask.unit}" for value in scale_of(ask)]
    near = [is_right(stage, number=value) if revealed else None for value in scale_of(ask)]
    all_bars = map(Bar, scale, tally.counts, before, near)
    return [one for one in all_bars if one.count or one.before or one.right]


def _count(count: int, what: str) -> str:
    return f"{count} {what}{'' if count == 1 else 's'}"
