"""What a servo is told at each motion, and what it may ask."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..geometry.rectification import Rectification
from .visit import Visit

PROBE = np.radians(15.0)
RESTARTS = 4  # far from where it has been, after which a servo has stalled


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
