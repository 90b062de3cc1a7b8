"""What the estimator remembers from motion to motion."""

from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from ...estimation.views import Pairs
from ...geometry.kinematics.clusters import Observations
from ...geometry.kinematics.own_body import OwnBody
from ..certificate import Certificate
from ..misfit import Misfit, MisfitKind
from ..naming import Naming
from ..observation import Observation, Visit
from ..status import ServoStatus
from .hypotheses import Estimate
from .options import EstimatorOptions

Displacement = NDArray[np.float64]
SAME = 1e-9  # rad, between two visits of one posture
MAX_SWAPPED = 2  # points that count as swapped; more are mixed up


class Purpose(str, Enum):
    """What the last motion was for."""

    PROBE = "probe"  # one joint alone, to learn what it moves
    GROW = "grow"  # where the arm has not been: no body explains the images yet, or too few points are in sight
    NAME = "name"  # the same, because the demonstrator's points could not be named yet
    LOOK = "look"  # to lessen the expected error before the arm goes to the estimate
    ARRIVE = "arrive"  # to the estimate
    FOLLOW = "follow"  # to where a moving demonstrator will be
    NEAREST = "nearest"  # to the least E, because the images leave a joint open


@dataclass(frozen=True)
class EstimatorState:
    """All that the servo remembers, immutable. Images are in units of `unit_px`."""

    visits: tuple[Visit, ...]  # with where the arm was sent; those of a calibration first
    joints_to_probe: tuple[int, ...]
    unit_px: float
    n_calibration: int = 0  # visits of a calibration
    body: OwnBody | None = None  # that explains all visits
    best: Estimate | None = None  # the likeliest hypothesis about the demonstrator
    n_explored: int = 0  # exploring motions since the demonstrator moved
    n_moved: int = 0  # all motions since then, but probes
    n_naming_motions: int = 0  # made because no naming explained the images
    went_nearest: bool = False  # whether the arm went to the least E since then, as a joint stays open
    purpose: Purpose = Purpose.PROBE
    exchanged: Pairs = ()  # pairs of the demonstrator's points that were swapped
    naming: Naming | None = None  # of its points, if they came without names
    certificate: Certificate | None = None
    misfit: Misfit | None = None
    status: ServoStatus = ServoStatus.MOVING
    probe: bool = False  # whether the last motion was made to learn from it
    moved: bool = False  # whether the demonstrator has moved by itself since the last motion
    streak: int = 0  # motions in a row, before each of which it did
    trail: tuple[tuple[NDArray[np.float64], Displacement], ...] = ()  # its images and angles meanwhile, newest last

    @property
    def calibration(self) -> tuple[Visit, ...]:
        """Visits of a calibration that still count."""
        return self.visits[: self.n_calibration]

    @property
    def seen(self) -> Observations:
        """All visits in arrays, with where the arm was sent."""
        displacement = np.array([visit.displacement for visit in self.visits])
        own = np.array([visit.own for visit in self.visits])
        return Observations(displacement, own, np.all([visit.seen for visit in self.visits], -1))

    def recorded(self, see: Observation, options: EstimatorOptions) -> tuple["EstimatorState", bool]:
        """Add what is seen; also return whether it is new.

        A look from where the last one was made replaces it; without noise, one from any earlier posture, too.
        """
        state = replace(self, status=ServoStatus.MOVING, probe=False)
        here = Visit.of(see.displacement, see.own, see.seen)
        last = self.visits[-1] if len(self.visits) > self.n_calibration else None
        if last is not None and np.array_equal(last.displacement, here.displacement):
            same = np.array_equal(last.own, here.own, equal_nan=True)
            return replace(state, visits=(*self.visits[:-1], here)), not same
        kept = self.visits
        if see.noise_px == 0:  # the same posture again tells nothing of what moves a point
            others = (v for v in kept[self.n_calibration :] if np.abs(v.displacement - here.displacement).max() > SAME)
            kept = (*self.calibration, *others)
        over = max(len(kept) + 1 - options.max_visits, 0)
        n_calibration = max(self.n_calibration - over, 0)
        return replace(state, visits=(*kept[over:], here), n_calibration=n_calibration), True

    def with_estimate(self, best: Estimate | None) -> "EstimatorState":
        """Keep the likeliest hypothesis, and say why the images are not of the same body with an exact arm."""
        return replace(self, best=best, misfit=self._misfit_of(best))

    def _misfit_of(self, best: Estimate | None) -> Misfit | None:
        if best is not None and best.explanation is not None:
            return best.explanation.misfit.per_pixel(self.unit_px)
        mixed = {point for pair in self.exchanged for point in pair}
        if len(mixed) > MAX_SWAPPED:
            return Misfit(MisfitKind.MIXED_UP, tuple(sorted(mixed)))
        assert self.body is not None
        inexact = self.body.share or self.body.slack
        return Misfit(MisfitKind.ARM, amount=self.body.share or None) if inexact else None
