"""The conflict E of Eq. (6), Section 3."""

import numpy as np
from numpy.typing import NDArray


def conflict(e: NDArray) -> NDArray:
    """E = 1/(2N) Σ (|e_L|² + |e_R|²), Eq. (6). e: (..., N, C) px → (...) px²."""
    return np.einsum("...ij,...ij->...", e, e) / (2 * e.shape[-2])
