"""The simple laws: Broyden's and the paper's gradient, driven by images of our own making."""

from dataclasses import replace

import numpy as np
import pytest
from linear_world import LinearWorld

from viewimit.analysis.landscape import grid_axes, landscape_over
from viewimit.estimation.transfers import TRANSFERS
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.servo import Broyden, Gradient, Observation
from viewimit.servo.gradient import PAPER, RETUNED
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World


@pytest.mark.parametrize("m", [1, 2, 3, 7])
def test_broyden_finds_a_linear_image_map_by_one_probe_a_joint_and_then_its_target(m):
    world, servo = LinearWorld(m, np.random.default_rng(m), 6), Broyden()
    theta = np.zeros(m)
    state = servo.start(world.seen(theta, 0))
    for motion in range(m + 2):
        state, step = servo.step(state, world.seen(theta, motion), world.residuals)
        assert state.probe == (motion < m)
        if motion == m:
            np.testing.assert_allclose(state.model.jacobian, world.J, atol=1e-8)
        theta = theta + step
    assert np.degrees(np.abs(theta - world.aim)).max() < 0.1
    state, step = servo.step(state, world.seen(theta, m + 2), world.residuals)
    assert state.status == "settled" and not step.any()  # that the next step is small is no evidence


def test_broyden_does_not_learn_from_points_that_were_not_seen():
    world, servo = LinearWorld(2, np.random.default_rng(5), 6), Broyden()
    seen = world.seen(np.zeros(2), 0)
    state, step = servo.step(servo.start(seen), seen, world.residuals)
    after = world.seen(step, 1)
    hidden = after.seen.copy()
    hidden[0, 1] = False  # the first point, in [R]
    own = after.own.copy()
    own[0, 2:] = 1e6
    learned, _ = servo.step(state, replace(after, own=own, seen=hidden), world.residuals)
    joint = int(np.argmax(np.abs(step)))
    np.testing.assert_allclose(learned.model.jacobian[0, :2, joint], world.J[0, :2, joint], atol=1e-8)
    assert not learned.model.jacobian[0, 2:].any()
    np.testing.assert_allclose(learned.model.jacobian[1:, :, joint], world.J[1:, :, joint], atol=1e-8)


def test_the_papers_first_step_by_hand():
    assert (PAPER.gain, PAPER.forgetting, PAPER.jacobian) == (0.005, 0.95, (-1, 1))  # Section 5.3, Eq. (14)
    seen = Observation(np.zeros((5, 4)), np.ones((5, 2), bool), 100.0, np.zeros(2), -np.ones(2), np.ones(2), 0)
    servo = Gradient(PAPER)
    _, step = servo.step(servo.start(seen), seen, None)
    np.testing.assert_allclose(np.degrees(step), [0.5, -0.5])  # -0.005 · [-1, 1]ᵀ · 100


@pytest.mark.parametrize("options", [PAPER, RETUNED])
def test_the_recursive_gradient_is_the_weighted_least_squares_one(options):
    """Σ ρ^(k-i) (ΔE_i - J u_i)² + ρ^k |J - J_0|² / P_0 is least at the J of step k."""
    rng, servo, rho = np.random.default_rng(1), Gradient(options), options.forgetting
    theta, E = np.zeros(2), 50.0

    def seen():
        wide = np.full(2, 9.0)
        return Observation(np.zeros((5, 4)), np.ones((5, 2), bool), E, theta, -wide, wide, 0)

    state, moves, changes = servo.start(seen()), [], []
    for k in range(1, 16):
        moves.append(rng.normal(0, 3, 2))
        changes.append(rng.normal(0, 5))
        theta, E = theta + np.radians(moves[-1]), E + changes[-1]
        state, _ = servo.step(state, seen(), None)
        u, dE, weight = np.array(moves), np.array(changes), rho ** np.arange(k - 1, -1, -1)
        prior = rho**k / options.covariance
        normal = (u * weight[:, None]).T @ u + prior * np.eye(2)
        right = (u * weight[:, None]).T @ dE + prior * np.array(options.jacobian)
        np.testing.assert_allclose(state.jacobian, np.linalg.solve(normal, right), rtol=1e-6, atol=1e-8)


def test_the_retuned_law_bounds_its_steps():
    seen = Observation(np.zeros((5, 4)), np.ones((5, 2), bool), 1e4, np.zeros(2), -np.ones(2), np.ones(2), 0)
    servo = Gradient(replace(RETUNED, dither_deg=0.0))
    _, step = servo.step(servo.start(seen), seen, None)
    assert np.degrees(np.linalg.norm(step)) == pytest.approx(RETUNED.max_step_deg)


@pytest.mark.parametrize("motion", [0, 15, 16, 700])
def test_the_dither_of_a_motion_is_a_stream_of_its_own(motion):
    still = Observation(np.zeros((5, 4)), np.ones((5, 2), bool), 0.0, np.zeros(3), -np.ones(3), np.ones(3), motion)
    servo = replace(Gradient(RETUNED), seed=11)
    _, step = servo.step(servo.start(still), still, None)
    expected = RETUNED.dither_deg * np.random.default_rng([11, motion]).standard_normal(3)
    np.testing.assert_allclose(np.degrees(step), expected)


def lowest(world, transfer, theta_demo):
    """The transfer's own minimum, rad: of the 1° grid, then of a 0.02° grid about it."""
    demo, seen = world.demo_images(theta_demo)
    coarse = landscape_over(world, TRANSFERS[transfer], demo, seen, grid_axes(world)).minimum
    near = tuple(c + np.radians(np.arange(-1, 1.001, 0.02)) for c in coarse)
    return landscape_over(world, TRANSFERS[transfer], demo, seen, near).minimum


@pytest.mark.parametrize("grid", [(4, 5), pytest.param((10, 13), marks=pytest.mark.slow)], ids=str)
def test_broyden_reaches_the_minimum_of_the_linear_transfer_from_a_grid_of_starts(grid):
    demonstrator = np.radians((45, -90))
    target = np.degrees(lowest(World(load_scene("panda")), "linear", demonstrator))
    offsets, motions = [], []
    for first in np.linspace(0, 90, grid[0]):
        for second in np.linspace(-180, 0, grid[1]):
            session = Session(Settings.paper(transfer="linear", demonstrator_deg=(45, -90), start_deg=(first, second)))
            session.run(100)
            offsets.append(np.abs(np.degrees(session.snapshot.theta) - target).max())
            motions.append(session.snapshot.motion)
    assert np.mean(np.array(offsets) <= 1) >= 0.97
    assert np.median(motions) <= 15
