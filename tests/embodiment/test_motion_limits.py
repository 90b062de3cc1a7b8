"""How far an arm is sent: no motion is longer than it may be, and no posture outside the workspace, whoever asks."""

import runpy
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings, strategies

from viewimit import Session
from viewimit.loop.arm_and_eyes import waypoints
from viewimit.loop.settings import Settings
from viewimit.servo import SERVOS

FakeRobot = runpy.run_path(str(Path(__file__).parents[2] / "examples" / "fake_robot.py"))["FakeRobot"]
ROUNDING = 1e-9  # rad
ONE = Settings(frames=1)
SHOWN_DEG, START_DEG = (45.0, -90.0), (25.0, -45.0)
WORKSPACE_DEG = ((-50.0, 50.0), (-60.0, 10.0), (20.0, 100.0))  # of the fake robot
SCENE_WORKSPACE_DEG = ((5.0, 80.0), (-120.0, -20.0))  # of the panda's two joints


class Recorded(FakeRobot):
    """All postures that it was sent to; hidden(theta): whether it sees its own points there."""

    def __init__(self, demonstrator_deg=(30, -45, 80), hidden=lambda theta: False):
        super().__init__(demonstrator_deg)
        self.sent, self.hidden = [], hidden

    def move(self, theta):
        self.sent.append(theta.copy())
        return super().move(theta)

    def look(self):
        seen = super().look()
        if self.hidden(self.theta):
            seen.visible[:, 2:] = False
        return seen


def changed(**fields):
    return msgspec.structs.replace(ONE, **fields)


def longest(postures):
    """rad, a joint, from one posture to the next."""
    return np.abs(np.diff(postures, axis=0)).max(initial=0.0)


def sent(session):
    return np.array([moment.commanded for moment in session.history])


def require_inside(postures, workspace_deg):
    low, high = np.radians(workspace_deg).T
    assert (postures >= low - ROUNDING).all() and (postures <= high + ROUNDING).all()


@pytest.mark.parametrize("servo", SERVOS)
@given(max_step_deg=strategies.floats(2.0, 40.0), seed=strategies.integers(0, 2**16))
@settings(max_examples=2)
def test_an_own_arm_is_never_sent_too_far_nor_out_of_its_workspace(servo, max_step_deg, seed):
    low, high = np.radians(WORKSPACE_DEG).T
    start, shown = np.random.default_rng(seed).uniform(low, high, (2, 3))
    robot = Recorded(np.degrees(shown))
    asked = {"servo": servo, "max_step_deg": max_step_deg, "workspace_deg": WORKSPACE_DEG, "seed": seed}
    session = Session.of(robot, robot, frames=1, start_deg=tuple(np.degrees(start)), **asked)
    session.run(60)
    session.scrub(session.cursor // 2)
    session.step()
    session.reset()
    assert longest(robot.sent) <= np.radians(max_step_deg) + ROUNDING
    require_inside(np.array(robot.sent), WORKSPACE_DEG)
    np.testing.assert_allclose(robot.sent[-1], start, atol=ROUNDING)


@pytest.mark.parametrize("servo", SERVOS)
@given(max_step_deg=strategies.floats(2.0, 40.0), seed=strategies.integers(0, 2**16), noise_px=strategies.just(0.5))
@settings(max_examples=2)
def test_in_a_scene_the_same_limits_hold(servo, max_step_deg, seed, noise_px):
    low, high = np.array(SCENE_WORKSPACE_DEG).T
    start_deg, shown_deg = np.random.default_rng(seed).uniform(low, high, (2, 2)).round(3)
    asked = changed(servo=servo, max_step_deg=max_step_deg, workspace_deg=SCENE_WORKSPACE_DEG, seed=seed)
    asked = msgspec.structs.replace(
        asked, start_deg=tuple(start_deg), demonstrator_deg=tuple(shown_deg), noise_px=noise_px
    )
    session = Session(asked)
    session.run(60)
    assert longest(sent(session)) <= np.radians(max_step_deg) + ROUNDING
    require_inside(sent(session), SCENE_WORKSPACE_DEG)


@pytest.mark.parametrize("max_step_deg", [5.0, 1.0])
def test_short_motions_arrive_and_claim_so_where_long_ones_do(max_step_deg):
    """The servo sees only the ends of what it asks for, so that a way in pieces changes nothing of what it knows."""
    robot = Recorded()
    own = Session.of(robot, robot, frames=1, max_step_deg=max_step_deg)
    shown = Session(changed(max_step_deg=max_step_deg, demonstrator_deg=SHOWN_DEG, start_deg=START_DEG))
    for session, target in ((own, robot.demonstrator), (shown, np.radians(SHOWN_DEG))):
        last = session.run(400).last
        assert last.status == "converged" and last.target is None
        assert np.degrees(np.abs(last.theta - target)).max() < 0.01
        assert longest(sent(session)) <= np.radians(max_step_deg) + ROUNDING


def test_with_noise_what_is_claimed_after_short_motions_is_true():
    """An error beyond three times what is expected would be one in hundreds."""
    rng, low, high = np.random.default_rng(3), (0.0, -130.0), (90.0, 0.0)
    for seed in range(6):
        start_deg, shown_deg = rng.uniform(low, high, (2, 2)).round(3)
        fields = {"max_step_deg": 5.0, "noise_px": 0.25, "seed": seed}
        postures = {"start_deg": tuple(start_deg), "demonstrator_deg": tuple(shown_deg)}
        last = Session(Settings(**fields, **postures)).run(200).last
        error = np.abs(last.theta - last.theta_demo).max()
        assert last.status == "converged" and error < 3 * last.expected_error


def test_a_demonstrator_outside_the_workspace_is_approached_and_not_claimed_to_be_reached():
    session = Session(changed(demonstrator_deg=(85, -90), start_deg=START_DEG, workspace_deg=((0, 60), (-130, 0))))
    last = session.run(200).last
    require_inside(sent(session), ((0, 60), (-130, 0)))
    assert last.status != "converged"


def test_a_rehearsal_goes_in_short_motions_and_keeps_the_postures_that_were_asked_for():
    low, high = np.radians(SCENE_WORKSPACE_DEG).T
    free, bound = (
        Session(changed(start_deg=START_DEG)),
        Session(changed(start_deg=START_DEG, max_step_deg=5.0, workspace_deg=SCENE_WORKSPACE_DEG)),
    )
    body = bound.calibrate(9, seed=1)
    lower = bound.embodiment.lower
    postures = np.array([visit.displacement + lower for visit in body.visits])
    assert len(body) == 9 and longest(sent(bound)) <= np.radians(5.0) + ROUNDING
    require_inside(sent(bound), SCENE_WORKSPACE_DEG)
    free.begin_calibration(postures)
    free.run(9)
    for one, other in zip(body.visits, free.snapshot.calibration.visits):
        np.testing.assert_allclose(one.displacement, other.displacement, atol=ROUNDING)
        np.testing.assert_allclose(one.own, other.own, atol=1e-6)
    with pytest.raises(ValueError, match="the rehearsed posture is outside the workspace: angle 2"):
        bound.begin_calibration(np.array([low, high, (low[0], high[1] + 0.1)]))


def test_who_goes_back_to_the_past_drives_the_arm_there_in_short_motions():
    robot = Recorded()
    session = Session.of(robot, robot, frames=1, max_step_deg=3.0)
    session.run(200)
    first, count = session.history[0].commanded, len(robot.sent)
    session.scrub(0)
    assert len(robot.sent) > count + 1
    np.testing.assert_allclose(robot.sent[-1], first, atol=ROUNDING)
    other = Session.of(robot, robot, frames=1, max_step_deg=3.0)
    other.resume(list(session.history), len(session.history) - 1)
    assert longest(robot.sent) <= np.radians(3.0) + ROUNDING


def test_a_demonstrator_that_moves_while_the_arm_is_on_its_way_is_followed_from_there():
    robot = Recorded()
    session = Session.of(robot, robot, frames=1, max_step_deg=3.0)
    while session.snapshot.target is None:
        assert session.step()
    robot.demonstrator = np.radians((-20.0, -30.0, 60.0))
    session.step()
    assert session.snapshot.target is None
    last = session.run(200).last
    assert last.status == "converged" and np.degrees(np.abs(last.theta - robot.demonstrator)).max() < 0.1


def test_points_that_are_out_of_sight_on_the_way_do_not_stop_it():
    """The servo asked for the end of the way, and is not asked before."""
    bound = {"frames": 1, "max_step_deg": 5.0, "servo": "broyden"}
    robot = Recorded()
    before = Session.of(robot, robot, **bound)
    before.run(200)
    on_the_way = [moment.theta for moment in before.history if moment.target is not None]
    robot = Recorded(hidden=lambda theta: any(np.abs(theta - there).max() < 1e-6 for there in on_the_way))
    session = Session.of(robot, robot, **bound)
    last = session.run(200).last
    assert any(moment.transfer is None for moment in session.history) and last.status == "settled"
    np.testing.assert_allclose(last.theta, before.snapshot.theta, atol=1e-9)


@pytest.mark.parametrize(
    "workspace_deg, why",
    [
        (((-50, 50), (-60, 10)), "needs a range for each of the 3 moving joints, got 2"),
        (((-90, 50), (-60, 10), (20, 100)), "range 1, -90° … 50°, is not inside its joint's limits -60° … 60°"),
        (((-50, 50), (-60, 10), (50, 100)), "the start posture is outside the workspace: angle 3 is 40°"),
    ],
)
def test_a_workspace_that_the_arm_does_not_have_is_refused_before_it_moves(workspace_deg, why):
    robot = Recorded()
    with pytest.raises(ValueError, match=why):
        Session.of(robot, robot, frames=1, workspace_deg=workspace_deg)
    assert not robot.sent


@pytest.mark.parametrize(
    "fields, why",
    [
        ({"max_step_deg": 0.0}, "max_step_deg must be between 0.01 and 360"),
        ({"max_step_deg": float("nan")}, "max_step_deg must be between"),
        ({"max_step_deg": "5"}, "max_step_deg must be a number"),
        ({"workspace_deg": ((60, -60),)}, "60° … -60° is no range"),
        ({"workspace_deg": ((0, float("inf")),)}, "is no range"),
        ({"workspace_deg": (0, 60)}, r"workspace_deg must be \[lowest, highest\] each"),
    ],
)
def test_settings_that_limit_nothing_are_refused(fields, why):
    with pytest.raises(ValueError, match=why):
        Settings(**fields)


@given(
    target=strategies.lists(strategies.floats(-3, 3), min_size=2, max_size=2), longest_rad=strategies.floats(1e-3, 4)
)
def test_waypoints_lead_straight_to_the_target_by_as_few_motions_as_that_takes(target, longest_rad):
    start, target = np.array([0.3, -0.2]), np.array(target)
    way = waypoints(start, target, longest_rad)
    steps = np.diff([start, *way], axis=0)
    assert np.array_equal(way[-1], target) and np.abs(steps).max() <= longest_rad * (1 + 1e-8)
    assert len(way) <= max(np.abs(target - start).max() / longest_rad + 1, 1)
    np.testing.assert_allclose(steps, np.broadcast_to(steps[0], steps.shape), atol=1e-12)
    assert len(waypoints(start, target, np.inf)) == 1
