"""Batched Cholesky against numpy's, one by one."""

import numpy as np

from viewimit.geometry.cholesky import backward, factor, forward


def test_factor_and_solves_agree_with_numpy():
    rng = np.random.default_rng(0)
    A = rng.normal(size=(6, 4, 7))
    S = A.transpose(0, 1, 2) @ A.transpose(0, 2, 1)  # (6, 4, 4)
    B = rng.normal(size=(6, 4, 3))
    L = factor(np.moveaxis(S, 0, -1))
    np.testing.assert_allclose(np.moveaxis(L, -1, 0), np.linalg.cholesky(S), rtol=1e-10, atol=1e-12)
    solved = backward(L, forward(L, np.moveaxis(B, 0, -1)))
    np.testing.assert_allclose(np.moveaxis(solved, -1, 0), np.linalg.solve(S, B), rtol=1e-9, atol=1e-10)


def test_what_is_not_positive_definite_is_nan_and_spoils_no_other():
    S = np.stack([np.diag([1.0, -1.0]), np.eye(2)], -1)
    L = factor(S)
    assert np.isnan(L[1, 1, 0]) and np.array_equal(L[:, :, 1], np.eye(2))
