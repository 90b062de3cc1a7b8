"""The final adjustment of own and demonstrator's images: what noise hides of the own body widens the expected error."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from viewimit.geometry.kinematics.adjustment import fit_kinematics
from viewimit.servo.observation import Visit
from viewimit.servo.trust_region.final_adjustment import SameBody, fit_same_body
from viewimit.servo.trust_region.image_models import observations_of
from viewimit.servo.trust_region.options import DEFAULTS

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
    visits = tuple(Visit.of(one, body.images(one) + noise(), np.ones((len(ON), 2), bool)) for one in shown)
    kinematics = fit_kinematics(observations_of(visits), NOISE_PX)
    if kinematics is None:
        return None
    turn = Rotation.from_rotvec([0.1, 0.4, 0.05]).as_matrix()
    demo = seen((body.places(DEMONSTRATOR) - MIDDLE) @ turn.T + MIDDLE + (-0.2, 0.1, 0.3)) + noise()
    return (
        kinematics,
        fit_same_body(kinematics, visits, demo[None], NOISE_PX, DEMONSTRATOR[None] + 0.05, DEFAULTS),
        demo,
    )


def test_a_body_like_the_own_one_is_accepted_though_noise_hid_which_joints_move_a_point():
    """Its errors are normal, with the expected deviations: their squares add up to chi-square, here at 1 in 1,000."""
    fits = [found for seed in range(12) if (found := same_body(seed, 0.02)) is not None]
    assert all((kinematics.moved_by != TRUE).any() for kinematics, _, _ in fits)  # by the probes
    for found in (fit.adjustment.kinematics for _, fit, _ in fits):
        np.testing.assert_array_equal(found.moved_by[~found.unknown], TRUE[~found.unknown])
    estimates = [fit.estimate(demo) for _, fit, demo in fits]
    assert max(one.sigmas for one in estimates) < DEFAULTS.max_body_sigmas
    squares = sum(float((((one.theta - DEMONSTRATOR) / one.std_error) ** 2).sum()) for one in estimates)
    assert squares < chi2.ppf(0.999, 2 * len(fits))


def test_what_the_images_leave_open_widens_the_expected_error():
    """By the second moment of all choices about the best one; the oracle draws from them."""
    _, same, demo = same_body(0, 0.02)
    adjustment, fit = same.adjustment, same.fit
    moved, rng = fit.pair.parameters.copy(), np.random.default_rng(0)
    moved[-2:] += (0.1, -0.3)
    half_as_likely = fit.cost + 2 * np.log(2) * adjustment.variance
    other = replace(fit, pair=replace(fit.pair, parameters=moved), cost=half_as_likely)
    both = [adjustment.estimate(one, demo) for one in (fit, other)]
    draws = [one.theta + one.std_error * rng.standard_normal((n, 2)) for one, n in zip(both, (200_000, 100_000))]
    expected = np.sqrt(((np.concatenate(draws) - both[0].theta) ** 2).mean(0))
    found = SameBody(((adjustment, fit), (adjustment, other))).estimate(demo)
    np.testing.assert_allclose(found.std_error, expected, rtol=0.01)
    np.testing.assert_array_equal(found.theta, both[0].theta)
