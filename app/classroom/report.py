"""What a class has answered as a table, and what it has learned by the eight questions asked before and after."""

import csv
import io
from collections import Counter, defaultdict
from collections.abc import Iterable

import msgspec
import numpy as np
from numpy.typing import NDArray

from .protocol import Given
from .store import Row
from .votes import QUESTIONS

COLUMNS = ("person", "form", "item", "phase", "answer", "right", "sure", "seconds")
UNLINKED = "unlinked"
MIN_PERSONS = 5  # of a class whose gain is shown
RESAMPLES = 4000
INTERVAL_PERCENT = 2.5, 97.5
SEED = 1


def as_csv(rows: Iterable[Row]) -> str:
    """Return all answers as a table.

    A person is a random number that stays the same over the class, or "unlinked". An answer to a choice is its place in
    the lesson's file, from 1. `seconds` count from the moment at which the question was shown.
    """
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(COLUMNS)
    for row in sorted(rows, key=lambda row: (row.lesson, row.step, row.phase, row.person or 0, row.voter)):
        vote = row.vote
        person = UNLINKED if row.person is None else row.person
        right = "" if vote.right is None else int(vote.right)
        sure = "" if vote.sure is None else "sure" if vote.sure else "guess"
        seconds = "" if vote.seconds is None else f"{vote.seconds:.1f}"
        table.writerow((person, row.lesson, row.step, row.phase, _text(vote.answer), right, sure, seconds))
    return text.getvalue()


def _text(answer: Given) -> str:
    if answer.choice is not None:
        return str(answer.choice + 1)
    numbers = (answer.number,) if answer.number is not None else answer.place or answer.posture or answer.values or ()
    return " ".join(f"{number:.6g}" for number in numbers)


class Item(msgspec.Struct, frozen=True):
    """One of the eight questions. before, after: how many of these persons were right."""

    item: str
    persons: int
    before: int
    after: int


class Learned(msgspec.Struct, frozen=True):
    """The gain of a class. persons: who answered before and after; enough: whether they are at least MIN_PERSONS,
    without whom nothing else is said; low, high: the interval that holds 95 % of the resampled gains."""

    persons: int
    enough: bool
    items: tuple[Item, ...] = ()
    before: float | None = None  # share of right answers
    after: float | None = None
    gain: float | None = None  # None where all were right before
    low: float | None = None
    high: float | None = None


def learned(rows: Iterable[Row]) -> Learned:
    """Return the gain by the eight questions, of persons who answered the same one before and after. It is (after -
    before) / (1 - before) of the class's shares (Hake, Am. J. Phys. 66, 1998), its interval the percentile bootstrap
    over persons (Efron & Tibshirani 1993, section 13.3)."""
    right: dict[tuple[int, str], dict[str, bool]] = defaultdict(dict)
    for row in rows:
        if row.lesson == QUESTIONS and row.phase in ("before", "after") and row.person is not None:
            if row.vote.right is not None:
                right[row.person, row.step][row.phase] = row.vote.right
    pairs = {key: both for key, both in right.items() if len(both) == 2}
    persons = sorted({person for person, _ in pairs})
    if len(persons) < MIN_PERSONS:
        return Learned(len(persons), False)
    sums = np.zeros((len(persons), 3))  # of each person: pairs, right before, right after
    for (person, _), both in pairs.items():
        sums[persons.index(person)] += 1, both["before"], both["after"]
    total, before, after = sums.sum(0)
    chosen = np.random.default_rng(SEED).integers(len(persons), size=(RESAMPLES, len(persons)))
    gains = _gain(sums[chosen].sum(1))
    gains = gains[np.isfinite(gains)]
    low, high = np.percentile(gains, INTERVAL_PERCENT) if len(gains) else (np.nan, np.nan)
    gain = _gain(sums.sum(0)[None])[0]
    found = (float(value) if np.isfinite(value) else None for value in (gain, low, high))
    return Learned(len(persons), True, _items(pairs), float(before / total), float(after / total), *found)


def _items(pairs: dict[tuple[int, str], dict[str, bool]]) -> tuple[Item, ...]:
    """Count each question; those with few persons are left out, as they could reveal a person's answer."""
    persons = Counter(item for _, item in pairs)
    count = lambda item, phase: sum(both[phase] for (_, of), both in pairs.items() if of == item)
    return tuple(
        Item(item, n, count(item, "before"), count(item, "after")) for item, n in persons.items() if n >= MIN_PERSONS
    )


def _gain(sums: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rows of pairs, right before, right after → gains, NaN where all were right before."""
    total, before, after = sums.T
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(total > before, (after - before) / (total - before), np.nan)
