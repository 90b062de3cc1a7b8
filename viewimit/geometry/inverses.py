"""The inverses of many small symmetric positive-definite matrices at once, component axes first and the batch last."""

import numpy as np
from numpy.typing import NDArray


def inverse(S: NDArray) -> NDArray:
    """(n, n, ...) → (n, n, ...), by blocks (Banachiewicz 1937); not finite where S is singular."""
    inverted = np.empty_like(S)
    with np.errstate(invalid="ignore", divide="ignore"):
        _invert(S, inverted)
    return inverted


def _invert(S: NDArray, into: NDArray) -> None:
    """into: (n, n, ...), where the inverse is written."""
    n = len(S)
    if n == 1:
        np.divide(1, S, out=into)
        return
    if n == 2:
        scale = 1 / (S[0, 0] * S[1, 1] - S[0, 1] * S[0, 1])
        np.multiply(S[1, 1], scale, out=into[0, 0])
        np.multiply(S[0, 0], scale, out=into[1, 1])
        into[0, 1] = np.multiply(S[0, 1], -scale, out=into[1, 0])
        return
    k = n // 2
    off, upper, lower, right = S[:k, k:], into[:k, :k], into[k:, k:], into[:k, k:]
    _invert(S[:k, :k], upper)
    across = np.einsum("ij...,jk...->ik...", upper, off)
    _invert(S[k:, k:] - np.einsum("ji...,jk...->ik...", off, across), lower)  # of the Schur complement
    apart = np.einsum("ij...,jk...->ik...", across, lower)
    upper += np.einsum("ij...,kj...->ik...", apart, across)
    np.negative(apart, out=right)
    into[k:, :k] = right.swapaxes(0, 1)
