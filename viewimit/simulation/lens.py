"""What a camera makes of directions: focal lengths, centre, and radial distortion, which images may be rid of."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..geometry.distortion import Radial


@dataclass(frozen=True)
class Lens:
    """focal: (fx, fy), centre: px; distortion: of the lens; undone: the one that its images are rid of, which is the
    lens's own as far as its owner knows it."""

    focal: tuple[float, float]
    centre: tuple[float, float]
    distortion: Radial = Radial()
    undone: Radial = Radial()

    @cached_property
    def bends(self) -> bool:
        """Whether images are not those of a pinhole."""
        return self.distortion != self.undone

    @property
    def aspect(self) -> float:
        """fy/fx, 1 for square pixels."""
        return self.focal[1] / self.focal[0]

    def stretch(self, squared: NDArray) -> NDArray:
        """How many times as far from the centre an image is as a pinhole's. squared: r², of that, in focal lengths."""
        factor = self.distortion.stretch(squared)
        return factor * self.undone.undone(squared * factor * factor) if self.undone.bends else factor

    def direction(self, image: NDArray) -> NDArray:
        """image: (..., 2) px → (..., 2), where its ray meets the plane one focal length ahead."""
        on_plane = (image - self.centre) / self.focal
        if not self.bends:
            return on_plane
        squared = (on_plane * on_plane).sum(-1)
        factor = self.undone.stretch(squared)
        return on_plane * (factor * self.distortion.undone(squared * factor * factor))[..., None]

    def shows(self, image: NDArray) -> bool:
        """Whether what is seen in all of image, (..., 2) px, can be told."""
        seen = np.hypot(*((image - self.centre) / self.focal).reshape(-1, 2).T)
        return bool((seen < min(self.distortion.rim, self.undone.reach)).all())


def undistorted(points: NDArray, focal: tuple[float, float], centre: tuple[float, float], by: Radial) -> NDArray:
    """(..., 2) px of a lens with that distortion → px of a pinhole."""
    return Lens(focal, centre, by).direction(points) * focal + centre
