"""A step at one moment: all that its figures, its measures and its words are computed from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from viewimit.analysis.landscape import Landscape
from viewimit.drawing.lessons.view import Window, window_of
from viewimit.loop.session import Session
from viewimit.loop.snapshot import Snapshot
from viewimit.simulation.appearance import Bodies

from .format import Do, Pose, Step
from .progress import Given


@dataclass(frozen=True)
class Race:
    """A servo that was run from the step's start. moments: all of it, the start first."""

    servo: str
    moments: tuple[Snapshot, ...]


@dataclass(frozen=True, eq=False)
class Stage:
    """session: the lesson's own; moments: what was seen since the step began, the last of them shown; given: what was
    answered here, and by_id in all steps; made: what the step's works have come to so far, by name; played: motions
    that are shown, None for all; bodies: what both arms look like; narrow: the window is; others: what a class has
    placed, in the unit of the step's figure."""

    step: Step
    session: Session
    moments: Sequence[Snapshot]
    given: Given
    by_id: Mapping[str, Given]
    steps: Mapping[str, Step]
    made: Mapping[str, Any]
    played: int | None
    bodies: Bodies
    narrow: bool = False
    others: Sequence[tuple[float, float]] = ()

    @property
    def moment(self) -> Snapshot:
        return self.moments[-1]

    @property
    def landscape(self) -> Landscape | None:
        """Of the moment shown; None while it is computed."""
        return self.made.get("landscape")

    @property
    def races(self) -> tuple[Race, ...]:
        """Whole; none while they are run."""
        return self.made.get("races", ())

    @property
    def revealed(self) -> bool:
        return self.given.revealed

    @property
    def guess(self) -> NDArray | None:
        """The visitor's mark in the step's figure, in its unit."""
        return None if self.given.place is None else np.array(self.given.place)

    @cached_property
    def guessed(self) -> Snapshot | None:
        """What would be seen where the see-through arm is; None where no posture is asked for."""
        if not isinstance(self.step.ask, Pose):
            return None
        posture = self.given.place or self.given.sliders
        theta = np.radians(posture) if posture else self.moments[0].theta
        return self.session.observe(theta, self.moment)

    def slider(self, name: str) -> float:
        """Where one of the step's sliders stands."""
        k = next(k for k, slider in enumerate(self.step.sliders) if slider.name == name)
        return self.given.sliders[k] if k < len(self.given.sliders) else self.step.sliders[k].start

    def shown(self, small: bool) -> str:
        """How an image is: of `SIZES`. small: at the side."""
        if not self.narrow:
            return "small" if small else "large"
        return "small half" if small else "half" if len(self.step.main) > 1 else "narrow"

    def window(self, view: str) -> Window:
        """Of a large one."""
        return window_of(view, self.bodies, self.moment, self.shown(False))

    @cached_property
    def goal(self) -> float | None:
        """What is to be brought below, here or in the step whose path goes on here."""
        ask = self.steps[self.step.carry].ask if self.step.carry else self.step.ask
        return ask.below if isinstance(ask, Do) else None

    @property
    def races_so_far(self) -> tuple[Race, ...]:
        """As they are shown."""
        if self.played is None:
            return self.races
        return tuple(Race(race.servo, race.moments[: self.played + 1]) for race in self.races)

    @property
    def trail(self) -> Given:
        """What was answered in the step whose start and path go on here; else here."""
        return self.by_id.get(self.step.carry, self.given) if self.step.carry else self.given
