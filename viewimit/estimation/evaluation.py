"""The conflict E of Eq. (6), Section 3, and how large noise makes it."""

import numpy as np
from numpy.typing import NDArray


def conflict(e: NDArray) -> NDArray:
    """E = 1/(2N) Σ (|e_L|² + |e_R|²), Eq. (6). e: (..., N, C) px → (...) px²."""
    return np.einsum("...ij,...ij->...", e, e) / (2 * e.shape[-2])


def noise_conflict(points: int, freedom: int, noise_px: float, deviations: float) -> float:
    """Return E up to which noise explains it, px²: a quantile of χ² (Wilson & Hilferty 1931).

    points: that make E; freedom: residuals that nothing fits; noise_px: standard deviation of a residual; deviations:
    of a standard normal variable with the same quantile.
    """
    spread = 2 / (9 * freedom)
    chi2 = freedom * (1 - spread + deviations * np.sqrt(spread)) ** 3
    return float(noise_px**2 * chi2 / (2 * points))
