"""What a class has answered, counted."""

from collections.abc import Mapping

import numpy as np

from ...classroom.messages import MOST_PLACES, Answer, Tally
from ...lessons.answers import scale_of
from ...lessons.format import Choice, Number
from ...lessons.judging import is_right
from ...lessons.stage import Stage

MOVES = ((True, True), (False, True), (True, False), (False, False))  # right first, right again


def tally_of(stage: Stage, answers: Mapping[str, Answer], earlier: Mapping[str, Answer]) -> Tally:
    """earlier: to the same question, asked before. What is none of this question's answers is left out."""
    answers, earlier = (_fitting(stage, found) for found in (answers, earlier))
    right, right_before = (_right(stage, found) for found in (answers, earlier))
    moved = None
    if earlier and None not in right.values() and None not in right_before.values():
        both = [(right_before[one], right[one]) for one in answers if one in earlier]
        rr, wr, rw, ww = (both.count(move) for move in MOVES)
        moved = rr, wr, rw, ww
    places = tuple(one.place for one in answers.values() if one.place is not None)
    return Tally(
        total=len(answers),
        counts=_counts(stage, answers),
        places=tuple((round(x, 1), round(y, 1)) for x, y in places[:MOST_PLACES]),
        right=_sum(right),
        before=_counts(stage, earlier) if earlier else (),
        right_before=_sum(right_before) if earlier else None,
        total_before=len(earlier),
        moved=moved,
    )


def _fitting(stage: Stage, answers: Mapping[str, Answer]) -> dict[str, Answer]:
    return {id: one for id, one in answers.items() if _fits(stage, one)}


def _fits(stage: Stage, answer: Answer) -> bool:
    ask = stage.step.ask
    if isinstance(ask, Choice):
        return answer.choice is not None and answer.choice < len(ask.answers)
    if isinstance(ask, Number):
        return answer.number is not None and ask.low <= answer.number <= ask.high
    return answer.place is not None


def _right(stage: Stage, answers: Mapping[str, Answer]) -> dict[str, bool | None]:
    return {id: is_right(stage, one.choice, one.number, one.place) for id, one in answers.items()}


def _sum(right: Mapping[str, bool | None]) -> int | None:
    found = [one for one in right.values() if one is not None]
    return sum(found) if len(found) == len(right) else None


def _counts(stage: Stage, answers: Mapping[str, Answer]) -> tuple[int, ...]:
    """Of each choice, or of each number on the scale."""
    ask = stage.step.ask
    if isinstance(ask, Choice):
        given = [one.choice for one in answers.values()]
        return tuple(given.count(k) for k in range(len(ask.answers)))
    if isinstance(ask, Number):
        scale = np.array(scale_of(ask))
        nearest = [int(np.abs(scale - one.number).argmin()) for one in answers.values() if one.number is not None]
        return tuple(nearest.count(k) for k in range(len(scale)))
    return ()
