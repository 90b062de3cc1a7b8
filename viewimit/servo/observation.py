"""What a servo is told at each motion."""

from collections.abc import Callable
from dataclasses import dataclass

from numpy.typing import NDArray

Conflict = Callable[..., NDArray]


@dataclass(frozen=True)
class Observation:
    """own: (N, 4) px, the learner's points in [L, R]; seen: (N, 2) bool in L, in R; E: px².

    displacement: (m,) rad, made since the start; lower, upper: (m,) rad, what the joint limits leave of it.
    motion: how many motions were made; noise_px: of an image coordinate, standard deviation, as measured at rest.
    """

    own: NDArray
    seen: NDArray
    E: float
    displacement: NDArray
    lower: NDArray
    upper: NDArray
    motion: int
    noise_px: float = 0.0
