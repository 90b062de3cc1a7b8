"""Kinematics of maximum likelihood: no local minimum, and each point moved by the joints that its images show."""

from dataclasses import replace

import numpy as np
import pytest
from turning_body import TurningBody

from viewimit.geometry.kinematics.adjustment import BundleAdjustment
from viewimit.geometry.kinematics.bundle import levenberg_marquardt
from viewimit.geometry.kinematics.maximum_likelihood import MAX_RAISED, likely_kinematics
from viewimit.geometry.kinematics.model import N_FRAME, PLANE
from viewimit.geometry.kinematics.own_body import exact_body

NOISE_PX = 0.5
ON = np.array([0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2])
TRUE = np.arange(2) < ON[:, None]
NEAR_AXIS = 8  # a point that the second joint moves


def seen(seed, radius_m):
    """Kinematics by the probes' joints, and the problem of ten visits. radius_m: of `NEAR_AXIS` about its axis."""
    rng = np.random.default_rng(seed)
    body = TurningBody(rng, tuple(ON), 2)
    across = np.cross(body.axes[1], rng.normal(size=3))
    body.points[NEAR_AXIS] = body.through[1] + radius_m * across / np.linalg.norm(across)
    shown = np.vstack([body.probes(), rng.uniform(-0.7, 0.7, (9, 2))])
    observations = body.observations(shown, noise=NOISE_PX * rng.standard_normal((len(shown), len(ON), 4)))
    kinematics = exact_body(observations, NOISE_PX).kinematics
    return kinematics, BundleAdjustment.of(kinematics, observations, NOISE_PX).restricted_to_known(kinematics)


def least(kinematics, problem, moved_by):
    """The least objective with these joints, in variances of the noise, from many steps."""
    prior = problem.prior_weights(len(kinematics.parameters))
    found = levenberg_marquardt(replace(kinematics, moved_by=moved_by), problem.residuals, prior, 1e-9, 300)
    return float((problem.residuals(found) ** 2).sum() + prior @ found.parameters**2) / NOISE_PX**2


def flipped(moved_by, point, joint):
    found = moved_by.copy()
    found[point, joint] ^= True
    return found


@pytest.mark.parametrize("seed", range(3))
def test_a_point_near_an_axis_is_moved_by_the_joints_that_all_its_images_show(seed):
    kinematics, problem = seen(seed, 0.02)
    np.testing.assert_array_equal(np.flatnonzero((kinematics.moved_by != TRUE).any(1)), [NEAR_AXIS])  # by the probes
    best = likely_kinematics(kinematics, problem)[0]
    np.testing.assert_array_equal(best.kinematics.moved_by, TRUE)
    assert best.objective / NOISE_PX**2 == pytest.approx(least(kinematics, problem, TRUE), abs=0.05)


@pytest.mark.parametrize("seed, radius_m", [(0, 0.01), (1, 0.005), pytest.param(0, 0.02, marks=pytest.mark.slow)])
def test_all_choices_of_joints_are_returned_that_the_images_leave_open(seed, radius_m):
    """The oracle adjusts every change of one joint and one point."""
    kinematics, problem = seen(seed, radius_m)
    found = likely_kinematics(kinematics, problem)
    best = found[0].kinematics
    every = [flipped(best.moved_by, *at) for at in np.ndindex(best.moved_by.shape)]
    raised = [least(best, problem, one) - found[0].objective / NOISE_PX**2 for one in every]
    open_to = lambda most: {
        best.moved_by.tobytes(),
        *(one.tobytes() for one, more in zip(every, raised) if more < most),
    }
    chosen = {one.kinematics.moved_by.tobytes() for one in found}
    assert open_to(0.7 * MAX_RAISED) <= chosen <= open_to(MAX_RAISED)  # they are predicted to first order only
    objectives = [one.objective for one in found]
    assert objectives == sorted(objectives)


@pytest.mark.parametrize("seed", range(3))
def test_a_local_minimum_in_which_joints_turn_the_other_way_is_left(seed):
    kinematics, problem = seen(seed, 0.1)
    parameters = kinematics.parameters.copy()
    parameters[N_FRAME:] *= -1
    stuck, expected = replace(kinematics, parameters=parameters), least(kinematics, problem, TRUE)
    assert least(stuck, problem, TRUE) > expected + 100
    assert likely_kinematics(stuck, problem)[0].objective / NOISE_PX**2 == pytest.approx(expected, abs=0.05)


def test_a_plane_at_infinity_among_the_points_is_no_local_minimum():
    """Points behind it would be behind the cameras: depths have both signs."""
    kinematics, problem = seen(0, 0.1)
    parameters = np.zeros_like(kinematics.parameters)
    parameters[:N_FRAME] = kinematics.parameters[:N_FRAME] + (0, -3, 0, 0.7, 2, 0, 1, -3.5)
    crossed = replace(kinematics, parameters=parameters)
    depths = 1 + problem.coordinates @ parameters[PLANE]
    assert depths.min() < 0 < depths.max()
    assert least(crossed, problem, TRUE) == pytest.approx(least(kinematics, problem, TRUE), abs=0.05)
