"""The evaluation function of Section 3: residuals of a transfer, and the conflict E of Eq. (6)."""

import numpy as np
from numpy.typing import NDArray

from .views import FourViews


def residual(transfer, views: FourViews) -> NDArray:
    """e: (..., N, 4) px, from the recovered points to the learner's own; a transfer may have those in [l, r] too."""
    return transfer.residual(views)


def conflict(e: NDArray) -> NDArray:
    """E = 1/(2N) Σ (|e_L|² + |e_R|²), Eq. (6). e: (..., N, C) px → (...) px²."""
    return np.einsum("...ij,...ij->...", e, e) / (2 * e.shape[-2])
