"""Image prediction by Gaussian-process regression: the textbook's equations, linear images, and hidden points."""

import numpy as np
import pytest

from viewimit.servo.observation import Visit
from viewimit.servo.trust_region.gaussian_process import (
    BEND_PX,
    LENGTH_RAD,
    MIN_NOISE_PX,
    OFFSET_PX,
    SLOPE_PX,
    GaussianProcessImages,
)


def kernel(a, b):
    return OFFSET_PX**2 + SLOPE_PX**2 * (a @ b) + BEND_PX**2 * np.exp(-((a - b) @ (a - b)) / (2 * LENGTH_RAD**2))


def visits_of(images, displacements, seen=None):
    seen = np.ones((len(displacements), len(images(displacements[0])), 2), bool) if seen is None else seen
    return [Visit(d, np.where(np.repeat(s, 2, -1), images(d), np.nan), s) for d, s in zip(displacements, seen)]


@pytest.fixture
def linear():
    rng = np.random.default_rng(0)
    J, y = rng.normal(0, 100, (6, 4, 2)), rng.uniform(0, 240, (6, 4))
    return (lambda theta: y + J @ theta), rng


def test_predictions_are_the_textbooks_for_each_coordinate(linear):
    images, rng = linear
    places = rng.uniform(-0.5, 0.5, (5, 2))
    curved = lambda theta: images(theta) + 20 * np.sin(3 * theta[0]) * theta[1]
    visits = visits_of(curved, places)
    asked = rng.uniform(-0.7, 0.7, (3, 2))
    found = GaussianProcessImages.fit(visits, 2, 0.5).predict(asked)
    away = places - places[2]
    K = np.array([[kernel(a, b) for b in away] for a in away]) + 0.25 * np.eye(5)
    for point, coordinate in np.ndindex(6, 4):
        rise = [visit.own[point, coordinate] - visits[2].own[point, coordinate] for visit in visits]
        for k, theta in enumerate(asked):
            row = [kernel(theta - places[2], b) for b in away]
            expected = visits[2].own[point, coordinate] + row @ np.linalg.solve(K, rise)
            assert found[k, point, coordinate] == pytest.approx(expected, abs=1e-6)


def test_prediction_variances_are_the_textbooks(linear):
    images, rng = linear
    places, asked = rng.uniform(-0.5, 0.5, (5, 2)), rng.uniform(-0.7, 0.7, (3, 2))
    seen = np.ones((5, 6, 2), bool)
    seen[:2, 1], seen[2, 3, 0], seen[:, 4] = False, False, False
    found = GaussianProcessImages.fit(visits_of(images, places, seen), 2, 0.5).prediction_std(asked)
    away = places - places[2]
    for point in range(6):
        told = np.flatnonzero(seen[:, point].all(-1))
        for k, theta in enumerate(asked - places[2]):
            K = np.array([[kernel(away[a], away[b]) for b in told] for a in told]) + 0.25 * np.eye(len(told))
            row = np.array([kernel(theta, away[a]) for a in told])
            left = kernel(theta, theta) - row @ np.linalg.solve(K, row) if len(told) else np.inf
            assert found[k, point] == pytest.approx(np.sqrt(left), rel=1e-6)


def test_a_linear_image_is_predicted_after_one_visit_more_than_joints(linear):
    """The bend's part of the kernel pulls a little away from the line: less than 2 % of the way."""
    images, _ = linear
    visits = visits_of(images, np.array([[0.0, 0], [0.26, 0], [0.26, 0.26]]))
    theta = np.array([0.2, 0.1])
    assert (
        np.abs(GaussianProcessImages.fit(visits, 0, 0.0).predict(theta) - images(theta)).max()
        < 0.02 * np.abs(images(theta) - images(theta * 0)).max()
    )


def test_visits_are_interpolated_and_noise_is_averaged(linear):
    images, rng = linear
    places = rng.uniform(-0.1, 0.1, (40, 2))
    exact = GaussianProcessImages.fit(visits_of(images, places), 0, 0.0)
    np.testing.assert_allclose(exact.predict(places), [images(p) for p in places], atol=10 * MIN_NOISE_PX)
    noisy = visits_of(lambda theta: images(theta) + rng.normal(0, 2.0, (6, 4)), places)
    error = GaussianProcessImages.fit(noisy, 0, 2.0).predict(places) - [images(p) for p in places]
    assert np.sqrt((error**2).mean()) < 0.4 * 2.0  # a linear map of 12 numbers a point, from 160: √(3/40) = 0.27


def test_hidden_points_are_ignored_and_points_never_seen_are_not_predicted(linear):
    images, rng = linear
    places = rng.uniform(-0.5, 0.5, (6, 2))
    seen = np.ones((6, 6, 2), bool)
    seen[2, 0, 1] = seen[4, 3, 0] = False
    seen[:, 5, 0] = False
    whole, partly = (
        GaussianProcessImages.fit(visits_of(images, places), 1, 0.0),
        GaussianProcessImages.fit(visits_of(images, places, seen), 1, 0.0),
    )
    asked = rng.uniform(-0.5, 0.5, (4, 2))
    found = partly.predict(asked)
    assert np.isnan(found[:, 5, :2]).all() and not np.isnan(np.delete(found, 5, 1)).any()
    np.testing.assert_allclose(found[:, [1, 2, 4]], whole.predict(asked)[:, [1, 2, 4]], atol=1e-8)
    kept = [visit for k, visit in enumerate(visits_of(images, places)) if k != 2]
    np.testing.assert_allclose(
        found[:, 0, 2:], GaussianProcessImages.fit(kept, 1, 0.0).predict(asked)[:, 0, 2:], atol=1e-6
    )


def test_predicted_images_are_weighted_sums_of_the_visited_ones(linear):
    images, rng = linear
    places = rng.uniform(-0.5, 0.5, (6, 2))
    visits = visits_of(lambda theta: images(theta) + 20 * np.sin(3 * theta[0]), places)
    model = GaussianProcessImages.fit(visits, 2, 0.5)
    for theta in rng.uniform(-0.7, 0.7, (3, 2)):
        weights = model.image_weights(theta)
        assert weights.sum() == pytest.approx(1)
        told = np.tensordot(weights, [visit.own for visit in visits], 1)
        np.testing.assert_allclose(told, model.predict(theta), atol=1e-6)


def test_the_jacobian_is_the_difference_of_predicted_images(linear):
    images, rng = linear
    places = rng.uniform(-0.5, 0.5, (5, 2))
    curved = lambda theta: images(theta) + 20 * np.sin(3 * theta[0]) * theta[1]
    model, theta, step = (
        GaussianProcessImages.fit(visits_of(curved, places), 2, 0.5),
        np.array([0.2, -0.3]),
        1e-4 * np.eye(2),
    )
    expected = (model.predict(theta + step) - model.predict(theta - step)) / 2e-4
    np.testing.assert_allclose(model.jacobian(theta), expected, atol=1e-5)
