"""The minimiser of predicted images: the least-squares solution of a linear model, within its box, and its spread."""

import numpy as np
import pytest

from viewimit.servo.least_squares import minimise, standard_deviations

RNG = np.random.default_rng(0)
A, B = RNG.normal(0, 100, (8, 4, 3)), RNG.normal(0, 30, (8, 4))
SOLUTION = np.linalg.lstsq(A.reshape(32, 3), -B.reshape(32), rcond=None)[0]
OPEN = -np.ones(3), np.ones(3)


def linear(theta, noise=0.0):
    return np.einsum("ncj,...j->...nc", A, theta) + B + noise


def test_a_linear_model_is_solved():
    starts = RNG.uniform(-0.5, 0.5, (3, 3))
    found = minimise(linear, starts, *OPEN)
    np.testing.assert_allclose(found.theta, SOLUTION, atol=1e-4)
    np.testing.assert_allclose(found.hessian, np.einsum("nci,ncj->ij", A, A) / 8, rtol=1e-4)
    assert found.E_first == pytest.approx((linear(starts[0]) ** 2).sum() / 16)


def test_a_limit_in_the_way_is_not_passed():
    high = np.array([SOLUTION[0] - 0.05, 1, 1])
    found = minimise(linear, np.full((1, 3), -0.9), -np.ones(3), high)
    rest = np.linalg.lstsq(A.reshape(32, 3)[:, 1:], -(B + A[..., 0] * high[0]).reshape(32), rcond=None)[0]
    np.testing.assert_allclose(found.theta, [high[0], *rest], atol=1e-4)


def test_the_spread_is_that_of_solutions_over_many_draws_of_the_noise():
    noise = RNG.normal(0, 2.0, (2000, 8, 4))
    solved = np.linalg.lstsq(A.reshape(32, 3), (noise - B).reshape(-1, 32).T, rcond=None)[0]
    found = minimise(linear, np.zeros((1, 3)), *OPEN)
    spread = 2.0 * standard_deviations(found.hessian, found.points)
    np.testing.assert_allclose(
        spread, solved.std(1), rtol=0.1
    )  # 6 standard standard_deviations of a deviation of 2,000


@pytest.mark.parametrize("seed", range(6))
def test_a_joint_that_nothing_tells_stays_whatever_is_rounded(seed):
    """It moves the same images as another, and next to not at all."""
    slopes, rng = A.copy(), np.random.default_rng(seed)
    slopes[..., 2] = 1e-4 * slopes[..., 1]
    rounded = lambda theta: np.einsum("ncj,...j->...nc", slopes, theta) + B + 1e-12 * rng.normal(size=(8, 4))
    theta = minimise(rounded, np.zeros((1, 3)), *OPEN).theta
    solved = np.linalg.lstsq(slopes.reshape(32, 3)[:, :2], -B.reshape(32), rcond=None)[0]
    np.testing.assert_allclose(theta, [*solved, 0], atol=1e-4)
