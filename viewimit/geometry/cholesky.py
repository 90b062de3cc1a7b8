"""Many small symmetric positive-definite systems at once, component axes first and the batch last."""

import numpy as np
from numpy.typing import NDArray


def factor(S: NDArray) -> NDArray:
    """L, lower triangular, of S = L Lᵀ. S: (n, n, ...) → (n, n, ...); NaN where S is not positive definite."""
    n = len(S)
    L = np.zeros_like(S)
    with np.errstate(invalid="ignore", divide="ignore"):
        for j in range(n):
            rest = S[j:, j] - np.einsum("ik...,k...->i...", L[j:, :j], L[j, :j])
            L[j:, j] = rest / np.sqrt(rest[0])
    return L


def forward(L: NDArray, B: NDArray) -> NDArray:
    """L⁻¹ B. L: (n, n, ...), B: (n, k, ...) → (n, k, ...)."""
    X = np.empty(np.broadcast_shapes(B.shape, B.shape[:2] + L.shape[2:]))
    for i in range(len(L)):
        X[i] = (B[i] - np.einsum("j...,jk...->k...", L[i, :i], X[:i])) / L[i, i]
    return X


def backward(L: NDArray, B: NDArray) -> NDArray:
    """L⁻ᵀ B. Shapes as in `forward`."""
    X = np.empty_like(B)
    for i in reversed(range(len(L))):
        X[i] = (B[i] - np.einsum("j...,jk...->k...", L[i + 1 :, i], X[i + 1 :])) / L[i, i]
    return X
