"""Images predicted by kinematics, and the effect of the own images' noise on derivatives of E."""

from dataclasses import replace

import numpy as np
import pytest

from viewimit import Session, Settings
from viewimit.geometry.kinematics.adjustment import fit_kinematics
from viewimit.geometry.kinematics.clusters import Observations
from viewimit.servo.observation import Visit
from viewimit.servo.trust_region.final_adjustment import prediction_sigmas
from viewimit.servo.trust_region.gaussian_process import GaussianProcessImages
from viewimit.servo.trust_region.image_models import ImageData, estimate_own_noise, observations_of
from viewimit.servo.trust_region.options import TrustRegionOptions

NOISE_PX = 0.05


@pytest.fixture(scope="module")
def visits():
    """Of the default learner, with noise: a probe of each joint, and three postures more."""
    session = Session(Settings.paper())
    rng, begin = np.random.default_rng(0), session.snapshot.theta
    told = np.vstack([np.zeros(2), [0.26, 0], [0.26, -0.26], rng.uniform(-0.3, 0.3, (3, 2))])
    found = []
    for displacement in told:
        views = session.observer.four_views(session.settings, begin + displacement, session.snapshot.theta_demo, 0)
        noise = NOISE_PX * rng.standard_normal(views.own.shape)
        found.append(Visit.of(displacement, views.own + noise, views.visible[:, 2:]))
    return found


@pytest.fixture(scope="module")
def images(visits):
    return ImageData(visits, NOISE_PX, fit_kinematics(observations_of(visits), NOISE_PX)).fit(3)


def test_the_jacobian_is_the_difference_of_predicted_images(images):
    at, h = np.array([0.2, -0.4]), 1e-4
    for joint, slope in enumerate(images.jacobian(at)):
        on = h * np.eye(2)[joint]
        np.testing.assert_allclose(slope, (images.predict(at + on) - images.predict(at - on)) / (2 * h), atol=1e-3)


def test_samples_vary_as_the_covariance_says(images):
    """2,000 draws: variances to 5 √(2/2000), of coordinates of a point together."""
    at = np.array([0.3, -0.2])
    drawn, _ = images.posterior_samples(at, 2000, seed=1)
    spread = np.sqrt((drawn**2).mean((0, 2)))
    np.testing.assert_allclose(spread, images.prediction_std(at[None])[0], rtol=5 * np.sqrt(2 / 2000))


def test_the_hessian_bias_is_the_mean_square_of_sampled_jacobians(images):
    """With images themselves as residuals; as many draws of another seed agree to 5 √(2/8)."""
    at = np.array([0.3, -0.2])
    found = estimate_own_noise(images, lambda own: own, at, NOISE_PX, 20, seed=3).hessian_bias
    slopes = images.posterior_samples(at, 500, seed=4)[1].reshape(500, 2, -1)
    expected = np.einsum("dik,djk->ij", slopes, slopes) / (500 * 10)
    np.testing.assert_allclose(np.diag(found), np.diag(expected), rtol=5 * np.sqrt(2 / 8))


# Noise of the own images, against drawing it many times

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


def test_the_hessian_bias_is_the_curvature_that_noisy_jacobians_add(body):
    model, residual_of = body
    place = np.radians((2.0, 1.0))
    drawn = np.array([slopes(model(k), residual_of, place)[0] for k in range(DRAWS)])
    mean = drawn.mean(0)
    added = (drawn @ drawn.swapaxes(1, 2)).mean(0) / POINTS - mean @ mean.T / POINTS
    said = estimate_own_noise(model(0), residual_of, place, NOISE, 20, 1).hessian_bias
    share = np.abs(np.linalg.eigvalsh(np.linalg.solve(added, said)) - 1).max()
    assert share < TOLERANCE + 0.25  # DRAWS of own_noise estimate what is left of 32 - 12 residuals


def test_gradient_samples_are_as_large_as_those_that_noise_makes(body):
    model, residual_of = body
    place = np.radians((2.0, 1.0))
    slopes_drawn, e_drawn = zip(*(slopes(model(k), residual_of, place) for k in range(DRAWS)))
    made = np.array(e_drawn) @ np.mean(slopes_drawn, axis=0).T / POINTS
    said = np.concatenate(
        [estimate_own_noise(model(k), residual_of, place, NOISE, 20, k).grad_samples_images for k in range(60)]
    )
    np.testing.assert_allclose(np.sqrt((said**2).mean(0)), made.std(0), rtol=0.25)


# Whether kinematics have predicted a visit

TRIALS = 60


@pytest.fixture(scope="module")
def probed():
    """Of the default learner without noise: a probe of each joint, and a posture far from all."""
    session = Session(Settings.paper())
    told = np.radians([(0, 0), (15, 0), (15, -15), (-15, 10)])
    views = [
        session.observer.four_views(session.settings, session.snapshot.theta + one, session.snapshot.theta_demo, 0)
        for one in told
    ]
    return Observations(told, np.stack([one.own for one in views]), np.ones((len(told), len(views[0].own)), bool))


def contradictions(probed, slipped_px=0.0):
    """In standard deviations, of many draws of the noise; slipped_px: how far a point has moved at the last visit.

    Draws that leave open after the probes which joints move a point, one of them, find no kinematics to contradict.
    """
    rng, found = np.random.default_rng(4), []
    for _ in range(TRIALS):
        images = probed.images + NOISE_PX * rng.standard_normal(probed.images.shape)
        images[-1, 0] += slipped_px
        noisy = replace(probed, images=images)
        before = fit_kinematics(noisy.select_visits(np.arange(4) < 3), NOISE_PX)
        if before is not None:
            after = fit_kinematics(noisy, NOISE_PX, previous=before)
            found.append(np.inf if after is None else prediction_sigmas(before, after, noisy, NOISE_PX))
    assert len(found) >= 0.9 * TRIALS
    return np.array(found)


def test_a_visit_contradicts_right_kinematics_as_much_as_noise_does(probed):
    """Its mean is 0 and 2.3 % are beyond 2, as of a normal distribution; within four standard deviations."""
    found, beyond = contradictions(probed), 0.023
    assert abs(found.mean()) < 4 / np.sqrt(len(found))
    assert (found > 2).mean() < beyond + 4 * np.sqrt(beyond / len(found))


def test_a_point_that_has_slipped_contradicts_kinematics(probed):
    assert (contradictions(probed, 10 * NOISE_PX) > TrustRegionOptions().max_body_sigmas).all()
