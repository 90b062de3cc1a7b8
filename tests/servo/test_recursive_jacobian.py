"""The recursive image Jacobian in the limits that have names, and the two laws that stand on it."""

from dataclasses import replace

import numpy as np
import pytest
from linear_world import LinearWorld

from viewimit.analysis.landscape import grid_axes, landscape_over
from viewimit.estimation.transfers import TRANSFERS
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.servo import SERVOS, GaussNewton, Kalman, LastMotion, Observation
from viewimit.servo.image_jacobian import BroydenModel, RecursiveJacobian

LAWS = {"kalman": Kalman(), "gauss-newton": GaussNewton()}


def walk(rng, m=3, points=6, motions=9, hidden=0.25):
    """Observations of images that have nothing to do with the motions, with points that come and go."""
    theta, wide = np.zeros(m), np.full(m, 9.0)
    for k in range(motions):
        yield Observation(
            rng.uniform(0, 300, (points, 4)), rng.uniform(size=(points, 2)) > hidden, 0.0, theta, -wide, wide, k
        )
        theta = theta + rng.normal(0, 0.2, m)


@pytest.mark.parametrize("soft", [0.0, 0.05])
def test_a_filter_that_does_not_remember_how_well_it_knows_is_broydens_update(soft):
    """P' = q I, so that k = h/(r/q + hᵀh): Broyden's, with soft² = r/q; what it remembers makes the difference."""
    q, first, *rest = 1e6, *walk(np.random.default_rng(1))
    filtered, broyden = RecursiveJacobian.start(first, 0.0), BroydenModel.start(first)
    remembering = filtered
    for seen in rest:
        r = max(soft**2, 1e-18) * q
        filtered, broyden = filtered.update(seen, r, q), broyden.update(seen, soft)
        remembering = remembering.update(seen, r, q)
        filtered = replace(filtered, covariance=np.zeros_like(filtered.covariance))
        np.testing.assert_allclose(filtered.jacobian, broyden.jacobian, rtol=1e-9, atol=1e-7)
        np.testing.assert_allclose(filtered.last.own, broyden.last.own, rtol=1e-9)
    assert np.abs(broyden.jacobian).max() > 100 and np.abs(remembering.jacobian - broyden.jacobian).max() > 10


@pytest.mark.parametrize("forgetting", [1.0, 0.9, 0.5])
def test_without_drift_it_is_weighted_least_squares_over_all_motions_at_once(forgetting):
    """Σ λ^(k-i) (Δy_i - j·h_i)² + λ^k |j|²/P_0 over the motions at both ends of which the point was seen is least."""
    rng = np.random.default_rng(2)
    first, *rest = walk(rng, points=4)
    P_0, model, before = 100.0, RecursiveJacobian.start(first, 100.0), first
    told = [[] for _ in range(8)]  # h and Δy, by point and image
    for seen in rest:
        model = model.update(seen, r=forgetting, forgetting=forgetting)
        h = seen.displacement - before.displacement
        for k in range(8):
            point, image = divmod(k, 2)
            columns = slice(2 * image, 2 * image + 2)
            if seen.seen[point, image] and before.seen[point, image]:
                told[k].append((h, (seen.own - before.own)[point, columns]))
        before = seen
    for k, pairs in enumerate(told):
        assert len(pairs) >= 2
        point, image = divmod(k, 2)
        weight = forgetting ** np.arange(len(pairs) - 1, -1, -1)
        H, dy = (np.array(column) for column in zip(*pairs))
        normal = (H * weight[:, None]).T @ H + forgetting ** len(pairs) / P_0 * np.eye(3)
        batch = np.linalg.solve(normal, (H * weight[:, None]).T @ dy).T
        np.testing.assert_allclose(model.jacobian[point, 2 * image : 2 * image + 2], batch, rtol=1e-7, atol=1e-7)
        np.testing.assert_allclose(model.covariance[point, image], np.linalg.inv(normal), rtol=1e-7)


def test_the_filter_tells_how_well_it_knows_what_it_measures():
    """A true Jacobian that is drawn from P_0, and measured with variance r: the errors are as P says."""
    rng, m, r, P_0 = np.random.default_rng(3), 2, 4.0, 100.0**2
    points, wide = 2000, np.full(2, 9.0)
    true, rest = rng.normal(0, 100.0, (points, 4, m)), rng.uniform(0, 300, (points, 4))
    theta = np.zeros(m)

    def seen(noise):
        own = rest + true @ theta + rng.normal(0, np.sqrt(noise), (points, 4))
        return Observation(own, np.ones((points, 2), bool), 0.0, theta, -wide, wide, 0)

    model = RecursiveJacobian.start(seen(0.0), P_0)
    for _ in range(4):
        model = replace(model, last=replace(model.last, own=rest + true @ theta))  # the end before, without noise
        theta = theta + rng.normal(0, 0.03, m)
        model = model.update(seen(r), r)
    whitened = np.linalg.solve(np.linalg.cholesky(model.covariance[0, 0]), (model.jacobian - true).reshape(-1, m).T)
    np.testing.assert_allclose(whitened @ whitened.T / whitened.shape[1], np.eye(m), atol=0.06)
    assert 0 < model.mean_gain < 1


@pytest.mark.parametrize("m", [1, 2, 7])
@pytest.mark.parametrize("name", LAWS)
def test_in_a_linear_world_a_probe_a_joint_tells_the_jacobian_and_the_next_motions_arrive(name, m):
    world, law, theta = LinearWorld(m, np.random.default_rng(m), 6), LAWS[name], np.zeros(m)
    state = law.start(world.observe(theta, 0))
    for motion in range(m + 4):
        state, step = law.step(state, world.observe(theta, motion), world.residuals)
        assert state.probe == (motion < m)
        theta = theta + step
        if motion == m:
            np.testing.assert_allclose(state.model.jacobian, world.J, atol=0.5)  # px/rad, of 100
    assert np.degrees(np.abs(theta - world.aim)).max() < 0.1
    assert state.status == "settled" and not step.any()  # that the next step is small is no evidence


@pytest.mark.parametrize("name", LAWS)
def test_a_joint_that_would_leave_its_range_is_held_and_the_others_find_their_least(name):
    world, law = LinearWorld(2, np.random.default_rng(8), 6), LAWS[name]
    world.aim = np.array([0.3, -0.25])
    theta = np.zeros(2)

    def observe(motion):
        return replace(world.observe(theta, motion), upper=np.array([0.1, 2.0]))

    state = law.start(observe(0))
    for motion in range(25):
        state, step = law.step(state, observe(motion), world.residuals)
        theta = theta + step
    J = world.J.reshape(-1, 2)
    least = world.aim[1] + J[:, 1] @ J[:, 0] * (world.aim[0] - 0.1) / (J[:, 1] @ J[:, 1])
    assert theta[0] == pytest.approx(0.1) and theta[1] == pytest.approx(least, abs=np.radians(0.15))
    assert state.status == "settled"


def test_a_motion_that_raises_E_is_answered_with_more_damping_and_shorter_motions():
    world, law, theta = LinearWorld(2, np.random.default_rng(4), 6), GaussNewton(), np.zeros(2)
    state = law.start(world.observe(theta, 0))
    for motion in range(3):
        state, step = law.step(state, world.observe(theta, motion), world.residuals)
        if motion < 2:
            theta = theta + step
    lower, _ = law.step(state, replace(world.observe(theta, 3), E=state.previous_E / 2), world.residuals)
    higher, again = law.step(state, replace(world.observe(theta, 3), E=state.previous_E * 2), world.residuals)
    assert lower.damping < state.damping < higher.damping
    J = world.J.reshape(-1, 2)
    normal, gradient = J.T @ J, J.T @ world.residuals(world.images(theta)).ravel()
    expected = -np.linalg.solve(normal + higher.damping * np.diag(np.diag(normal)), gradient)
    np.testing.assert_allclose(again, expected, rtol=1e-3)
    assert np.linalg.norm(again) < np.linalg.norm(step)


@pytest.mark.parametrize("name", LAWS)
def test_it_gives_up_where_nothing_is_known_or_E_does_not_fall(name):
    world, law = LinearWorld(2, np.random.default_rng(6), 6), LAWS[name]

    def rests(residuals, E):
        theta = np.zeros(2)
        state = law.start(replace(world.observe(theta, 0), E=E))
        for motion in range(60):
            state, step = law.step(state, replace(world.observe(theta, motion), E=E), residuals)
            if not step.any():
                return state.status, motion
            theta = theta + step
        raise AssertionError("it never rests")

    assert rests(lambda own: np.full((*own.shape[:-2], 1, 4), np.inf), np.inf) == ("no-progress", 2)
    noise = np.random.default_rng(0)
    status, motion = rests(lambda own: world.residuals(own) + noise.normal(0, 100), 5.0)
    assert status == "no-progress" and 25 < motion < 40


@pytest.mark.parametrize("name", LAWS)
def test_it_ends_at_the_transfers_own_minimum_and_claims_nothing(name):
    """At (45, -90) the linear transfer's least E is 0.6° aside of the demonstrator."""
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
    assert SERVOS[name].describe_status(last.servo_state, "settled") == "next step under 0.1°"


@pytest.mark.parametrize("name", LAWS)
def test_its_equations_carry_the_numbers_of_the_moment(name):
    session = Session(Settings.paper(transfer="linear", servo=name, demonstrator_deg=(45, -90), start_deg=(25, -45)))
    for _ in range(4):
        before = session.snapshot
        session.step()
    now, law = session.snapshot, SERVOS[name]
    moment = LastMotion(before.E, before.views.visible[:, 2:], now.theta - np.radians((25, -45)), now.moved, now.status)
    said = [equation.numbers for equation in law.equations(now.servo_state, moment)]
    asked = [f"{value:.2f}°".replace("-", "−") for value in np.degrees(now.servo_state.requested)]
    assert all(word in said[0] for word in asked)
    assert law.equations(None, moment)[0].numbers == ()
    other = f"{now.servo_state.model.mean_gain:.2f}" if name == "kalman" else f"{now.servo_state.damping:.4f}"
    assert any(other in numbers for numbers in said)
