"""The trace without the largest eigenvalues, of many matrices at once, against LAPACK's of each."""

import numpy as np
import pytest

from viewimit.geometry.small_matrices import MIN_TAIL_BATCH, tail_eigenvalue_sum

MANY = MIN_TAIL_BATCH + 400
RNG = np.random.default_rng(0)


def of_eigenvalues(values):
    """(n, n, G) of (G, n): turned at random."""
    turned = np.linalg.qr(RNG.normal(size=(len(values), values.shape[1], values.shape[1])))[0]
    return np.ascontiguousarray(((turned * values[:, None]) @ turned.swapaxes(1, 2)).transpose(1, 2, 0))


def constant(*values):
    return np.broadcast_to(values, (MANY, len(values)))


def beside(value, others):
    """Two eigenvalues next to each other, from 1e-15 to 0.1 apart, and others."""
    apart = 10.0 ** RNG.uniform(-15, -1, MANY)
    return np.column_stack([np.full(MANY, value), value - apart, others])


CASES = {
    "any": RNG.uniform(0, 1, (MANY, 8)),
    "of other sizes": 10.0 ** RNG.uniform(-12, 5, (MANY, 8)),
    "the third as large as the fourth": beside(3.0, RNG.uniform([5, 5] + 4 * [0], [9, 9] + 4 * [2], (MANY, 6))),
    "the first as large as the second": beside(3.0, RNG.uniform(0, 2, (MANY, 6))),
    "rank 3": np.hstack([RNG.uniform(1, 9, (MANY, 3)), np.zeros((MANY, 5))]),
    "rank 2": np.hstack([RNG.uniform(1, 9, (MANY, 2)), np.zeros((MANY, 6))]),
    "rank 1": np.hstack([RNG.uniform(1, 9, (MANY, 1)), np.zeros((MANY, 7))]),
    "all equal": constant(*8 * [2.0]),
    "three equal": constant(5.0, 5.0, 5.0, 3.0, 2.0, 1.0, 0.5, 0.0),
    "nothing": constant(*8 * [0.0]),
    "tiny": 1e-120 * RNG.uniform(0, 1, (MANY, 8)),
    "huge": 1e120 * RNG.uniform(0, 1, (MANY, 8)),
}


@pytest.mark.parametrize("case", CASES)
def test_it_is_what_lapack_says_of_each(case):
    S = of_eigenvalues(CASES[case])
    kept = S.copy()
    values = np.linalg.eigvalsh(S.transpose(2, 0, 1))
    found = tail_eigenvalue_sum(S, 3)
    assert (np.abs(found - values[:, :-3].sum(1)) <= 1e-9 * np.abs(values[:, -1])).all()
    assert np.array_equal(S, kept)


@pytest.mark.parametrize("n, rank", [(2, 1), (3, 1), (4, 3), (6, 2)])
def test_of_other_sizes_and_ranks(n, rank):
    values = RNG.uniform(0, 1, (MANY, n))
    expected = np.sort(values, axis=1)[:, :-rank].sum(1)
    np.testing.assert_allclose(tail_eigenvalue_sum(of_eigenvalues(values), rank), expected, atol=1e-11)


def test_hardly_any_is_left_to_lapack(monkeypatch):
    asked = []
    by_lapack = np.linalg.eigvalsh
    monkeypatch.setattr(np.linalg, "eigvalsh", lambda S: asked.append(len(S)) or by_lapack(S))
    tail_eigenvalue_sum(of_eigenvalues(CASES["any"]), 3)
    assert sum(asked) < 0.05 * MANY


def test_diagonal_ones_need_no_reflection():
    values = RNG.uniform(0, 1, (MANY, 8))
    S = np.zeros((8, 8, MANY))
    S[range(8), range(8)] = values.T
    np.testing.assert_allclose(tail_eigenvalue_sum(S, 3), np.sort(values, axis=1)[:, :-3].sum(1), atol=1e-12)
