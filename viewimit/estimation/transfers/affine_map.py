"""What every affine transfer comes down to: one 4 x 4 map between centred image points."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..equations import HOLE, Equation, column, each
from ..equations import matrix as holes
from .transfer import Transfer


@dataclass(frozen=True)
class AffineTransfer(Transfer):
    """[L; R] - own_mean = matrix ([l; r] - demo_mean). matrix: (..., 4, 4); demo_mean, own_mean: (..., 4) px."""

    matrix: NDArray
    demo_mean: NDArray
    own_mean: NDArray

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


def map_equation(matrix: NDArray, demo_mean: NDArray, own_mean: NDArray, demo: NDArray, name: str) -> Equation:
    """What stands in place of Eq. (4) if a point, demo: (4,) px in [l, r], is recovered by one map (4, 4) of points
    about their centroids, (4,) px each."""
    centred = demo - demo_mean
    recovered = own_mean + matrix @ centred
    return Equation(
        "",
        f"in place of (4), point {name}: centroid + map · (c − its centroid), px",
        rf"{{}}^{{LR}}\hat{{𝐮}}_{{{HOLE}}}={column(4)}+{holes(4, 4)}{column(4)}={column(4)}",
        (name, *each(own_mean, 0), *each(matrix, 2), *each(centred, 1), *each(recovered, 1)),
        wide=True,
    )
