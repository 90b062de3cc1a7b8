"""Images foretold by kinematics: slopes are their differences, noise spreads as it is drawn, and points of which the
kinematics tell nothing are the Gaussian process's."""

import numpy as np
import pytest

from viewimit import Session, Settings
from viewimit.geometry.kinematics.adjustment import fit_kinematics
from viewimit.servo.observation import Visit
from viewimit.servo.trust_region.gaussian_process import GaussianProcessImages
from viewimit.servo.trust_region.image_models import MIN_CONFIRMING, ImageData, estimate_own_noise, observations_of

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


def test_slopes_are_differences_of_what_is_foretold(images):
    at, h = np.array([0.2, -0.4]), 1e-4
    for joint, slope in enumerate(images.jacobian(at)):
        on = h * np.eye(2)[joint]
        np.testing.assert_allclose(slope, (images.predict(at + on) - images.predict(at - on)) / (2 * h), atol=1e-3)


def test_images_near_the_visits_are_told_better_than_any_of_them_was_seen(images, visits):
    spread = images.prediction_std(np.array([visit.displacement for visit in visits]))
    assert (spread < NOISE_PX).all()
    assert (images.prediction_std(np.array([[1.0, -1.5]])) > spread.max(0)).any()


def test_draws_are_spread_as_the_covariance_has_it(images):
    """2,000 draws: variances to 5 √(2/2000), of coordinates of a point together."""
    at = np.array([0.3, -0.2])
    drawn, _ = images.posterior_samples(at, 2000, seed=1)
    spread = np.sqrt((drawn**2).mean((0, 2)))
    np.testing.assert_allclose(spread, images.prediction_std(at[None])[0], rtol=5 * np.sqrt(2 / 2000))


def test_drawn_slopes_are_differences_of_drawn_images(images):
    at, h = np.array([0.3, -0.2]), 1e-3
    slopes = images.posterior_samples(at, 5, seed=2)[1]
    for joint in range(2):
        on = h * np.eye(2)[joint]
        ahead, behind = (images.posterior_samples(at + way, 5, seed=2)[0] for way in (on, -on))
        np.testing.assert_allclose(slopes[:, joint], (ahead - behind) / (2 * h), atol=1e-2 * np.abs(slopes).max())


def test_points_that_kinematics_do_not_tell_are_the_processs(visits):
    hidden = [
        Visit.of(visit.displacement, visit.own, visit.seen & ~((np.arange(10) == 8) & (k == 2))[:, None])
        for k, visit in enumerate(visits)
    ]
    hidden = [*hidden[:3]]  # the second joint was not asked of it, and the first alone moves others too
    kinematics = fit_kinematics(observations_of(hidden), NOISE_PX)
    assert kinematics.unknown.tolist() == [k == 8 for k in range(10)]
    images, process = ImageData(hidden, NOISE_PX, kinematics).fit(1), GaussianProcessImages.fit(hidden, 1, NOISE_PX)
    at = np.array([0.1, -0.1])
    np.testing.assert_array_equal(images.predict(at)[8], process.predict(at)[8])
    assert images.prediction_std(at[None])[0, 8] == process.prediction_std(at[None])[0, 8]
    assert images.jacobian_std(at)[8] == process.jacobian_std(at)[8]
    assert np.isfinite(images.posterior_samples(at, 3, seed=0)[0][:, :8]).all()


def test_what_noise_adds_to_the_curvature_is_the_mean_square_of_drawn_slopes(images):
    """With images themselves as residuals; as many draws of another seed agree to 5 √(2/8)."""
    at = np.array([0.3, -0.2])
    found = estimate_own_noise(images, lambda own: own, at, NOISE_PX, 20, seed=3).hessian_bias
    slopes = images.posterior_samples(at, 500, seed=4)[1].reshape(500, 2, -1)
    expected = np.einsum("dik,djk->ij", slopes, slopes) / (500 * 10)
    np.testing.assert_allclose(np.diag(found), np.diag(expected), rtol=5 * np.sqrt(2 / 8))


@pytest.mark.parametrize("count", [MIN_CONFIRMING - 1, MIN_CONFIRMING])
def test_points_count_as_seen_only_where_enough_others_were(visits, count):
    """A posture at which nearly nothing was seen is no evidence of what kinematics foretell there."""
    last = Visit.of(visits[3].displacement, visits[3].own, (np.arange(10) < count)[:, None] & visits[3].seen)
    shown = [*visits[:3], last]
    images = ImageData(shown, NOISE_PX, fit_kinematics(observations_of(shown), NOISE_PX)).fit()
    expected = np.arange(10) < (10 if count == MIN_CONFIRMING else count)
    np.testing.assert_array_equal(images.seen[3], expected)
    assert images.seen[:3].all()
