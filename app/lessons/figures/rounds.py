"""What was selected against the page's own choice, and all results so far."""

from collections.abc import Collection, Mapping, Sequence

import numpy as np

from viewimit.drawing.lessons.rounds import Choice, Method, draw_choices, draw_rounds

from ..format import Select
from ..measures.rounds import rounds_of
from ..stage import Stage
from ..works.rounds import MOST_MOTIONS, ROUNDS, WITHIN_DEG, Run
from .figure_kind import FigureKind

RESULTS_SHOWN = 8  # the newest


def _rounds(stage: Stage, layers: Collection[str], small: bool) -> str:
    rounds = rounds_of(stage)
    methods = (
        _method("your choice", "you", rounds.yours),
        _method("the page's choice", "learner", rounds.pages),
    )
    drawn = draw_rounds(methods, ROUNDS, MOST_MOTIONS, WITHIN_DEG, stage.narrow)
    if stage.revealed and len(rounds.yours) < ROUNDS:
        now = (
            f"start {len(rounds.yours) + 1} of {ROUNDS} is being run; all take 10 to 30 seconds if nothing else goes on"
        )
        drawn += f'<p class="vi-waits">{now} …</p>'
    return f'<div class="vi-rounds-all">{drawn}</div>'


def _method(name: str, role: str, runs: Sequence[Run]) -> Method:
    off, motions = np.array([run.off_deg for run in runs]), np.array([run.motions for run in runs])
    return Method(name, role, off, motions, sum(run.there for run in runs))


def _results(stage: Stage, layers: Collection[str], small: bool) -> str:
    given, ask = stage.given, stage.step.ask
    fields = ask.fields if isinstance(ask, Select) else ()
    choices = []
    for outcome in given.outcomes[-RESULTS_SHOWN:]:
        if len(outcome.selected) != len(fields) or len(outcome.numbers) < 2:
            continue
        what = ", ".join(
            field.values[k].text for field, k in zip(fields, outcome.selected) if 0 <= k < len(field.values)
        )
        now = stage.revealed and (outcome.seed, outcome.selected) == (given.seed, given.selected)
        choices.append(Choice(outcome.seed, what, round(outcome.numbers[0]), round(outcome.numbers[1]), now))
    return draw_choices(choices)


FIGURES: Mapping[str, FigureKind] = {
    "rounds": FigureKind(_rounds, works=("rounds",)),
    "results": FigureKind(_results),
}
