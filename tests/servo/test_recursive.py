"""The Kalman filter and damped Gauss-Newton, on linear images and in the simulated world."""

from dataclasses import replace

import numpy as np
import pytest
from linear_world import LinearWorld

from viewimit.analysis.landscape import grid_axes, landscape_over
from viewimit.estimation.transfers import TRANSFERS
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.servo import GaussNewton, Kalman

LAWS = {"kalman": Kalman(), "gauss-newton": GaussNewton()}


@pytest.mark.parametrize("m", [1, 2, 7])
@pytest.mark.parametrize("name", LAWS)
def test_one_probe_for_each_joint_determines_a_linear_jacobian_and_the_next_motions_arrive(name, m):
    world, law, theta = LinearWorld(m, np.random.default_rng(m), 6), LAWS[name], np.zeros(m)
    state = law.start(world.seen(theta, 0))
    for motion in range(m + 4):
        state, step = law.step(state, world.seen(theta, motion), world.residuals)
        assert state.probe == (motion < m)
        theta = theta + step
        if motion == m:
            np.testing.assert_allclose(state.model.jacobian, world.J, atol=0.5)  # px/rad, of 100
    assert np.degrees(np.abs(theta - world.aim)).max() < 0.1
    assert state.status == "settled" and not step.any()  # that the next step is small is no evidence


@pytest.mark.parametrize("name", LAWS)
def test_a_joint_at_its_limit_is_held_and_the_others_minimise_E(name):
    world, law = LinearWorld(2, np.random.default_rng(8), 6), LAWS[name]
    world.aim = np.array([0.3, -0.25])
    theta = np.zeros(2)

    def observe(motion):
        return replace(world.seen(theta, motion), upper=np.array([0.1, 2.0]))

    state = law.start(observe(0))
    for motion in range(25):
        state, step = law.step(state, observe(motion), world.residuals)
        theta = theta + step
    J = world.J.reshape(-1, 2)
    least = world.aim[1] + J[:, 1] @ J[:, 0] * (world.aim[0] - 0.1) / (J[:, 1] @ J[:, 1])
    assert theta[0] == pytest.approx(0.1) and theta[1] == pytest.approx(least, abs=np.radians(0.15))
    assert state.status == "settled"


def test_a_motion_that_raises_E_increases_the_damping_and_shortens_motions():
    world, law, theta = LinearWorld(2, np.random.default_rng(4), 6), GaussNewton(), np.zeros(2)
    state = law.start(world.seen(theta, 0))
    for motion in range(3):
        state, step = law.step(state, world.seen(theta, motion), world.residuals)
        if motion < 2:
            theta = theta + step
    lower, _ = law.step(state, replace(world.seen(theta, 3), E=state.previous_E / 2), world.residuals)
    higher, again = law.step(state, replace(world.seen(theta, 3), E=state.previous_E * 2), world.residuals)
    assert lower.damping < state.damping < higher.damping
    J = world.J.reshape(-1, 2)
    normal, gradient = J.T @ J, J.T @ world.residuals(world.images(theta)).ravel()
    expected = -np.linalg.solve(normal + higher.damping * np.diag(np.diag(normal)), gradient)
    np.testing.assert_allclose(again, expected, rtol=1e-3)
    assert np.linalg.norm(again) < np.linalg.norm(step)


@pytest.mark.parametrize("name", LAWS)
def test_it_settles_at_the_transfers_minimum_and_claims_nothing(name):
    """At (45, -90) the linear transfer's least E is 0.6° from the demonstrator."""
    ends = []
    for start in ((25, -45), (60, -120), (80, -60)):
        session = Session(Settings.paper(transfer="linear", servo=name, demonstrator_deg=(45, -90), start_deg=start))
        last = session.run(60).last
        assert last.status == "settled" and last.motion <= 20 and last.certificate is None
        ends.append(last.theta)
    world, demo, seen = session.world, last.views.demo, last.views.visible[:, :2]
    near = tuple(np.radians(np.arange(-2, 2.001, 0.05)) + at for at in last.theta_demo)
    assert len(grid_axes(world)) == 2
    least = landscape_over(world, TRANSFERS["linear"], demo, seen, near).minimum
    off = np.degrees(np.abs(np.array(ends) - least)).max(1)  # a Jacobian of some motions ago may end it early
    assert (off < 1).all() and (off < 0.2).sum() >= 2
