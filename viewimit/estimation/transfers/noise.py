"""How the noise of the demonstrator's images spreads over what a transfer recovers from them."""

import numpy as np
from numpy.typing import NDArray

from ..views import FourViews
from . import linear_combination


def noise_weight(views: FourViews, own_share: float = 1.0) -> NDArray:
    """C: (..., 4, 4), so that residuals e (..., N, 4) have even noise as e C: C Cᵀ = (κ I + BᵀB)⁻¹.

    own_share: κ, variance of the own images as a share of that of the demonstrator's.

    B maps centred [l; r] to [L; R], which carries the demonstrator's noise along. To be frozen while postures are
    compared: taken anew at each, it makes minima of its own.
    """
    B = np.swapaxes(linear_combination.fit(views).matrix, -1, -2)
    return np.linalg.cholesky(np.linalg.inv(own_share * np.eye(4) + np.swapaxes(B, -1, -2) @ B))
