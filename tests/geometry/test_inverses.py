"""Many inverses at once against numpy's, one by one."""

import numpy as np
import pytest

from viewimit.geometry.small_matrices import inverse


@pytest.mark.parametrize("n", [1, 3, 4, 6])
def test_inverses_are_numpys(n):
    rng = np.random.default_rng(n)
    A = rng.normal(size=(6, n, n + 3))
    S = A @ A.transpose(0, 2, 1)
    found = np.moveaxis(inverse(np.moveaxis(S, 0, -1)), -1, 0)
    np.testing.assert_allclose(found, np.linalg.inv(S), rtol=1e-9, atol=1e-10)


def test_a_singular_one_is_not_finite_and_spoils_no_other():
    S = np.stack([np.diag([1.0, 0.0]), 2 * np.eye(2)], -1)
    kept = S.copy()
    found = inverse(S)
    assert not np.isfinite(found[..., 0]).all() and np.array_equal(found[..., 1], np.eye(2) / 2)
    assert np.array_equal(S, kept)
