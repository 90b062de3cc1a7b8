"""Images in units of their own size, so that a servo ends the same whatever its eyes measure in.

Kernels, thresholds and priors that are no standard deviations of noise are in such units, which stay the same through a
run. See `geometry.affine.image_unit`.
"""

from dataclasses import dataclass, replace

from numpy.typing import NDArray

from ..estimation.residuals import NoiseReference, ResidualFunction
from ..geometry.affine import image_unit
from .observation import Observation
from .visit import Visit


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
