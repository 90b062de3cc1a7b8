"""Exponentials of conjugate twists are what the power series has."""

import numpy as np
import pytest

from viewimit.geometry.kinematics.model import exponentials, powers, twist_matrices


def series(matrix):
    """exp by its definition."""
    term, total = np.eye(4), np.eye(4)
    for k in range(1, 40):
        term = term @ matrix / k
        total = total + term
    return total


@pytest.mark.parametrize(
    "twist", [[0.3, -0.5, 0.8, 0.1, 0.2, -0.4], [0, 0, 0, 0.3, -0.2, 0.5], [1e-9, 0, 0, 0.3, 1, 2]]
)
def test_an_exponential_is_its_series_in_any_frame(twist):
    rng = np.random.default_rng(1)
    A = np.eye(4) + 0.3 * rng.normal(size=(4, 4))
    S = twist_matrices(np.array([twist]))
    G, rate = np.linalg.inv(A) @ S @ A, np.linalg.norm(np.array([twist])[:, :3], axis=1)
    angles = np.array([[0.0], [1e-7], [0.7], [-2.5]])
    found = exponentials(powers(G, rate), rate, angles)
    for angle, motion in zip(angles[:, 0], found[:, 0]):
        np.testing.assert_allclose(motion, series(angle * G[0]), atol=1e-7)


def test_several_bodies_at_once_are_each_by_itself():
    rng = np.random.default_rng(2)
    G = twist_matrices(rng.normal(size=(3, 2, 6)))
    rate = np.linalg.norm(G[..., [2, 0, 1], [1, 2, 0]], axis=-1)
    angles = rng.uniform(-2, 2, (5, 2))
    together = exponentials(powers(G, rate), rate, angles)
    assert together.shape == (3, 5, 2, 4, 4)
    for k in range(3):
        np.testing.assert_allclose(together[k], exponentials(powers(G[k], rate[k]), rate[k], angles), atol=1e-12)
