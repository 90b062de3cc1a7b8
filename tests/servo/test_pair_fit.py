"""The adjustment of both bodies: errors are as expected where noise hides which joints move a point."""

import sys
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from viewimit.geometry.kinematics.clusters import Observations
from viewimit.geometry.kinematics.own_body import exact_body
from viewimit.servo.estimator.pair_fit import MAX_SIGMAS, fit_same_body

sys.path.append(str(Path(__file__).parent.parent / "geometry" / "kinematics"))
from turning_body import TurningBody, seen  # noqa: E402

NOISE_PX, DEMONSTRATOR, MIDDLE = 0.5, np.array([1.2, -1.1]), np.array([0.1, 0.0, 1.6])
ON = np.array([0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2])
TRUE = np.arange(2) < ON[:, None]
NEAR_AXIS = 8  # a point that the second joint moves


def same_body(seed, radius_m):
    """The fit of a demonstrator like a body of which one point turns so near its axis that the probes hide it."""
    rng = np.random.default_rng([3, seed])
    body = TurningBody(rng, tuple(ON), 2)
    across = np.cross(body.axes[1], rng.normal(size=3))
    body.points[NEAR_AXIS] = body.through[1] + radius_m * across / np.linalg.norm(across)
    noise = lambda: NOISE_PX * rng.standard_normal((len(ON), 4))
    shown = np.vstack([body.probes(), rng.uniform(-0.7, 0.7, (9, 2))])
    own = np.array([body.images(one) + noise() for one in shown])
    visits = Observations(shown, own, np.ones(own.shape[:2], bool))
    found = exact_body(visits, NOISE_PX)
    if found is None or (found.kinematics.moved_by == TRUE).all():
        return None
    kinematics = found.kinematics
    turn = Rotation.from_rotvec([0.1, 0.4, 0.05]).as_matrix()
    demo = seen((body.places(DEMONSTRATOR) - MIDDLE) @ turn.T + MIDDLE + (-0.2, 0.1, 0.3)) + noise()
    return kinematics, fit_same_body(kinematics, visits, demo[None], NOISE_PX, DEMONSTRATOR[None] + 0.05)


def test_a_body_like_the_own_one_is_accepted_though_noise_hid_which_joints_move_a_point():
    """Its errors are normal, with the expected deviations: their squares add up to chi-square, here at 1 in 1,000."""
    fits = [found for seed in range(12) if (found := same_body(seed, 0.02)) is not None]
    assert len(fits) >= 8
    for found in (adjustment.kinematics for _, (adjustment, _) in fits):
        np.testing.assert_array_equal(found.moved_by[~found.unknown], TRUE[~found.unknown])
    estimates = [adjustment.estimate(fit) for _, (adjustment, fit) in fits]
    assert max(one.sigmas for one in estimates) < MAX_SIGMAS
    squares = sum(float((((one.theta - DEMONSTRATOR) / one.std_error) ** 2).sum()) for one in estimates)
    assert squares < chi2.ppf(0.999, 2 * len(fits))
