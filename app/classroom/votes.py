"""Which answers fit the questions of a class and are right, the rounds that a lecturer asks, and what they add up to.
What browsers think of an answer is not asked."""

from collections import Counter
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from ..lab.lessons.format import Ask, Bet, Choice, Do, Lesson, Number, Place, Pose, Predict
from ..lab.lessons.source import questions
from .protocol import Given, Moved, Phase, Results, Tally

MOVES = ((True, True), (False, True), (True, False), (False, False))  # right before, right now
QUESTIONS = "questions"  # the form of the eight questions
Asks: TypeAlias = Mapping[tuple[str, str], Ask]  # by lesson and step
FIELD = {
    Choice: "choice", Place: "place", Pose: "posture", Number: "number", Do: "number", Predict: "values", Bet: "values",
}  # fmt: skip


def asks_of(lessons: Mapping[str, Lesson]) -> Asks:
    """Return all that lessons ask, the eight questions included where a lesson has them."""
    asks = {(name, step.id): step.ask for name, lesson in lessons.items() for step in lesson.step}
    if any(lesson.questions for lesson in lessons.values()):
        asks |= {(QUESTIONS, item.id): Choice(question=item.text, answers=item.answers) for item in questions().item}
    return asks


def fits(ask: Ask, given: Given) -> bool:
    """Return whether an answer is of the kind that is asked for."""
    if getattr(given, FIELD[type(ask)]) is None:
        return False
    return not isinstance(ask, Choice) or given.choice is None or given.choice < len(ask.answers)


def is_right(ask: Ask, given: Given, truth: Sequence[Sequence[float]] = (), near: float | None = None) -> bool | None:
    """Return whether an answer, which fits what is asked, is right; None where nothing is, or it is not known. truth:
    what the lecturer's page has computed where the lesson's file does not say it: the number of the right answer from
    1, a number, a posture, or the corners of a line; near: how far a place may be from it, None for `ask.near`."""
    if isinstance(ask, Choice) and ask.right is None:
        return ask.answers[given.choice or 0].right
    if not truth or not isinstance(ask, Choice | Number | Pose | Place):
        return None
    first = truth[0]
    if isinstance(ask, Choice):
        return given.choice == round(first[0]) - 1
    if isinstance(ask, Number):
        value, true = given.number or 0.0, first[0]
        if ask.factor:
            return true > 0 and true / ask.factor <= value <= true * ask.factor
        return abs(value - true) <= (ask.within or 0)
    if isinstance(ask, Pose):
        return bool(np.abs(np.subtract(given.posture or (), first)).max() <= ask.near)
    return _distance(given.place or (), truth) <= (ask.near if near is None else near)


def _distance(place: Sequence[float], corners: Sequence[Sequence[float]]) -> float:
    """From a place to the nearest one of a line, or to its only corner."""
    at, line = np.asarray(place), np.asarray(corners)
    begins, ways = line[: max(1, len(line) - 1)], np.diff(line, axis=0) if len(line) > 1 else np.zeros((1, 2))
    length = np.maximum((ways**2).sum(1), np.finfo(float).tiny)
    shares = np.clip(((at - begins) * ways).sum(1) / length, 0, 1)
    return float(np.linalg.norm(begins + shares[:, None] * ways - at, axis=1).min())


@dataclass(frozen=True)
class Vote:
    """One voter's answer. place: which network address it came from, as a keyed hash."""

    answer: Given
    right: bool | None = None
    sure: bool | None = None
    seconds: float | None = None
    place: str = ""


@dataclass
class Round:
    """One asking of a question. times: how often the question had been asked by then, itself included."""

    number: int
    lesson: str
    step: str
    phase: Phase
    times: int
    votes: dict[str, Vote] = field(default_factory=dict)  # by voter
    stayed: set[str] = field(default_factory=set)  # voters who have left, but were here for a while
    most: Counter[str] = field(default_factory=Counter)  # persons here at a time, by network address

    @property
    def label(self) -> str:
        """The phase of its answers in the table of answers."""
        again = f", round {self.times}" if self.times > 1 else ""
        return f"round {self.times}" if self.phase == "own" else f"{self.phase}{again}"

    def left_out(self, here: Container[str], staying: Counter[str]) -> set[str]:
        """Return the voters that do not count: they have left at once, or more have left than were here at a time.

        here: the voters who are here, all of whom count; staying: how many have been here for a while and still are,
        by network address.
        """
        room = self.most - staying
        left_out = set()
        for voter, vote in self.votes.items():
            if voter in here:
                continue
            if voter in self.stayed and room[vote.place] > 0:
                room[vote.place] -= 1
            else:
                left_out.add(voter)
        return left_out


def results(asked: Round, rounds: Sequence[Round]) -> Results:
    """Return what a question was answered, compared with the round before and with the first."""
    same = [one for one in rounds if (one.lesson, one.step, one.phase) == (asked.lesson, asked.step, asked.phase)]
    earlier = [one for one in same if one.number < asked.number]
    if not earlier:
        return Results(tally(asked))
    first, before = earlier[0], earlier[-1]
    if first is before:
        return Results(tally(asked), tally(before), moved=moved(before, asked))
    return Results(tally(asked), tally(before), tally(first), moved(before, asked), moved(first, asked))


def tally(asked: Round) -> Tally:
    """Count a round's answers."""
    votes = asked.votes.values()
    choices = Counter(vote.answer.choice for vote in votes if vote.answer.choice is not None)
    judged = [vote.right for vote in votes if vote.right is not None]
    return Tally(
        total=len(votes),
        counts=tuple(choices[k] for k in range(max(choices, default=-1) + 1)),
        values=tuple(sorted(_numbers(vote.answer) for vote in votes if vote.answer.choice is None)),
        right=sum(judged) if judged else None,
    )


def _numbers(answer: Given) -> tuple[float, ...]:
    if answer.number is not None:
        return (answer.number,)
    return answer.place or answer.posture or answer.values or ()


def moved(before: Round, now: Round) -> Moved | None:
    """Compare the voters of two rounds; None if none has voted in both."""
    both = [(before.votes[one].right, now.votes[one].right) for one in now.votes if one in before.votes]
    counts = [both.count(move) for move in MOVES]
    return Moved(*counts) if sum(counts) else None
