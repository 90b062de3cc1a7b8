"""What a servo is told at each motion, and what it may ask."""

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..geometry.rectification import Rectification
from .visit import Visit

PROBE = np.radians(15.0)
RESTARTS = 4  # far from where it has been, after which a servo has stalled


@dataclass(frozen=True)
class Weighting:
    """How residuals are weighted by the noise of all images.

    own: (N, 4) px, the own images about which weights are taken; own_share: variance of the own images that are
    compared, as a share of that of the demonstrator's. With these weights the squares of a residual at the true posture
    are those of noise, whatever the scene is. own is None where no such images are known yet: residuals are then those
    of the demonstrator's images, all weighted alike, for its noise is what a transfer magnifies.
    """

    own: NDArray | None = None
    own_share: float = 0.0


class Conflict(Protocol):
    """Asks what the residual would be of images that a servo predicts; that needs no motion.

    own: (..., N, 4) px in [L, R], NaN for points that it knows nothing of; by: the name of a transfer in place of the
    chosen one; weighting: by which residuals are weighted, None for none; head: 0 for the head as it seems to be, or 1
    to `heads`. → e: (..., n, C) px of the n points that are known in all of them; where those are too few it is inf.
    """

    def __call__(
        self, own: NDArray, by: str | None = None, weighting: Weighting | None = None, head: int = 0
    ) -> NDArray: ...

    def with_half_seen(self) -> "Conflict":
        """The same that asks points of the demonstrator as well that one camera alone sees, after all others."""
        ...


@dataclass(frozen=True)
class Observation:
    """own: (N, 4) px, the learner's points in [L, R]; seen: (N, 2) bool in L, in R; E: px².

    displacement: (m,) rad, made since the start; lower, upper: (m,) rad, what the joint limits leave of it.
    motion: how many motions were made; noise_px: of an image coordinate, standard deviation, as measured at rest.
    rehearsed: what was seen of the own body before, with nobody to imitate, () if it never was rehearsed. shown: how
    many of the demonstrator's points are in sight; half_shown: and how many more in one image alone that can be asked.
    heads: how many other heads than it seems to be might be in its place, each one standard deviation off in another
    respect. rectification: of the images, None if they need none. max_step: rad, a joint, as far as the arm goes at
    once: a longer motion is made in several, and the servo asked after the last. restarts: how often the servo may look
    for something lower far from where it has been.
    """

    own: NDArray
    seen: NDArray
    E: float
    displacement: NDArray
    lower: NDArray
    upper: NDArray
    motion: int
    noise_px: float = 0.0
    rehearsed: tuple[Visit, ...] = ()
    shown: int = 0
    half_shown: int = 0
    heads: int = 0
    rectification: Rectification | None = None
    max_step: float = np.inf
    restarts: int = RESTARTS

    def displaced(self, by: NDArray) -> "Observation":
        """Of an arm that stands so far, (m,) rad, before where it was sent; it can be sent as far as before."""
        return replace(self, displacement=self.displacement - by, lower=self.lower - by, upper=self.upper - by)


def probe_of(joint: int, seen: Observation) -> NDArray:
    """(m,) rad, a motion to learn how the images move, not to arrive: one joint turned by 15°, or as far as the arm
    goes at once, towards where its limits leave more room."""
    above = seen.upper[joint] - seen.displacement[joint]
    below = seen.displacement[joint] - seen.lower[joint]
    step, far = np.zeros_like(seen.displacement), min(PROBE, seen.max_step)
    step[joint] = min(far, above) if above >= min(far, below) else -min(far, below)
    return step
