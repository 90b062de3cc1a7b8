"""What a servo is told at each motion, and what it may ask."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..estimation.residuals import NoiseReference, ResidualFunction
from ..geometry.affine import image_unit
from ..geometry.rectification import Rectification

PROBE = np.radians(15.0)
RESTARTS = 4  # far from where it has been, after which a servo has stalled


@dataclass(frozen=True)
class Visit:
    """A posture really visited: displacement (m,) rad, own (N, 4) px, seen (N, 2) bool in [L], [R].

    Points not seen there are where the model expects them, NaN until they have been seen once.
    """

    displacement: NDArray
    own: NDArray
    seen: NDArray

    @classmethod
    def of(cls, displacement: NDArray, own: NDArray, seen: NDArray) -> "Visit":
        """Of images as they come, in which coordinates of points not seen mean nothing; kept in C order, so that sums
        do not depend on how the images lay in memory."""
        seen = np.ascontiguousarray(seen)
        return cls(displacement, np.where(by_coordinate(seen), np.ascontiguousarray(own), np.nan), seen)


def by_coordinate(seen: NDArray) -> NDArray:
    """(..., N, 2) of [L], [R] → (..., N, 4) of x_L, y_L, x_R, y_R."""
    return np.repeat(seen, 2, axis=-1)


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


# Images are scaled by their own size, so that a servo works the same with any camera. Kernels, thresholds and priors
# that are not standard deviations of noise are in these units. A unit stays the same during a run.


def unit_of(seen: Observation) -> float:
    """Return how many pixels one unit is, for an own body as it is seen first."""
    return image_unit(seen.own[seen.seen.all(-1)])


def in_units(seen: Observation, unit_px: float) -> Observation:
    """Return what is seen with all images, E and noise in units of so many pixels."""
    return replace(
        seen,
        own=seen.own / unit_px,
        E=seen.E / unit_px**2,
        noise_px=seen.noise_px / unit_px,
        rehearsed=tuple(Visit.of(visit.displacement, visit.own / unit_px, visit.seen) for visit in seen.rehearsed),
        rectification=None if seen.rectification is None else seen.rectification.in_units(unit_px),
    )


@dataclass(frozen=True)
class ScaledResiduals:
    """The conflict of own images that are in units of so many pixels, in the same units."""

    residuals: ResidualFunction
    unit_px: float

    def __call__(
        self, own: NDArray, transfer: str | None = None, noise_reference: NoiseReference | None = None, rig: int = 0
    ) -> NDArray:
        if noise_reference is not None and noise_reference.own is not None:
            noise_reference = replace(noise_reference, own=noise_reference.own * self.unit_px)
        return self.residuals(own * self.unit_px, transfer, noise_reference, rig) / self.unit_px

    def with_partially_visible(self) -> ResidualFunction:
        return ScaledResiduals(self.residuals.with_partially_visible(), self.unit_px)
