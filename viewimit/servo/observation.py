"""The input of a servo at each motion, and the visits that it remembers."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ..estimation.residuals import ResidualFunction
from ..geometry.affine import image_unit
from ..geometry.rectification import Rectification

PROBE_RAD = np.radians(15.0)  # rad: images change visibly, and nearly linearly


@dataclass(frozen=True)
class Visit:
    """A posture that the arm has been at, and the images seen there."""

    displacement: NDArray[np.float64]  # (m,) rad, from the start
    own: NDArray[np.float64]  # (N, 4) px in [L, R]; NaN where a point is not seen
    seen: NDArray[np.bool_]  # (N, 2) in [L], [R]

    @classmethod
    def of(cls, displacement: NDArray[np.float64], own: NDArray[np.float64], seen: NDArray[np.bool_]) -> "Visit":
        """Make a visit of images in which the coordinates of hidden points are arbitrary.

        Arrays are kept in C order, so that sums do not depend on their layout in memory.
        """
        seen = np.ascontiguousarray(seen)
        return cls(displacement, np.where(repeat_xy(seen), np.ascontiguousarray(own), np.nan), seen)


def repeat_xy(seen: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Repeat values for [L], [R] as for x_L, y_L, x_R, y_R: (..., N, 2) → (..., N, 4)."""
    return np.repeat(seen, 2, axis=-1)


@dataclass(frozen=True)
class Observation:
    """The input of a servo: image points and its own displacements, never a posture, a body or a camera."""

    own: NDArray[np.float64]  # (N, 4) px, the learner's points in [L, R]; NaN where a point is not visible
    seen: NDArray[np.bool_]  # (N, 2), which of them are visible in L, in R
    E: float  # px², the conflict; NaN with too few points
    displacement: NDArray[np.float64]  # (m,) rad, where the arm was sent, from the session's start posture
    lower: NDArray[np.float64]  # (m,) rad, joint limits of the displacement
    upper: NDArray[np.float64]  # (m,) rad
    motion: int  # number of motions made
    noise_px: float = 0.0  # px, standard deviation of an image coordinate, as measured at rest
    calibration: tuple[Visit, ...] = ()  # visits of a rehearsal, before there was a demonstrator
    rectification: Rectification | None = None  # of the images; None: they need none
    max_step: float = np.inf  # rad per joint: a longer motion is made in several, and the servo asked after the last
    # (N, 4) px, own points minus those recovered from the demonstrator; NaN where a point is not visible in all views
    residual: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 4)))
    demo: NDArray[np.float64] | None = None  # (N, 4) px, the demonstrator's points in [l, r]; NaN where not visible
    # (N, 4) px, the same, averaged over all looks since the demonstrator last moved; None: there is only `demo`
    demo_average: NDArray[np.float64] | None = None
    demo_noise_px: float | None = None  # px, standard deviation of a coordinate of that; None: `noise_px`
    seed: int = 0  # of the session, for random searches
    matched: bool = True  # whether these are the own points, one by one; otherwise they are in an unknown order

    @property
    def demonstrator(self) -> tuple[NDArray[np.float64], float]:
        """Its points in [l, r], (N, 4) px, from all looks since it last moved, and their standard deviation, px."""
        demo = self.demo if self.demo_average is None else self.demo_average
        demo = np.full_like(self.own, np.nan) if demo is None else demo
        return demo, self.noise_px if self.demo_noise_px is None else self.demo_noise_px


def probe_motion(joint: int, observation: Observation) -> NDArray[np.float64]:
    """Return a motion of one joint that shows how the images depend on it: (m,) rad.

    It turns by 15°, or by `max_step`, towards the side where the limits leave more room.
    """
    above = observation.upper[joint] - observation.displacement[joint]
    below = observation.displacement[joint] - observation.lower[joint]
    step, far = np.zeros_like(observation.displacement), min(PROBE_RAD, observation.max_step)
    step[joint] = min(far, above) if above >= min(far, below) else -min(far, below)
    return step


# Images are scaled by their own size, so that a servo works the same with any camera. Kernels, thresholds and priors
# that are not standard deviations of noise are in these units. A unit stays the same during a run.


def unit_of(observation: Observation) -> float:
    """Return the pixels of one image unit, by the own body in the first observation."""
    return image_unit(observation.own[observation.seen.all(-1)])


def in_units(observation: Observation, unit_px: float) -> Observation:
    """Convert images, E and noise from px to image units."""
    rectification = observation.rectification
    return replace(
        observation,
        own=observation.own / unit_px,
        demo=None if observation.demo is None else observation.demo / unit_px,
        demo_average=None if observation.demo_average is None else observation.demo_average / unit_px,
        demo_noise_px=None if observation.demo_noise_px is None else observation.demo_noise_px / unit_px,
        E=observation.E / unit_px**2,
        residual=observation.residual / unit_px,
        noise_px=observation.noise_px / unit_px,
        calibration=tuple(Visit.of(one.displacement, one.own / unit_px, one.seen) for one in observation.calibration),
        rectification=None if rectification is None else rectification.in_units(unit_px),
    )


@dataclass(frozen=True)
class ScaledResiduals:
    """Residuals in image units, of own images in image units."""

    residuals: ResidualFunction
    unit_px: float  # pixels of one unit

    def __call__(self, own: NDArray[np.float64]) -> NDArray[np.float64]:
        """Compute residuals, as `ResidualFunction`."""
        return self.residuals(own * self.unit_px) / self.unit_px
