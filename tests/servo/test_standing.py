"""Arms that do not stand where they are sent: images tell where they do, and claims hold."""

import numpy as np
import pytest

from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.servo import SERVOS
from viewimit.servo.observation import Visit
from viewimit.servo.trust_region.localisation import contradicts_command, localise

JOINTS, POINTS = 2, 8
J = np.random.default_rng(3).normal(0, 200, (POINTS, 4, JOINTS))  # px/rad
Y = np.random.default_rng(4).uniform(0, 240, (POINTS, 4))
EVERY = np.ones((POINTS, 2), bool)


def visit(sent_deg, stands_deg=None, jacobian=J, noise=0.0):
    """Sent there, it stands elsewhere: images are linear."""
    sent, stands = np.radians(sent_deg), np.radians(sent_deg if stands_deg is None else stands_deg)
    return Visit.of(sent, Y + jacobian @ stands + noise, EVERY)


PROBED = (visit((0, 0)), visit((15, 0)), visit((15, 15)))


def test_an_image_that_should_have_changed_contradicts_where_the_arm_was_sent():
    assert contradicts_command(PROBED, visit((15.4, 15.3), (15, 15)), 0.0)
    assert contradicts_command(PROBED, visit((0.4, 0.1), (0, 0)), 0.0)
    assert not contradicts_command(PROBED, visit((15.4, 15.3)), 0.0)
    assert not contradicts_command(PROBED[:2], visit((15.4, 0), (15, 0)), 0.0)  # nothing is foreseen yet


def test_under_noise_only_more_than_noise_contradicts():
    noise = np.random.default_rng(5).normal(0, 0.5, (POINTS, 4))
    assert not contradicts_command(PROBED, visit((15.1, 15.1), (15, 15), noise=noise), 0.5)
    assert contradicts_command(PROBED, visit((16, 16), (15, 15), noise=noise), 0.5)


def test_a_joint_that_moves_no_point_contradicts_nothing():
    still = J * (1.0, 0.0)
    known = [visit(at, jacobian=still) for at in ((0, 0), (15, 0), (15, 15))]
    assert not contradicts_command(tuple(known), visit((15, 20), jacobian=still), 0.0)


def test_the_same_image_is_the_same_posture_and_another_is_where_its_images_say():
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
    "disturbed", [{"encoder_step_deg": 0.5}, {"encoder_step_deg": 1.0}, {"encoder_step_deg": 1.0, "noise_px": 0.2}]
)
def test_an_arm_that_moves_in_steps_comes_as_near_as_they_lead_and_knows_how_near_that_is(disturbed):
    """Noise adds to how far off it ends, and now and then leaves it without evidence: nine in ten claim to be there."""
    ends, noisy = [run(k, **disturbed) for k in range(12)], "noise_px" in disturbed
    claims = [end for end in ends if end.status == "converged"]
    assert len(claims) >= (10 if noisy else 12)
    off = np.array([np.abs(end.theta - end.theta_demo).max() for end in claims])
    expected = np.array([end.expected_error for end in claims])
    largest = np.sqrt(np.mean(off**2)) if noisy else off.max()
    assert np.degrees(largest) < disturbed["encoder_step_deg"]
    assert (off <= 3 * expected).all() and (off <= 2 * expected).mean() > 0.8
    assert any(end.servo_state.mismatch is not None for end in ends)


def test_an_arm_that_obeys_is_never_told_by_its_images():
    assert all(run(k, noise_px=noise).servo_state.mismatch is None for k in range(6) for noise in (0.0, 0.5))


def test_an_arm_that_is_sent_to_its_limit_and_falls_short_says_so():
    """It moves by 20 % less than it is told, so it cannot be sent as far as it could go."""
    end = run(3, gain_error=-0.2)
    assert end.status == "no-progress" and end.commanded[0] == np.radians(90) > end.theta[0]
    assert "a joint was sent to its limit" in SERVOS["trust-region"].describe_status(end.servo_state, end.status)
