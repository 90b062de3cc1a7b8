"""The inverses of many small symmetric positive-definite matrices at once, component axes first and the batch last."""

import numpy as np
from numpy.typing import NDArray


def inverse(S: NDArray) -> NDArray:
    """(n, n, ...) → (n, n, ...), by sweeping each row (Goodnight 1979); not finite where S is singular."""
    A = S.copy()
    with np.errstate(invalid="ignore", divide="ignore"):
        for j in range(len(A)):
            pivot, row = 1 / A[j, j], A[j] / A[j, j]
            A -= A[j][:, None] * row
            A[j] = A[:, j] = row
            A[j, j] = -pivot
    return -A
