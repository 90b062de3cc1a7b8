"""Noise that rounding leaves."""

from itertools import product

import numpy as np
import pytest

from viewimit.estimation.noise import rounding_std


def scattered(rng, *shape):
    return rng.uniform(20, 620, shape)


def seen(points):
    return np.ones((*points.shape[:-1], points.shape[-1] // 2), bool)


def to_grid(points, step, origin=0.0):
    return origin + np.round((points - origin) / step) * step


def test_rounding_std_equals_the_rounding_error_and_is_0_without_a_grid():
    points = scattered(np.random.default_rng(0), 10, 40, 8)
    assert rounding_std(points, seen(points)) == 0.0
    for step, origin, kind in product((0.25, 4 / 3, 1.0, 20 / 7), (0.0, 0.37), (np.float32, np.float64)):
        rounded = to_grid(points, step, origin)
        made = np.sqrt(np.mean((rounded - points) ** 2))
        found = rounding_std(rounded.astype(kind), seen(points))
        assert found == pytest.approx(made, rel=0.05) and found == pytest.approx(step / np.sqrt(12))
