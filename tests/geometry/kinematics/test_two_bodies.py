"""One adjustment of two bodies of the same build that one head sees."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation
from turning_body import TurningBody, seen

from viewimit.geometry.kinematics.own_body import exact_body
from viewimit.geometry.kinematics.two_bodies import (
    BodyPair,
    PairAdjustment,
    fit_homography,
    fit_similarity,
    rotations,
    with_shared_metric,
)

NOISE_PX = 0.05
TRUTH = np.array([0.3, -0.4])
MIDDLE = np.array([0.1, 0.0, 1.6])  # of `TurningBody`, m
ON = (0, 0, 0, 0, 1, 1, 1, 1, 1, 2, 2, 2, 2, 2)


def body_of(seed, parallel=False):
    body = TurningBody(np.random.default_rng(seed), ON, 2)
    if parallel:
        body.axes[1] = body.axes[0]
    return body


def visited(body, rng):
    """Eight postures and what is seen there."""
    displacements = np.vstack([body.probes(0.4), rng.uniform(-0.7, 0.7, (5, 2))])
    noise = NOISE_PX * rng.standard_normal((len(displacements), len(ON), 4))
    return body.observations(displacements, noise=noise)


def demonstrator(body, rng, theta=TRUTH, size=1.1, yaw=0.4):
    """Images of the same body, of another size, elsewhere: (1, N, 4) px."""
    turn = Rotation.from_rotvec(yaw * np.array([0.2, 1.0, 0.1])).as_matrix()
    places = size * (body.places(theta) - MIDDLE) @ turn.T + MIDDLE + (-0.2, 0.1, 0.3)
    return (seen(places) + NOISE_PX * rng.standard_normal((len(ON), 4)))[None]


def adjusted(body, rng, demo=None):
    observations = visited(body, rng)
    kinematics = exact_body(observations, NOISE_PX).kinematics
    problem = PairAdjustment.of(kinematics, observations, demonstrator(body, rng) if demo is None else demo, NOISE_PX)
    return problem, problem.solve(problem.starts(kinematics, TRUTH[None] + 0.1)[0]), kinematics


@pytest.mark.parametrize("seed", range(5))
def test_the_adjustment_is_the_least_squares_solution_that_scipy_finds(seed):
    problem, pair, _ = adjusted(body_of(seed), np.random.default_rng(seed))
    P, prior = len(pair.parameters), np.sqrt(problem.prior_weights(pair))

    def residuals(x):
        other = replace(pair, parameters=x[:P], points=x[P:].reshape(-1, 3))
        return np.concatenate([problem.residuals(other).ravel(), prior * x[:P]]) / NOISE_PX

    x = np.concatenate([pair.parameters, pair.points.ravel()])
    oracle = least_squares(residuals, x, x_scale="jac", xtol=1e-12, ftol=1e-12, gtol=1e-12)
    cost = float((residuals(x) ** 2).sum())
    assert 2 * oracle.cost <= cost * (1 + 1e-9) and cost - 2 * oracle.cost < 0.05
    covariance = np.linalg.inv(oracle.jac.T @ oracle.jac)
    begin = P - 2
    expected = np.sqrt(np.diag(covariance)[begin:P])
    np.testing.assert_allclose(NOISE_PX * problem.angle_std(pair)[0], expected, rtol=0.02)


def test_errors_and_costs_have_the_distributions_that_are_claimed():
    squares, raised, freedom = [], [], None
    for seed in range(60):
        rng = np.random.default_rng([1, seed])
        problem, pair, kinematics = adjusted(body_of(seed % 6), rng)
        squares += list(((pair.angles[0] - TRUTH) / (NOISE_PX * problem.angle_std(pair)[0])) ** 2)
        own = (problem.own.residuals(kinematics) ** 2).sum()
        raised.append(((problem.residuals(pair) ** 2).sum() - own) / NOISE_PX**2)
        freedom = problem.degrees_of_freedom
    assert freedom == 3 * len(ON) - 7 - 2
    # Means of χ²: within four of their standard deviations √(2 f / n)
    assert abs(np.mean(raised) - freedom) < 4 * np.sqrt(2 * freedom / len(raised))
    assert abs(np.mean(squares) - 1) < 4 * np.sqrt(2 / len(raised))


def test_postures_of_one_demonstrator_share_its_place():
    """Together they have a smaller deviation each than alone, and errors of χ² with as many degrees of freedom."""
    squares, postures = [], np.array([TRUTH, (-0.5, 0.2), (0.1, 0.6)])
    for seed in range(30):
        rng, body = np.random.default_rng([2, seed]), body_of(seed % 6)
        observations = visited(body, rng)
        kinematics = exact_body(observations, NOISE_PX).kinematics
        demos = np.concatenate([demonstrator(body, rng, theta) for theta in postures])
        problem, first = (PairAdjustment.of(kinematics, observations, demo, NOISE_PX) for demo in (demos, demos[:1]))
        pair = problem.solve(problem.starts(kinematics, postures + 0.1)[0])
        alone = first.solve(first.starts(kinematics, postures[:1] + 0.1)[0])
        deviations = problem.angle_std(pair)
        assert (deviations[0] < first.angle_std(alone)[0]).all()
        squares += list(((pair.angles - postures) / (NOISE_PX * deviations)).ravel() ** 2)
        assert problem.degrees_of_freedom == 3 * 3 * len(ON) - 7 - 3 * 2
    assert abs(np.mean(squares) - 1) < 4 * np.sqrt(2 / 30)  # the postures of one run are not independent


@pytest.mark.parametrize("seed", range(4))
def test_another_body_raises_the_cost_far_above_noise(seed):
    rng, body = np.random.default_rng(seed), body_of(seed)
    other = body_of(seed)
    other.points[np.array(ON) == 2] += (0.02, -0.01, 0.02)
    problem, pair, kinematics = adjusted(body, rng, demonstrator(other, rng))
    own = (problem.own.residuals(kinematics) ** 2).sum()
    assert ((problem.residuals(pair) ** 2).sum() - own) / NOISE_PX**2 > 2 * problem.degrees_of_freedom


@pytest.mark.parametrize("seed", range(4))
def test_the_map_between_both_bodies_tells_the_scale_along_parallel_axes(seed):
    """With parallel axes the own motions leave that scale open; a demonstrator that is turned shows it."""
    rng, body = np.random.default_rng(seed), body_of(seed, parallel=True)
    observations = visited(body, rng)
    kinematics = exact_body(observations, NOISE_PX).kinematics
    problem = PairAdjustment.of(kinematics, observations, demonstrator(body, rng), NOISE_PX)
    own, demo = kinematics.coordinates(TRUTH[None])[0], kinematics.frame.coordinates(problem.images[0])
    shared = with_shared_metric(kinematics, fit_homography(own, demo))
    np.testing.assert_allclose(
        shared.coordinates(observations.displacement), kinematics.coordinates(observations.displacement), atol=0.02
    )
    cost = lambda one: min(
        float((problem.residuals(start) ** 2).sum())
        for start in [BodyPair.at_postures(one, placed(one, own, demo), TRUTH[None])]
    )
    assert cost(shared) < 0.1 * cost(kinematics)


def placed(kinematics, own, demo):
    A = kinematics.metric_upgrade
    metric = [np.c_[points, np.ones(len(points))] @ A.T for points in (own, demo)]
    return fit_similarity(*(points[:, :3] / points[:, 3:] for points in metric))


def test_rotations_and_similarities_are_those_of_scipy():
    rng = np.random.default_rng(0)
    vectors = rng.normal(size=(5, 3)) * [[1e-9], [0.1], [1.0], [3.0], [0.0]]
    np.testing.assert_allclose(rotations(vectors), Rotation.from_rotvec(vectors).as_matrix(), atol=1e-12)
    points, turn = rng.normal(size=(9, 3)), Rotation.random(random_state=1).as_matrix()
    S = fit_similarity(points, 1.7 * points @ turn.T + (1, 2, 3))
    np.testing.assert_allclose(S, [*np.c_[1.7 * turn, (1, 2, 3)], (0, 0, 0, 1)], atol=1e-12)
    mirrored = fit_similarity(points, 1.7 * points @ turn.T * (1, -1, 1), mirror=True)
    assert np.linalg.det(mirrored[:3, :3]) == pytest.approx(-(1.7**3))
