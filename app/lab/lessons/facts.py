"""Facts and records of a step: what the library computes for it when the page is written.

    situation = Situation(settings, step.scene, step.chosen, step.race, goal)
    facts, records = compute(situation, measures, figures)

A fact is a number of the step's fixed state. Records are runs, maps, clouds and paths that figures draw.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from .situation import Situation


@dataclass(frozen=True)
class Fact:
    """A measure that the library computes."""

    of: Callable[[Situation], Any]  # a number, NaN where there is none, numbers or a text
    unit: str = ""  # behind the number
    digits: int | None = None  # after the point; None for as many as its size deserves
    missing: str = "–"  # instead of NaN


FACTS: Mapping[str, Fact] = {}
RECORDS: Mapping[str, Callable[[Situation], Any]] = {}  # by the name under which the page has it
FIGURE_RECORDS: Mapping[str, tuple[str, ...]] = {}  # figure: the records that it draws


def compute(
    situation: Situation, measures: Iterable[str], figures: Iterable[str] = ()
) -> tuple[dict[str, dict[str, Any]], dict[str, Any]]:
    """Compute the facts and records of a step.

    Parameters
    ----------
    situation : Situation
        The step's fixed state, or one that was dealt.
    measures : iterable of str
        Names in braces and of the question; those that the browser computes are left out.
    figures : iterable of str
        Names of the step's figures.

    Returns
    -------
    facts : dict
        {measure: {"value", "unit", "text"}}.
    records : dict
        {name: plain data for JSON}.
    """
    return {}, {}


def deals(situation: Situation, step: str, count: int, seed: int) -> list[Situation]:
    """Deal states of a step by a seed: its learner and demonstrator, for "design" its head and noise as well."""
    return [situation] * count
