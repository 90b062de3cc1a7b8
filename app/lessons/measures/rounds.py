"""Of a scene that was dealt, and of what was selected for it against the page's own choice."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from ..stage import Stage
from ..works.rounds import MOST_MOTIONS, ROUNDS, WITHIN_DEG, Rounds, Run
from .measure import Measure


def rounds_of(stage: Stage) -> Rounds:
    """As many as have been run."""
    return stage.made.get("rounds") or Rounds()


def _distance(stage: Stage) -> float:
    """m, from the head to the middle of what it looks at."""
    head = stage.session.scene.head
    return float(np.linalg.norm(head.position - (np.array(head.gaze_demonstrator) + head.gaze_learner) / 2))


def _there(of: Callable[[Rounds], Sequence[Run]]) -> Callable[[Stage], float]:
    """NaN before all have been run."""

    def count(stage: Stage) -> float:
        runs = of(rounds_of(stage))
        return float(sum(run.there for run in runs)) if len(runs) == ROUNDS else np.nan

    return count


def _nearer(stage: Stage) -> float:
    rounds = rounds_of(stage)
    return float(rounds.nearer) if len(rounds.yours) == ROUNDS else np.nan


MEASURES: Mapping[str, Measure] = {
    "head distance": Measure(_distance, " m", 1),
    "head baseline": Measure(lambda stage: 100 * stage.session.scene.head.baseline, " cm", 0),
    "head toe-in": Measure(lambda stage: stage.session.scene.head.toe_in_deg, "°", 0),
    "noise": Measure(lambda stage: stage.session.settings.noise_px, " px", 2),
    "lost points": Measure(lambda stage: 100 * stage.session.settings.missing, " %", 0),
    "frames": Measure(lambda stage: float(stage.session.settings.frames), "", 0),
    "rounds": Measure(lambda stage: float(ROUNDS), "", 0),
    "rounds run": Measure(lambda stage: float(len(rounds_of(stage).yours)), "", 0),
    "most motions of a round": Measure(lambda stage: float(MOST_MOTIONS), "", 0),
    "degrees that count as there": Measure(lambda stage: WITHIN_DEG, "°", 0),
    "your rounds there": Measure(_there(lambda rounds: rounds.yours), "", 0, "…"),
    "the page's rounds there": Measure(_there(lambda rounds: rounds.pages), "", 0, "…"),
    "rounds in which you ended nearer": Measure(_nearer, "", 0, "…"),
}
