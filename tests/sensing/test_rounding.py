"""The grid of rounded coordinates is told by themselves, and with it the error that rounding has made."""

import numpy as np
import pytest

from viewimit.estimation.noise import MIN_GRID_COORDINATES, rounding_std


def scattered(rng, *shape):
    return rng.uniform(20, 620, shape)


def seen(points):
    return np.ones((*points.shape[:-1], points.shape[-1] // 2), bool)


def to_grid(points, step, origin=0.0):
    return origin + np.round((points - origin) / step) * step


@pytest.mark.parametrize("kind", [np.float32, np.float64])
@pytest.mark.parametrize("origin", [0.0, 0.5, 0.37])
@pytest.mark.parametrize("step", [0.25, 0.5, 4 / 3, 1.0, 15 / 8, 2.5, 4.0, 20 / 7])
def test_it_is_the_error_that_was_made(step, origin, kind):
    points = scattered(np.random.default_rng(0), 10, 40, 8)
    rounded = to_grid(points, step, origin)
    made = np.sqrt(np.mean((rounded - points) ** 2))
    told = rounding_std(rounded.astype(kind), seen(points))
    assert told == pytest.approx(made, rel=0.05) and told == pytest.approx(step / np.sqrt(12))


def test_every_coordinate_of_every_view_has_a_grid_of_its_own():
    points = scattered(np.random.default_rng(1), 50, 4)
    rounded = to_grid(points, np.array([2.5, 1.875, 1.0, 1e-9]))
    assert rounding_std(rounded, seen(points)) == pytest.approx(np.sqrt((2.5**2 + 1.875**2 + 1) / 4 / 12))


def test_what_is_not_seen_tells_nothing():
    points = to_grid(scattered(np.random.default_rng(2), 20, 4), 1.0)
    visible = seen(points)
    points[3], visible[3] = np.nan, False
    points[5, 2:], visible[5, 1] = 0.123, False
    assert rounding_std(points, visible) == pytest.approx(1 / np.sqrt(12))


def test_of_what_lies_on_no_grid_it_is_nothing():
    for seed in range(200):
        rng = np.random.default_rng(seed)
        points = scattered(rng, MIN_GRID_COORDINATES, 8)
        assert rounding_std(points, seen(points)) == 0.0 == rounding_std(np.round(points, 2), seen(points))
        partly = np.where(rng.random((40, 1)) < 0.5, (many := scattered(rng, 40, 8)).round(), many)
        assert rounding_std(partly, seen(partly)) == 0.0


def test_of_few_equal_or_arranged_coordinates_it_is_nothing():
    whole = to_grid(scattered(np.random.default_rng(3), MIN_GRID_COORDINATES - 1, 4), 1.0)
    board = 40.0 * np.stack(np.meshgrid(*[np.arange(8)] * 2), -1).reshape(-1, 2)
    for points in (whole, np.full((30, 4), 7.0), board, np.empty((0, 4))):
        assert rounding_std(points, seen(points)) == 0.0
    assert rounding_std(whole, np.zeros((len(whole), 2), bool)) == 0.0
