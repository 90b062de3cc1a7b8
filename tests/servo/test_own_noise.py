"""What the noise of the own images adds to a landscape, against drawing that noise anew many times."""

import numpy as np
import pytest

from viewimit.servo.observation import Visit
from viewimit.servo.trust_region.gaussian_process import GaussianProcessImages
from viewimit.servo.trust_region.image_models import estimate_own_noise

POINTS, NOISE, DRAWS = 8, 0.5, 1500
PLACES = np.radians([(0, 0), (15, 0), (15, 15), (3, -4), (-2, 6), (1, 1)])
TOLERANCE = 4 / np.sqrt(DRAWS)  # four standard deviations of a variance that is estimated from so many draws


@pytest.fixture(scope="module")
def body():
    """A linear body, visited with noise, and residuals that are linear in its images, as if a transfer's twelve
    parameters took part of them over: seed → surrogate, and own images → residuals."""
    rng = np.random.default_rng(3)
    J, y = rng.normal(0, 100, (POINTS, 4, 2)), rng.uniform(0, 240, (POINTS, 4))
    blind = np.linalg.qr(rng.normal(size=(4 * POINTS, 12)))[0]
    goal = (y + J @ np.radians((2, 1))).ravel()
    left = lambda e: e - (e @ blind) @ blind.T
    residual_of = lambda own: left(own.reshape(*own.shape[:-2], -1) - goal).reshape(own.shape)

    def model(seed):
        drawn = np.random.default_rng(seed)
        seen = np.ones((POINTS, 2), bool)
        visits = [Visit(d, y + J @ d + drawn.normal(0, NOISE, (POINTS, 4)), seen) for d in PLACES]
        return GaussianProcessImages.fit(visits, len(visits) - 1, NOISE)

    return model, residual_of


def slopes(model, residual_of, place):
    step = 1e-4
    e = residual_of(model.predict(np.concatenate([place + step * np.eye(2), place - step * np.eye(2), place[None]])))
    J = (e[:2] - e[2:4]).reshape(2, -1) / (2 * step)
    return J, e[4].ravel()


def test_slopes_that_are_learned_from_noise_add_the_curvature_that_it_says(body):
    model, residual_of = body
    place = np.radians((2.0, 1.0))
    drawn = np.array([slopes(model(k), residual_of, place)[0] for k in range(DRAWS)])
    mean = drawn.mean(0)
    added = (drawn @ drawn.swapaxes(1, 2)).mean(0) / POINTS - mean @ mean.T / POINTS
    said = estimate_own_noise(model(0), residual_of, place, NOISE, 20, 1).hessian_bias
    share = np.abs(np.linalg.eigvalsh(np.linalg.solve(added, said)) - 1).max()
    assert share < TOLERANCE + 0.25  # DRAWS of own_noise estimate what is left of 32 - 12 residuals


def test_gradients_are_as_large_as_those_that_noise_makes(body):
    model, residual_of = body
    place = np.radians((2.0, 1.0))
    slopes_drawn, e_drawn = zip(*(slopes(model(k), residual_of, place) for k in range(DRAWS)))
    made = np.array(e_drawn) @ np.mean(slopes_drawn, axis=0).T / POINTS
    said = np.concatenate(
        [estimate_own_noise(model(k), residual_of, place, NOISE, 20, k).grad_samples_images for k in range(60)]
    )
    np.testing.assert_allclose(np.sqrt((said**2).mean(0)), made.std(0), rtol=0.25)


def test_of_a_curvature_is_left_what_surely_is_not_noise(body):
    model, residual_of = body
    noise = estimate_own_noise(model(0), residual_of, np.zeros(2), NOISE, 20, 1)
    for k in range(1, 20):  # what noise alone makes is nothing
        J = slopes(model(k), residual_of, np.zeros(2))[0]
        J = J - np.mean([slopes(model(m), residual_of, np.zeros(2))[0] for m in range(1, 20)], axis=0)
        H = J @ J.T / POINTS
        assert np.linalg.eigvalsh(noise.debias_hessian(H))[0] < 0.05 * np.trace(noise.hessian_bias)
    steep = 1e4 * np.trace(noise.hessian_bias) * np.eye(2)
    np.testing.assert_allclose(noise.debias_hessian(steep), steep, rtol=1e-3, atol=1e-3 * steep[0, 0])
    both = noise.debias_hessian(np.stack([steep, noise.hessian_bias]))
    np.testing.assert_allclose(both[0], noise.debias_hessian(steep))
    assert (np.linalg.eigvalsh(both) > 0).all()


def test_where_the_demonstrators_noise_leaves_residuals_noisy_slopes_move_the_gradient_too(body):
    """Visits near each other tell e there, but not how it changes."""
    model, residual_of = body
    place = np.radians((2.0, 1.0))
    left = residual_of(np.random.default_rng(7).normal(0, 20 * NOISE, (POINTS, 4)))
    with_left = lambda own: residual_of(own) + left
    gradients = lambda J, e: J @ e / POINTS
    made = np.array([gradients(*slopes(model(k), with_left, place)) for k in range(DRAWS)])
    said = [estimate_own_noise(model(k), with_left, place, NOISE, 20, k) for k in range(60)]
    squares = np.mean(
        [(one.grad_samples_images**2).mean(0) + (one.grad_samples_jacobian**2).mean(0) for one in said], axis=0
    )
    np.testing.assert_allclose(np.sqrt(squares), made.std(0), rtol=0.25)
