"""What was selected against the page's own choice: from the same starts, in the scene that was dealt, one start after
the other."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from viewimit.loop.settings import Settings

from ..dealing import deal_start
from .work import Task, Work

ROUNDS, MOST_MOTIONS = 20, 30  # starts, and motions from each: under a minute of one core for both
WITHIN_DEG = 1.0  # of the demonstrator: there
IN_VAIN = 3  # looks with too few points, after which a run is given up


@dataclass(frozen=True)
class Run:
    """From one start. off_deg: the joint that is farthest from the demonstrator's at the end; motions made."""

    off_deg: float
    motions: int

    @property
    def there(self) -> bool:
        return self.off_deg <= WITHIN_DEG


@dataclass(frozen=True)
class Rounds:
    """As many as have been run: yours and the page's, from the same starts."""

    yours: tuple[Run, ...] = ()
    pages: tuple[Run, ...] = ()

    @property
    def nearer(self) -> int:
        """In how many yours ended nearer to the demonstrator."""
        return sum(yours.off_deg < pages.off_deg for yours, pages in zip(self.yours, self.pages))


def _rounds(task: Task) -> Rounds:
    """One more than before."""
    made = task.made or Rounds()
    session, theta_demo = task.session(), task.snapshot.theta_demo
    start = deal_start(session.scene, theta_demo, [task.seed, len(made.yours)])
    yours = _run(task, start_deg=start, **task.selected)
    pages = _run(task, start_deg=start, transfer=Settings().transfer, servo=Settings().servo)
    return Rounds((*made.yours, yours), (*made.pages, pages))


def _run(task: Task, **changes) -> Run:
    last = task.session(**changes).run(MOST_MOTIONS, IN_VAIN).last
    return Run(float(np.degrees(np.abs(last.theta - last.theta_demo)).max()), last.motion)


def _outcome(made: Rounds) -> tuple[float, ...]:
    """How many of yours, and of the page's, came there, and in how many yours ended nearer."""
    return float(sum(run.there for run in made.yours)), float(sum(run.there for run in made.pages)), float(made.nearer)


def unfinished(made: Rounds) -> bool:
    return len(made.yours) < ROUNDS


WORKS: Mapping[str, Work] = {"rounds": Work(_rounds, "revealed", goes_on=unfinished, outcome=_outcome)}
