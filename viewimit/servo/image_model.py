"""What a learner knows of its own images: how they follow its displacements, ŷ(θ) = y + J (θ - θ_last).

J is learned by Broyden's updates (1965) from the motions themselves, nothing else; points that were not seen at both
ends of a motion teach nothing of it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .observation import Observation, Visit, by_coordinate

ENOUGH = 12  # points that were seen often, so that those seen rarely can be done without
SOFT = np.radians(0.2)  # motions of this size and below teach less, they are mostly noise


@dataclass(frozen=True)
class ImageModel:
    """jacobian: (N, 4, m) px/rad, J_u of Eq. (8); last: the visit that it is about; taught: (N,) how many motions at
    both ends of which a point was seen."""

    jacobian: NDArray
    last: Visit
    taught: NDArray

    @property
    def rarely_seen(self) -> NDArray:
        """(N,) bool: `rarely_taught`."""
        return rarely_taught(self.taught, self.jacobian.shape[-1])

    @classmethod
    def start(cls, seen: Observation) -> "ImageModel":
        """Nothing is known yet but the image that is seen."""
        here = Visit.of(seen.displacement, seen.own, seen.seen)
        return cls(np.zeros(seen.own.shape + seen.displacement.shape), here, np.zeros(len(seen.own), int))

    def learn(self, seen: Observation, soft: float = SOFT) -> "ImageModel":
        """Broyden's update from the motion made since. soft: rad, 0 to take even a tiny motion at its word."""
        moved = seen.displacement - self.last.displacement
        length = moved @ moved
        now = by_coordinate(seen.seen)
        expected = self.last.own + self.jacobian @ moved
        jacobian = self.jacobian
        taught = self.taught
        if length > 0:
            both = now & by_coordinate(self.last.seen)
            surprise = np.where(both, seen.own - expected, 0.0)
            taught = taught + both.all(-1)
            jacobian = jacobian + surprise[..., None] * moved / (length + soft**2)
        return ImageModel(jacobian, Visit(seen.displacement, np.where(now, seen.own, expected), seen.seen), taught)

    def predict(self, displacement: NDArray) -> NDArray:
        """(m,) rad → (N, 4) px"""
        return self.last.own + self.jacobian @ (displacement - self.last.displacement)


def rarely_taught(taught: NDArray, joints: int) -> NDArray:
    """(N,) bool: points taught by fewer motions than there are joints, if others were taught by that many. taught: (N,)
    motions."""
    return taught < min(joints, np.sort(taught)[-min(ENOUGH, len(taught))])
