"""The estimator: accuracy, claims, hypotheses, limits, following, and that it says when it knows nothing."""

from dataclasses import replace
from math import erf

import numpy as np
import pytest
from linear_world import LinearWorld

from viewimit import Session, Settings
from viewimit.servo import SERVOS, Certificate, MisfitKind, ServoStatus
from viewimit.servo.estimator import EstimatorOptions
from viewimit.servo.estimator.rule import cost, loss
from viewimit.simulation.scene import load_scene

NOISY = {"noise_px": 0.25, "frames": 25}


def run(start=(70, -140), **fields):
    session = Session(Settings(servo="likelihood", start_deg=start, **fields))
    return session, session.run(60)


def error_deg(session):
    return float(np.degrees(np.abs(session.snapshot.theta - session.snapshot.theta_demo)).max())


@pytest.mark.parametrize("scene", ["panda", "iiwa"])
def test_it_arrives_from_anywhere_in_the_range_and_from_corner_to_corner(scene):
    """Within 0.001° of the demonstrator, and no motion passes a limit."""
    rng, limits = np.random.default_rng(20), np.array(load_scene(scene).range_deg).T
    pairs = [*rng.uniform(*limits, (8, 2, 2)), limits, limits[::-1]]
    motions = []
    for demo, start in pairs:
        session, result = run(tuple(start), scene=scene, demonstrator_deg=tuple(demo))
        assert result.success and error_deg(session) < 1e-3
        for moment in session.history:
            theta = np.degrees(moment.theta)
            assert (theta >= limits[0] - 1e-9).all() and (theta <= limits[1] + 1e-9).all()
        motions.append(result.motions)
    assert np.median(motions) <= 3 and max(motions) <= 5


def test_rounding_errors_decide_no_motion():
    """Places about the start are drawn from few lengths, so that many are equally far from all visits."""
    one, other = (
        run((25 + off, -25 + off), points=16, missing=0.4, frames=1, seed=2)[0].history for off in (0.0, -1e-9)
    )
    assert [moment.status for moment in one] == [moment.status for moment in other] and len(one) > 6
    for moment, same in zip(one, other):
        np.testing.assert_allclose(moment.commanded, same.commanded, atol=1e-5)


def test_seven_joints_take_a_probe_each_and_one_motion():
    settings = Settings(joints=(1, 2, 3, 4, 5, 6, 7), points=16)
    session = Session(settings)
    lower, upper = session.embodiment.lower, session.embodiment.upper
    session.pose(np.clip(session.snapshot.theta + np.random.default_rng(1).uniform(-0.5, 0.5, 7), lower, upper))
    result = session.run(60)
    assert result.success and result.motions <= 9 and error_deg(session) < 1e-3


@pytest.mark.parametrize("seed", [0, *(pytest.param(k, marks=pytest.mark.slow) for k in range(1, 6))])
def test_with_noise_the_error_is_small_and_the_claim_honest(seed):
    session, result = run(seed=seed, **NOISY)
    assert result.success and result.motions <= 8
    assert error_deg(session) < min(0.6, 3 * np.degrees(session.snapshot.expected_error))


def test_a_goal_beyond_a_limit_is_named_and_not_claimed():
    fields = {"workspace_deg": ((0, 90), (-180, -92)), "demonstrator_deg": (45, -90)}
    session, result = run((70, -140), seed=1, **fields, **NOISY)
    misfit = session.snapshot.misfit
    assert not result.success and misfit is not None and misfit.kind is MisfitKind.LIMIT
    (beyond,) = misfit.limits
    assert beyond.joint == 1 and np.degrees(beyond.beyond) == pytest.approx(2, abs=0.6)
    assert np.degrees(session.snapshot.theta[1]) == pytest.approx(-92, abs=0.1)


def test_swapped_points_are_put_right():
    session, result = run(seed=1, swapped=0.2, **NOISY)
    assert result.success and session.snapshot.exchanged and error_deg(session) < 0.5


def test_an_arm_that_is_not_where_it_was_sent_is_found_and_driven_right():
    session, result = run(seed=2, encoder_step_deg=2.0, **NOISY)
    assert session.snapshot.misfit.kind is MisfitKind.ARM and error_deg(session) < 2
    assert not result.success or error_deg(session) < 2 * np.degrees(session.snapshot.expected_error)


def test_a_demonstrator_that_moved_is_found_again_without_probes():
    session, _ = run(seed=4, **NOISY)
    before = session.snapshot.motion
    session.pose(np.radians((30, -60)))
    assert session.snapshot.status is ServoStatus.MOVING
    session.run(before + 20)
    assert session.snapshot.status.is_claim and session.snapshot.motion - before <= 3 and error_deg(session) < 0.6


def test_a_demonstrator_that_keeps_moving_is_followed():
    session, _ = run(seed=5, **NOISY)
    errors = []
    for k in range(1, 30):
        session.step()
        session.pose(np.radians((45 + k, -90 - 0.7 * k)))
        errors.append(error_deg(session))
    assert max(errors[8:]) < 0.6


def test_bodies_without_rigid_links_are_not_claimed():
    world, theta, state = LinearWorld(2, np.random.default_rng(4), 9), np.zeros(2), None
    servo = SERVOS["likelihood"]
    for motion in range(40):
        seen = replace(world.seen(theta, motion), noise_px=0.1)
        state = servo.start(seen) if state is None else state
        state, step = servo.step(state, seen, world.residuals)
        if not step.any():
            break
        theta = theta + step
    assert state.status is ServoStatus.NO_PROGRESS and state.misfit.kind is MisfitKind.NOT_RIGID
    assert state.visits[-1].displacement == pytest.approx(theta)


def test_few_points_make_no_false_claim_and_no_long_way():
    session, result = run((25, -45), seed=1, points=5, **NOISY)
    assert not result.success or error_deg(session) < 3 * np.degrees(session.snapshot.expected_error)
    assert result.motions < 25


def test_a_servo_at_rest_is_not_asked_to_think_again():
    session, _ = run()
    state = session.snapshot.servo_state
    session.step()
    assert session.snapshot.servo_state is state


def test_the_rule_prefers_less_error_and_shorter_ways():
    options, errors = EstimatorOptions(), np.radians([0.01, 0.1, 0.5, 0.75, 1.0, 3.0])
    assert (np.diff(loss(errors, options)) > 0).all()
    assert loss(errors[3], options) == pytest.approx(errors[3] + options.claim_worth / 2)
    ways = np.radians([[0.0, 1.0], [5.0, 1.0], [20.0, 1.0], [90.0, 1.0]])
    assert (np.diff(cost(ways, np.radians(10), options)) > 0).all()
    assert cost(ways[2], np.inf, options, looks=3) > cost(ways[2], np.inf, options)


@pytest.mark.parametrize("joints", [1, 2, 7])
def test_the_simultaneous_error_holds_the_largest_of_all_joints_as_often_as_two_sigma_holds_one(joints):
    """Šidák: of independent errors, all are within 2 s with the probability that a single one is within 2 σ."""
    one = np.full(joints, np.radians(0.5))
    bound = 2 * Certificate(one, one).simultaneous_std_error / np.radians(0.5)
    within = lambda sigmas: erf(sigmas / np.sqrt(2))
    assert within(bound) ** joints == pytest.approx(within(2.0))
