"""Linear algebra on batches of small matrices, against LAPACK's of each matrix."""

import numpy as np
import pytest

from viewimit.geometry.small_matrices import (
    MIN_TAIL_BATCH,
    extreme_eigenvalues,
    inverse,
    smallest_eigenpair,
    tail_eigenvalue_sum,
)

MANY = MIN_TAIL_BATCH + 400
RNG = np.random.default_rng(0)


def of_eigenvalues(values):
    """(n, n, G) of (G, n): turned at random."""
    turned = np.linalg.qr(RNG.normal(size=(len(values), values.shape[1], values.shape[1])))[0]
    return np.ascontiguousarray(((turned * values[:, None]) @ turned.swapaxes(1, 2)).transpose(1, 2, 0))


def constant(*values):
    return np.broadcast_to(values, (MANY, len(values)))


def adjacent(value, others):
    """Two eigenvalues with a gap from 1e-15 to 0.1, and others."""
    gap = 10.0 ** RNG.uniform(-15, -1, MANY)
    return np.column_stack([np.full(MANY, value), value - gap, others])


CASES = {
    "any": RNG.uniform(0, 1, (MANY, 8)),
    "of other sizes": 10.0 ** RNG.uniform(-12, 5, (MANY, 8)),
    "the third as large as the fourth": adjacent(3.0, RNG.uniform([5, 5] + 4 * [0], [9, 9] + 4 * [2], (MANY, 6))),
    "the first as large as the second": adjacent(3.0, RNG.uniform(0, 2, (MANY, 6))),
    "rank 3": np.hstack([RNG.uniform(1, 9, (MANY, 3)), np.zeros((MANY, 5))]),
    "rank 2": np.hstack([RNG.uniform(1, 9, (MANY, 2)), np.zeros((MANY, 6))]),
    "rank 1": np.hstack([RNG.uniform(1, 9, (MANY, 1)), np.zeros((MANY, 7))]),
    "all equal": constant(*8 * [2.0]),
    "three equal": constant(5.0, 5.0, 5.0, 3.0, 2.0, 1.0, 0.5, 0.0),
    "zero": constant(*8 * [0.0]),
    "tiny": 1e-120 * RNG.uniform(0, 1, (MANY, 8)),
    "huge": 1e120 * RNG.uniform(0, 1, (MANY, 8)),
}


@pytest.mark.parametrize("case", CASES)
def test_the_tail_sum_equals_lapacks(case):
    S = of_eigenvalues(CASES[case])
    kept = S.copy()
    values = np.linalg.eigvalsh(S.transpose(2, 0, 1))
    found = tail_eigenvalue_sum(S, 3)
    assert (np.abs(found - values[:, :-3].sum(1)) <= 1e-9 * np.abs(values[:, -1])).all()
    assert np.array_equal(S, kept)


@pytest.mark.parametrize("n, rank", [(2, 1), (3, 1), (4, 3), (6, 2)])
def test_the_tail_sum_of_other_sizes_and_ranks(n, rank):
    values = RNG.uniform(0, 1, (MANY, n))
    expected = np.sort(values, axis=1)[:, :-rank].sum(1)
    np.testing.assert_allclose(tail_eigenvalue_sum(of_eigenvalues(values), rank), expected, atol=1e-11)


@pytest.mark.parametrize("n", [1, 3, 4, 6])
def test_inverses_equal_numpys(n):
    rng = np.random.default_rng(n)
    A = rng.normal(size=(6, n, n + 3))
    S = A @ A.transpose(0, 2, 1)
    found = np.moveaxis(inverse(np.moveaxis(S, 0, -1)), -1, 0)
    np.testing.assert_allclose(found, np.linalg.inv(S), rtol=1e-9, atol=1e-10)


def test_a_singular_matrix_has_no_finite_inverse_and_spoils_no_other():
    S = np.stack([np.diag([1.0, 0.0]), 2 * np.eye(2)], -1)
    kept = S.copy()
    found = inverse(S)
    assert not np.isfinite(found[..., 0]).all() and np.array_equal(found[..., 1], np.eye(2) / 2)
    assert np.array_equal(S, kept)


def blocks(W):
    """(G, 4, 4) → P, M, Q (2, 2, G)"""
    W = np.moveaxis(W, 0, -1)
    return W[:2, :2].copy(), W[:2, 2:].copy(), W[2:, 2:].copy()


def random_W(rng, values):
    """Symmetric matrices with the given eigenvalues (G, 4) and random axes."""
    Q, _ = np.linalg.qr(rng.normal(size=(len(values), 4, 4)))
    return (Q * values[:, None]) @ np.swapaxes(Q, 1, 2)


@pytest.mark.parametrize("gap", [1e-1, 1e-3, 1e-5, 1e-9, 0.0])
def test_eigenpair_solves_its_equation_however_close_the_next_eigenvalue(gap):
    rng = np.random.default_rng(7)
    smallest = rng.uniform(0, 0.3, 300)
    values = np.stack([smallest, smallest + gap, rng.uniform(0.5, 1, 300), rng.uniform(1, 2, 300)], 1) * 1e4
    W = random_W(rng, values)
    found, f = smallest_eigenpair(*blocks(W))
    # backward stable up to the accuracy promised with MIN_COFACTOR
    residual = np.einsum("gij,jg->ig", W, f) - found * f
    assert np.abs(residual).max() < 1e-9 * 1e4
    np.testing.assert_allclose(found, values[:, 0], atol=1e-7 * 1e4)
    if gap >= 1e-5:  # LAPACK itself errs by 1e-16 / gap
        vector = np.linalg.eigh(W)[1][:, :, 0].T
        np.testing.assert_allclose(f * np.sign((f * vector).sum(0)), vector, atol=1e-9)


def test_extreme_eigenvalues_agree_with_lapack():
    rng = np.random.default_rng(8)
    W = random_W(rng, rng.uniform(0.01, 2, (300, 4)))
    smallest, largest = extreme_eigenvalues(*blocks(W))
    expected = np.linalg.eigvalsh(W)
    trace = expected.sum(1)
    for found, k in ((smallest, 0), (largest, 3)):
        # a root is as exact as the polynomial's rounding, 1e-15 trace⁴, divided by its slope there
        slope = np.abs(np.prod(np.delete(expected, k, 1) - expected[:, k : k + 1], axis=1))
        assert np.all(np.abs(found - expected[:, k]) < 1e-15 * trace**4 / slope + 1e-12)
