"""A frozen transfer carries a motion over; the learner knows images and its own displacements only."""

from dataclasses import replace

import numpy as np
import pytest

from viewimit.analysis import trajectory
from viewimit.analysis.trajectory import follow, hand_points
from viewimit.loop.history import History
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.simulation.world import hand_position

QUICK = {"start_deg": (30, -70)}


def converged(**settings):
    session = Session(Settings.paper(**{**QUICK, **settings}))
    session.run(60, patience=1)
    return session


@pytest.fixture(scope="module")
def session():
    return converged()


class Oracle:
    """The demonstrator's own views of itself, looked up by what [l], [r] show: a transfer without error."""

    def __init__(self, session, moves):
        world = session.world
        self.seen = np.array([world.demo_images(theta)[0] for theta in moves.theta])
        self.own = np.array([world.own_images(theta)[0] for theta in moves.theta])

    def recover(self, left, right):
        here = np.concatenate([left, right], -1)
        return self.own[np.abs(self.seen - here).max((1, 2)).argmin()]


def test_with_a_transfer_without_error_the_posture_itself_is_imitated(session):
    """What is left is how fast J turns in one frame: 1.6° a frame times J's change, a few hundredths of a degree."""
    moves = trajectory.sinusoid(session.world, session.snapshot.theta_demo)
    found = follow(session, Oracle(session, moves), moves, np.ones(10, bool))
    assert np.median(found.joint_deg) < 0.05 and found.joint_deg.max() < 0.3
    assert np.median(found.hand_m) < 0.5e-3
    np.testing.assert_allclose(found.target, found.desired, atol=1e-9)


def test_what_is_told_is_what_it_is(session):
    moves = trajectory.sinusoid(session.world, session.snapshot.theta_demo, frames=15)
    hand = hand_points(session)
    found = follow(session, session.snapshot.transfer, moves, hand)
    world = session.world
    np.testing.assert_array_equal(found.theta_demo, moves.theta)
    for t, (theta, theta_demo) in enumerate(zip(found.theta, moves.theta)):
        own, desired = world.own_images(theta)[0], world.own_images(theta_demo)[0]
        demo = world.demo_images(theta_demo)[0]
        target = session.snapshot.transfer.recover(demo[:, :2], demo[:, 2:])
        apart = [np.hypot(*(own - desired)[i, k : k + 2]) for i in np.flatnonzero(hand) for k in (0, 2)]
        missed = [np.hypot(*(own - target)[i, k : k + 2]) for i in np.flatnonzero(hand) for k in (0, 2)]
        assert found.image_px[t] == pytest.approx(np.mean(apart)) and found.target_px[t] == pytest.approx(
            np.mean(missed)
        )
        assert found.joint_deg[t] == pytest.approx(np.degrees(np.abs(theta - theta_demo)).max())
        hands = [hand_position(world, posture, world.T_world_own) for posture in (theta, theta_demo)]
        assert found.hand_m[t] == pytest.approx(np.linalg.norm(hands[0] - hands[1]))


def test_a_motion_is_carried_over_within_the_workspace_and_in_short_steps():
    limits = {"max_step_deg": 1.0, "workspace_deg": ((0, 90), (-130, -40))}
    bound = Session(Settings(transfer="epipolar", servo="broyden", **QUICK, **limits))
    bound.run(60)
    moves = trajectory.sinusoid(bound.world, bound.snapshot.theta_demo)
    theta = np.degrees(follow(bound, bound.snapshot.transfer, moves, np.ones(10, bool)).theta)
    assert np.abs(np.diff(theta, axis=0)).max() == pytest.approx(1.0)  # as the demonstrator is faster
    assert theta[:, 1].max() <= -40 + 1e-9


def test_the_learner_sees_no_truth(session, monkeypatch):
    """The same way of the arm, whatever the truth that is kept for people says."""
    moves = trajectory.sinusoid(session.world, session.snapshot.theta_demo, frames=10)
    honest = follow(session, session.snapshot.transfer, moves, np.ones(10, bool))
    poisoned = Session(Settings.paper(**QUICK))
    moments = [replace(moment, theta_demo=moment.theta_demo * np.nan) for moment in session.history]
    poisoned.history = History(moments, session.cursor)
    monkeypatch.setattr("viewimit.analysis.trajectory.hand_position", lambda *_: np.full(3, np.nan))
    blind = follow(poisoned, session.snapshot.transfer, moves, np.ones(10, bool))
    np.testing.assert_array_equal(blind.theta, honest.theta)
