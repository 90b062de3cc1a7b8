"""The inverses of many small symmetric positive-definite matrices at once, component axes first and the batch last."""

import numpy as np
from numpy.typing import NDArray


def inverse(S: NDArray) -> NDArray:
    """(n, n, ...) → (n, n, ...), by blocks (Banachiewicz 1937); not finite where S is singular."""
    with np.errstate(invalid="ignore", divide="ignore"):
        return _inverse(S)


def _inverse(S: NDArray) -> NDArray:
    n = len(S)
    if n == 1:
        return 1 / S
    inverted = np.empty_like(S)
    if n == 2:
        scale = 1 / (S[0, 0] * S[1, 1] - S[0, 1] * S[0, 1])
        np.multiply(S[1, 1], scale, out=inverted[0, 0])
        np.multiply(S[0, 0], scale, out=inverted[1, 1])
        inverted[0, 1] = np.multiply(S[0, 1], -scale, out=inverted[1, 0])
        return inverted
    k = n // 2
    upper, off = _inverse(S[:k, :k]), S[:k, k:]
    across = np.einsum("ij...,jk...->ik...", upper, off)
    lower = _inverse(S[k:, k:] - np.einsum("ji...,jk...->ik...", off, across))  # of the Schur complement
    apart = np.einsum("ij...,jk...->ik...", across, lower)
    inverted[:k, :k] = upper
    inverted[:k, :k] += np.einsum("ij...,kj...->ik...", apart, across)
    inverted[k:, k:] = lower
    np.negative(apart, out=inverted[:k, k:])
    inverted[k:, :k] = inverted[:k, k:].swapaxes(0, 1)
    return inverted
