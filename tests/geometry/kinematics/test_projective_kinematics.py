"""Two probes of 15° predict the images of a rigid-link body at every posture, and of no other body."""

import numpy as np
import pytest
from turning_body import TurningBody

from viewimit import Session, Settings
from viewimit.geometry.fundamental import fit_fundamental
from viewimit.geometry.kinematics.adjustment import BundleAdjustment, KinematicsCovariance
from viewimit.geometry.kinematics.clusters import Observations
from viewimit.geometry.kinematics.model import exponentials, generator_powers, twist_matrices
from viewimit.geometry.kinematics.own_body import exact_body
from viewimit.geometry.rectification import rectify

ON = [0, 0, 1, 1, 1, 2, 2, 2, 2]


def furthest(found, body, displacements, points=slice(None)):
    """px"""
    return max(np.abs(found.predict(d) - body.images(d))[points].max() for d in displacements)


@pytest.mark.parametrize("seed", range(5))
def test_one_probe_for_each_joint_predicts_images_anywhere(seed):
    rng = np.random.default_rng(seed)
    body = TurningBody(rng, ON, 2)
    found = exact_body(body.observations(body.probes()), 0.0).kinematics
    assert furthest(found, body, rng.uniform(-1.2, 1.2, (20, 2))) < 1e-5


def test_joints_may_slide_or_be_many():
    rng = np.random.default_rng(3)
    sliding = TurningBody(rng, ON, 2, sliding=(1,))
    found = exact_body(sliding.observations(sliding.probes()), 0.0).kinematics
    assert furthest(found, sliding, rng.uniform(-1, 1, (20, 2))) < 1e-4
    five = TurningBody(rng, [0, 0, *np.repeat([1, 2, 3, 4, 5], 5)], 5)
    found = exact_body(five.observations(five.probes()), 0.0).kinematics
    assert furthest(found, five, rng.uniform(-0.5, 0.5, (20, 5))) < 1e-3


def test_a_body_whose_points_do_not_turn_together_has_no_kinematics():
    body = TurningBody(np.random.default_rng(0), ON, 2, slip=0.05)
    more = np.vstack([body.probes(), [0.6, -0.5], [-0.4, 0.8]])
    assert exact_body(body.observations(more), 0.0) is None


@pytest.mark.parametrize("count", range(4))
def test_fewer_than_four_points_give_no_kinematics(count):
    """All other points are hidden at all visits."""
    body = TurningBody(np.random.default_rng(0), ON, 2)
    for begins in (0, 5):
        visible = np.tile((np.arange(len(ON)) >= begins) & (np.arange(len(ON)) < begins + count), (3, 1))
        for noise_px in (0.0, 0.2):
            assert exact_body(body.observations(body.probes(), visible), noise_px) is None


def test_a_point_is_predicted_after_a_single_image_of_it():
    rng = np.random.default_rng(4)
    body = TurningBody(rng, ON, 2)
    visible = np.ones((4, len(ON)), bool)
    visible[1:3, 7] = (
        False  # seen at the start and at the end, far from each other: no image shows which joints move it
    )
    seen = body.observations(np.vstack([body.probes(), [0.7, -0.6]]), visible)
    found = exact_body(seen, 0.0).kinematics
    assert not found.unknown.any()
    assert furthest(found, body, rng.uniform(-1, 1, (20, 2))) < 1e-4
    visible[3, 7] = False  # seen once
    found = exact_body(body.observations(np.vstack([body.probes(), [0.7, -0.6]]), visible), 0.0).kinematics
    assert found.unknown.tolist() == [k == 7 for k in range(len(ON))]
    assert np.isnan(found.predict(np.zeros(2))[7]).all()


def test_predictions_vary_as_the_covariance_says():
    """Fitted 60 times to images with noise; each coordinate's variance has 59 degrees of freedom, and the mean of their
    ratios over 36 coordinates, hardly independent, is within 1 by 5 √(2/59)."""
    rng, noise_px = np.random.default_rng(6), 0.02
    body = TurningBody(rng, ON, 2)
    visits = np.vstack([body.probes(), rng.uniform(-0.7, 0.7, (4, 2))])
    own, asked, found = exact_body(body.observations(visits), 0.0), np.array([0.4, -0.3]), []
    for _ in range(60):
        noise = noise_px * rng.standard_normal((len(visits), len(ON), 4))
        found.append(exact_body(body.observations(visits, noise=noise), noise_px, previous=own))
    found, before = [one.kinematics.predict(asked) for one in found], own.kinematics
    exact = body.observations(visits)
    parameters, shape = KinematicsCovariance.estimate(before, exact).columns(1e-4)
    columns = [
        type(before)(before.parameters + p, before.points + s, before.moved_by, before.reference, before.frame).predict(
            asked
        )
        for p, s in zip(parameters, shape)
    ]
    variance = ((np.array(columns) - before.predict(asked)) ** 2).sum(0) * (noise_px / 1e-4) ** 2
    ratio = np.var(found, axis=0, ddof=1) / variance
    assert np.mean(ratio[:, [0, 2]]) == pytest.approx(1, abs=5 * np.sqrt(2 / 59))


def test_rectified_images_have_the_noise_of_the_images_as_seen_even_where_one_camera_is_ahead_of_the_other():
    def ahead(places):
        x, y, z = places.T
        left, right = (
            (300 * x / z + 150, 300 * y / z + 110),
            (300 * (x - 0.3) / (z - 0.3) + 150, 300 * y / (z - 0.3) + 110),
        )
        return np.stack([*left, *right], 1)

    for seed in range(5):
        rng, noise_px = np.random.default_rng(seed), 0.05
        body = TurningBody(rng, np.repeat([0, 1, 2], 8), 2)
        visits = np.vstack([body.probes(0.4), rng.uniform(-0.5, 0.5, (9, 2))])
        clean = np.array([ahead(body.places(one)) for one in visits])
        left, right = np.split(clean.reshape(-1, 4), 2, 1)
        head = rectify(fit_fundamental(left, right), left, right)
        images = clean + noise_px * rng.standard_normal(clean.shape)
        shown = Observations(visits, images, np.ones(images.shape[:2], bool))
        found = exact_body(shown, noise_px, head).kinematics
        problem = BundleAdjustment.of(found, shown, noise_px)
        chi_squared, freedom = (problem.residuals(found) ** 2).sum() / noise_px**2, problem.degrees_of_freedom
        assert abs(chi_squared - freedom) < 4 * np.sqrt(2 * freedom)


@pytest.mark.parametrize("scene", ["panda", "panda-toed", "panda-verged", "iiwa"])
def test_simulated_robots_are_predicted_over_their_whole_range(scene):
    session = Session(Settings.paper(scene=scene))
    lower, upper = session.embodiment.lower, session.embodiment.upper
    look = lambda theta: session.observer.four_views(session.settings, theta, session.snapshot.theta_demo, 0).own
    begin = (lower + upper) / 2
    probes = begin + np.vstack([np.zeros(2), [0.26, 0], [0.26, -0.26]])
    own = np.array([look(theta) for theta in probes])
    seen = Observations(probes, own, np.ones(own.shape[:2], bool))
    found = exact_body(seen, 0.0, session.snapshot.rectification).kinematics
    asked = np.random.default_rng(0).uniform(lower, upper, (20, 2))
    off = [np.abs(found.predict(theta) - look(theta)).max() for theta in asked]
    assert max(off) < 1e-3


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
def test_an_exponential_equals_its_power_series_in_any_frame(twist):
    rng = np.random.default_rng(1)
    A = np.eye(4) + 0.3 * rng.normal(size=(4, 4))
    S = twist_matrices(np.array([twist]))
    G, rate = np.linalg.inv(A) @ S @ A, np.linalg.norm(np.array([twist])[:, :3], axis=1)
    angles = np.array([[0.0], [1e-7], [0.7], [-2.5]])
    found = exponentials(generator_powers(G, rate), rate, angles)
    for angle, motion in zip(angles[:, 0], found[:, 0]):
        np.testing.assert_allclose(motion, series(angle * G[0]), atol=1e-7)


def test_a_batch_of_bodies_equals_a_loop():
    rng = np.random.default_rng(2)
    G = twist_matrices(rng.normal(size=(3, 2, 6)))
    rate = np.linalg.norm(G[..., [2, 0, 1], [1, 2, 0]], axis=-1)
    angles = rng.uniform(-2, 2, (5, 2))
    together = exponentials(generator_powers(G, rate), rate, angles)
    assert together.shape == (3, 5, 2, 4, 4)
    for k in range(3):
        np.testing.assert_allclose(
            together[k], exponentials(generator_powers(G[k], rate[k]), rate[k], angles), atol=1e-12
        )
