"""What every affine transfer comes down to: one 4 x 4 map between centred image points."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .transfer import Transfer


@dataclass(frozen=True)
class AffineTransfer(Transfer):
    """[L; R] - own_mean = matrix ([l; r] - demo_mean).

    matrix: (..., 4, 4); demo_mean, own_mean: (..., 4) px; measure_condition: asked when `condition` is first read.
    """

    matrix: NDArray
    demo_mean: NDArray
    own_mean: NDArray
    measure_condition: Callable[[], NDArray]

    @cached_property
    def condition(self) -> NDArray:
        """How far the transfer's linear system amplifies errors: (...), ≥ 1, inf where it is singular."""
        return self.measure_condition()

    def recover(self, demo_left: ArrayLike, demo_right: ArrayLike) -> NDArray:
        demo = np.concatenate([demo_left, demo_right], -1) - self.demo_mean[..., None, :]
        recovered = _mapped(self.matrix, demo)
        recovered += self.own_mean[..., None, :]
        return recovered


def _mapped(matrix: NDArray, points: NDArray) -> NDArray:
    """matrix: (..., 4, 4), points: (..., M, 4) or (M, 4) for all → (..., M, 4)."""
    if points.ndim > 2:
        return points @ np.swapaxes(matrix, -1, -2)
    batch = matrix.shape[:-2]
    columns = matrix.reshape(-1, 4, 4).transpose(1, 2, 0)  # batch last, as `fit` left it in memory: one product
    return (points @ columns).transpose(2, 1, 0).reshape(batch + points.shape)
