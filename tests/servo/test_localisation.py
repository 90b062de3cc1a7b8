"""Arms that are not where they were sent are localised from images; calibrations that no longer fit are found."""

import numpy as np
import pytest

from viewimit.loop.self_calibration import spread_postures
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.servo import SERVOS
from viewimit.servo.observation import Visit
from viewimit.servo.trust_region.localisation import MAX_SHIFT_PX, contradicts_command, is_consistent, localise
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World

JOINTS, POINTS = 2, 8
J = np.random.default_rng(3).normal(0, 200, (POINTS, 4, JOINTS))  # px/rad
Y = np.random.default_rng(4).uniform(0, 240, (POINTS, 4))
EVERY = np.ones((POINTS, 2), bool)


def visit(sent_deg, stands_deg=None, jacobian=J, noise=0.0):
    """Sent there, it stands elsewhere: images are linear."""
    sent, stands = np.radians(sent_deg), np.radians(sent_deg if stands_deg is None else stands_deg)
    return Visit.of(sent, Y + jacobian @ stands + noise, EVERY)


PROBED = (visit((0, 0)), visit((15, 0)), visit((15, 15)))


def test_an_image_that_should_have_changed_contradicts_the_command():
    assert contradicts_command(PROBED, visit((15.4, 15.3), (15, 15)), 0.0)
    assert contradicts_command(PROBED, visit((0.4, 0.1), (0, 0)), 0.0)
    assert not contradicts_command(PROBED, visit((15.4, 15.3)), 0.0)
    assert not contradicts_command(PROBED[:2], visit((15.4, 0), (15, 0)), 0.0)  # nothing can be predicted yet


def test_changes_within_noise_contradict_nothing():
    noise = np.random.default_rng(5).normal(0, 0.5, (POINTS, 4))
    assert not contradicts_command(PROBED, visit((15.1, 15.1), (15, 15), noise=noise), 0.5)
    assert contradicts_command(PROBED, visit((16, 16), (15, 15), noise=noise), 0.5)


def test_a_repeated_image_is_the_same_posture_and_another_one_is_localised():
    here, been = localise(PROBED, visit((15.4, 14.2), (15, 15)), 0.0)
    assert been and np.array_equal(here.displacement, PROBED[2].displacement)
    here, been = localise(PROBED, visit((14.5, 13.5), (14, 13)), 0.0)
    assert not been
    np.testing.assert_allclose(np.degrees(here.displacement), (14, 13), atol=0.05)


def run(k, **disturbed):
    """From anywhere to anywhere."""
    demo, start = np.random.default_rng([7, k]).uniform((0, -180), (90, 0), (2, 2)).tolist()
    session = Session(Settings(demonstrator_deg=demo, start_deg=start, seed=k, **disturbed))
    session.run(300)
    return session.snapshot


@pytest.mark.parametrize(
    "runs, disturbed",
    [
        (3, {"encoder_step_deg": 1.0}),
        pytest.param(8, {"encoder_step_deg": 0.5}, marks=pytest.mark.slow),
        pytest.param(8, {"encoder_step_deg": 1.0, "noise_px": 0.2}, marks=pytest.mark.slow),
    ],
)
def test_an_arm_that_moves_in_steps_comes_as_near_as_they_allow_and_knows_its_error(runs, disturbed):
    """Noise leaves it without evidence: where the arm is was learned less exactly than by noise at rest."""
    ends, noisy = [run(k, **disturbed) for k in range(runs)], "noise_px" in disturbed
    claims = [end for end in ends if end.status == "converged"]
    assert len(claims) >= (runs / 2 if noisy else runs)
    off = np.array([np.abs(end.theta - end.theta_demo).max() for end in claims])
    expected = np.array([end.expected_error for end in claims])
    largest = np.sqrt(np.mean(off**2)) if noisy else off.max()
    assert np.degrees(largest) < disturbed["encoder_step_deg"]
    assert (off <= 3 * expected).all() and (off <= 2 * expected).mean() > 0.8
    assert any(end.servo_state.mismatch is not None for end in ends)


def test_an_arm_that_obeys_is_never_localised_by_its_images():
    assert all(run(k, noise_px=noise).servo_state.mismatch is None for k in range(2) for noise in (0.0, 0.5))


def test_an_arm_that_falls_short_of_its_limit_is_reported():
    """It moves by 20 % less than commanded, so it cannot be sent as far as it could go."""
    end = run(3, gain_error=-0.2)
    assert end.status == "no-progress" and end.commanded[0] == np.radians(90) > end.theta[0]
    assert "A joint was sent to its limit" in SERVOS["trust-region"].describe_status(end.servo_state, end.status)


# The innovation test of a calibration

WORLD = World(load_scene("panda"))
LOW, HIGH = WORLD.scene.lower, WORLD.scene.upper


def visits_of(postures, noise_px=0.0, missing=0.0, seed=0, moved=0.0):
    """moved: (N, 4) px, of the images."""
    rng, found = np.random.default_rng(seed), []
    for theta in postures:
        own, _ = WORLD.own_images(theta)
        seen = rng.random((len(own), 2)) >= missing
        found.append(Visit.of(theta, own + moved + noise_px * rng.normal(size=own.shape), seen))
    return tuple(found)


def somewhere(count, seed=5):
    return np.random.default_rng(seed).uniform(LOW, HIGH, (count, 2))


@pytest.mark.parametrize("count, noise_px, missing", [(12, 0.0, 0.0), (12, 0.25, 0.1), (20, 0.25, 0.0)])
def test_the_same_body_is_consistent(count, noise_px, missing):
    calibration = visits_of(spread_postures(LOW, HIGH, count, np.random.default_rng(0)), noise_px, missing)
    now = [visits_of([theta], noise_px, missing, seed=k) for k, theta in enumerate(somewhere(40))]
    held = [is_consistent(calibration, here, noise_px) for here in now]
    assert sum(held) >= 38


@pytest.mark.parametrize("noise_px", [0.0, 0.1])
def test_one_point_that_has_moved_is_inconsistent(noise_px):
    """By 4 px, a point of the base, which no posture moves."""
    calibration = visits_of(spread_postures(LOW, HIGH, 12, np.random.default_rng(0)), noise_px)
    moved = np.zeros((10, 4))
    moved[0] = 4.0
    for k, theta in enumerate(somewhere(20)):
        assert not is_consistent(calibration, visits_of([theta], noise_px, seed=k, moved=moved), noise_px)


@pytest.mark.parametrize("share, held", [(0.9, True), (1.1, False)])
def test_images_that_have_shifted_as_a_whole_are_consistent_up_to_a_limit(share, held):
    calibration = visits_of(spread_postures(LOW, HIGH, 20, np.random.default_rng(0)))
    shift = np.tile((share * MAX_SHIFT_PX, 0.0, share * MAX_SHIFT_PX, 0.0), (10, 1))
    assert {is_consistent(calibration, visits_of([theta], moved=shift), 0.0) for theta in somewhere(10)} == {held}
