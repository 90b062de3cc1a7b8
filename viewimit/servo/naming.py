"""Which of the demonstrator's points is which point of the own body, as a servo found."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Names = NDArray[np.int_]
CERTAIN = 0.99  # probability from which a name is certain
ENOUGH = 10  # certain names with which uncertain ones can be left out


@dataclass(frozen=True)
class Naming:
    """Which of the demonstrator's points is which point of the own body."""

    names: Names  # (N,): the demonstrator's point of each own point, -1 of points without a partner
    unnamed: Names  # the demonstrator's points that have no partner
    probability: Array  # (N,): that the name is right rather than exchanged with another; NaN without a partner
    displacement: Array  # (m,) rad, in which the two bodies agree
    E: float  # px², that the naming leaves there
    E_noise: float  # px², of it that noise explains
    accepted: bool  # whether noise explains E
    rival: Names | None = None  # (N,): other names that may explain the images as well; None: there are none

    def per_pixel(self, unit_px: float) -> "Naming":
        """Convert E from image units of unit_px pixels to px²."""
        return replace(self, E=self.E * unit_px**2, E_noise=self.E_noise * unit_px**2)

    @property
    def certain(self) -> NDArray[np.bool_]:
        """(N,): points whose name is hardly another."""
        return np.nan_to_num(self.probability) >= CERTAIN

    @property
    def used(self) -> Names:
        """(N,): names to compute with. Uncertain ones are left out if enough others remain: a wrong one adds to E."""
        return np.where(self.certain, self.names, -1) if self.certain.sum() >= ENOUGH else self.names

    @property
    def is_ambiguous(self) -> bool:
        """Whether there are two answers."""
        return self.rival is not None
