"""What the postures visited have taught a learner of its own images."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...geometry.kinematics.clusters import Observations
from ...geometry.kinematics.model import ProjectiveKinematics
from ..observation import Visit
from .kinematic_images import KinematicImages
from .surrogate import Surrogate, learn

Images = Surrogate | KinematicImages  # foretold about a centre


@dataclass(frozen=True)
class Learned:
    """visits; noise_px: of an image coordinate, standard deviation; kinematics: that explain all visits, if any do."""

    visits: Sequence[Visit]
    noise_px: float
    kinematics: ProjectiveKinematics | None = None

    def about(self, centre: int = -1) -> Images:
        """About one of the visits."""
        if self.kinematics is None:
            return self._smoothly(centre)
        process = self._smoothly(centre) if self.kinematics.unknown.any() else None
        there = self.visits[centre].displacement
        return KinematicImages(self.kinematics, there, seen_at(self.visits), self.noise_px, process)

    def _smoothly(self, centre: int) -> Surrogate:
        return learn(list(self.visits), centre % len(self.visits), self.noise_px)


def seen_at(visits: Sequence[Visit]) -> Observations:
    displacement = np.array([visit.displacement for visit in visits])
    own = np.array([visit.own for visit in visits])
    return Observations(displacement, own, np.all([visit.seen for visit in visits], -1))
