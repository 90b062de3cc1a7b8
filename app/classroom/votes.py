"""Rounds of questions that a lecturer asks, the answers of each voter, and what they add up to."""

from collections import Counter
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, field

from .protocol import Given, Moved, Phase, Results, Tally

MOVES = ((True, True), (False, True), (True, False), (False, False))  # right before, right now


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

    def left_out(self, here: Container[str], staying: Mapping[str, str]) -> set[str]:
        """Return the voters that do not count: they have left at once, or more have left than were here at a time.
        here: the voters who are here, all of whom count; staying: the network address of each who has been here for a
        while and still is."""
        room = self.most - Counter(staying.values())
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
