"""The contract of every servo in `SERVOS`: what it may see, which motions it may ask for, and what it must remember."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linear_world import LinearWorld

from viewimit.loop import simulated_robot as looking
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.servo import SERVOS, LastMotion, ServoStatus
from viewimit.servo.servo import Servo

NOT_RIGID = [name for name, servo in SERVOS.items() if not servo.rigid]  # that need no body of rigid links
AT_REST = {status for status in ServoStatus if status.is_at_rest}


def drive(name, world, motions, noise_px=0.0, hidden=(), limits=None):
    """Yield (state, observation, next state, displacement) of a run in a linear world."""
    servo, theta, state = SERVOS[name], np.zeros(len(world.aim)), None
    for motion in range(motions):
        seen = replace(world.seen(theta, motion), noise_px=noise_px)
        seen = seen if limits is None else replace(seen, lower=limits[0], upper=limits[1])
        if motion in hidden:
            seen = replace(seen, own=np.full_like(seen.own, np.nan), seen=np.zeros_like(seen.seen), E=np.nan)
        state = servo.start(seen) if state is None else state
        after, displacement = servo.step(state, seen, world.residuals)
        yield state, seen, after, displacement
        if not displacement.any():
            return
        state, theta = after, theta + displacement


@pytest.mark.parametrize("name", SERVOS)
@given(joints=st.sampled_from([1, 2, 3, 7]), seed=st.integers(0, 2**16), noise_px=st.sampled_from([0.0, 0.2]))
@settings(max_examples=8, deadline=None)
def test_every_answer_is_a_finite_displacement_inside_the_limits(name, joints, seed, noise_px):
    rng = np.random.default_rng(seed)
    world, limits = LinearWorld(joints, rng, 9), np.sort(rng.uniform(-1, 1, (2, joints)), axis=0) + [[-1e-3], [1e-3]]
    limits = np.minimum(limits[0], 0.0), np.maximum(limits[1], 0.0)
    for _, seen, state, displacement in drive(name, world, 25, noise_px, limits=limits):
        assert displacement.shape == (joints,) and np.isfinite(displacement).all()
        end = seen.displacement + displacement
        assert (end >= seen.lower - 1e-12).all() and (end <= seen.upper + 1e-12).all()
        assert isinstance(state.probe, bool) and isinstance(ServoStatus(state.status), ServoStatus)
        assert state.status not in AT_REST or not displacement.any() or name.startswith("gradient")


@pytest.mark.parametrize("name", SERVOS)
def test_a_step_has_no_side_effects(name):
    """The same state and observation give the same answer again, however often the servo was asked in between."""
    world = LinearWorld(2, np.random.default_rng(3), 9)
    asked = list(drive(name, world, 8, noise_px=0.1))
    for state, seen, _, displacement in reversed(asked):
        np.testing.assert_array_equal(SERVOS[name].step(state, seen, world.residuals)[1], displacement)


@pytest.mark.parametrize("name", NOT_RIGID)
def test_a_target_that_moved_is_found_without_new_probes_and_within_the_limits(name):
    world, servo = LinearWorld(2, np.random.default_rng(4), 9), SERVOS[name]
    *_, (_, seen, state, displacement) = drive(name, world, 40)
    world.aim = world.aim + (0.1, -0.15)
    theta = seen.displacement + displacement
    seen = world.seen(theta, 41)
    state = servo.retarget(state, seen)
    assert state.status == ServoStatus.MOVING and not state.probe
    for motion in range(41, 47):
        state, step = servo.step(state, world.seen(theta, motion), world.residuals)
        theta = theta + step
        assert (np.abs(theta) <= world.limit + 1e-12).all()
        assert not state.probe
    if not SERVOS[name].slow:
        assert np.degrees(np.abs(theta - world.aim)).max() < 0.5


@pytest.mark.parametrize("name", SERVOS)
def test_a_look_at_which_no_point_is_seen_makes_no_servo_fail(name):
    world = LinearWorld(2, np.random.default_rng(6), 9)
    with np.errstate(invalid="ignore"):
        asked = list(drive(name, world, 7, hidden=(4,)))
    assert all(np.isfinite(displacement).all() for _, seen, _, displacement in asked if np.isfinite(seen.E))


@pytest.mark.parametrize("name", SERVOS)
def test_equations_and_words_exist_for_every_state_of_a_run(name):
    method, world = SERVOS[name], LinearWorld(2, np.random.default_rng(5), 9)
    motion = LastMotion(1.0, np.ones((9, 2), bool), np.zeros(2), np.array((0.1, 0.0)), ServoStatus.MOVING)
    assert method.equations(None, motion) and isinstance(method.servo, Servo) and method.title and method.limitations
    for _, _, state, _ in drive(name, world, 20):
        status = ServoStatus(state.status)
        assert method.equations(state, replace(motion, status=status))
        assert isinstance(method.describe_status(state, status), str)


@pytest.mark.parametrize("noise_px", [0.0, 0.1])
@pytest.mark.parametrize("name", SERVOS)
def test_a_loop_written_from_the_docstring_runs(name, noise_px):
    """`residuals(own)`, E, images, displacements: all a law needs."""
    servo, world = SERVOS[name], LinearWorld(2, np.random.default_rng(5), 7)
    theta, found = np.zeros(2), []
    state = servo.start(replace(world.seen(theta, 0), noise_px=noise_px))
    for motion in range(40):
        seen = replace(world.seen(theta, motion), noise_px=noise_px)
        found.append(seen.E)
        state, displacement = servo.step(state, seen, world.residuals)
        assert displacement.shape == (2,) and isinstance(state.probe, bool)
        if not displacement.any():
            break
        theta = theta + displacement
    if name == "broyden":  # the gradients' options are of another scale than this world's
        assert state.status == "settled" and min(found) < 0.01 * found[0]


def hide_truth(session):
    """Only the images of the demonstrator stay; its posture becomes NaN."""
    demo, theta_demo = session.observer.demo, session.snapshot.theta_demo
    session.observer.demo = lambda settings, theta, look=None: demo(settings, theta_demo, look)
    session.history.replace(replace(session.snapshot, theta_demo=np.full(2, np.nan)))


@pytest.mark.parametrize("transfer", ["epipolar", "projective"])
@pytest.mark.parametrize("servo", SERVOS)
def test_no_servo_sees_the_demonstrators_posture(servo, transfer):
    settings = Settings.paper(servo=servo, transfer=transfer, noise_px=0.2, start_deg=(70, -140))
    plain, poisoned = Session(settings), Session(settings)
    hide_truth(poisoned)
    for _ in range(12):
        assert plain.step() == poisoned.step()
        np.testing.assert_array_equal(plain.snapshot.theta, poisoned.snapshot.theta)
    assert np.isnan(poisoned.snapshot.theta_demo).all() and plain.snapshot.motion > 2


class Recorder:
    """A servo law that remembers what it answered."""

    def __init__(self, law):
        self.law, self.answers = law, []

    def start(self, seen):
        return self.law.start(seen)

    def step(self, state, seen, residuals):
        state, displacement = self.law.step(state, seen, residuals)
        self.answers.append((seen, displacement))
        return state, displacement


@pytest.mark.parametrize("junk, seed", [(1e6, 0), (np.nan, 1)])
@pytest.mark.parametrize("servo", SERVOS)
def test_points_that_are_not_seen_are_not_known(servo, seed, junk, monkeypatch):
    settings = Settings.paper(servo=servo, transfer="linear", points=16, missing=0.1, seed=seed)
    plain = Session(settings)
    for _ in range(12):
        plain.step()
    disturb = looking.disturb

    def spoilt(*images):
        points, visible = disturb(*images)
        return np.where(np.repeat(visible, 2, -1), points, junk), visible

    monkeypatch.setattr(looking, "disturb", spoilt)
    blind = Session(settings)
    for _ in range(12):
        blind.step()
    assert not plain.snapshot.views.visible.all() and plain.snapshot.motion > 2
    assert [moment.E for moment in blind.history] == [moment.E for moment in plain.history]
    np.testing.assert_array_equal(blind.snapshot.theta, plain.snapshot.theta)


@pytest.mark.parametrize("servo", SERVOS)
def test_a_servo_is_told_displacements_since_the_start_not_postures(servo, monkeypatch):
    recorder, start = Recorder(SERVOS[servo]), np.radians((70, -140))
    monkeypatch.setitem(SERVOS, servo, recorder)
    session = Session(Settings.paper(servo=servo, start_deg=(70, -140)))
    for _ in range(5):
        session.step()
    for moment, (seen, _) in zip(session.history, recorder.answers):
        np.testing.assert_allclose(seen.displacement, moment.theta - start, atol=1e-12)
        np.testing.assert_allclose(seen.lower, np.radians((0, -180)) - start)
        np.testing.assert_allclose(seen.upper, np.radians((90, 0)) - start)


@pytest.mark.parametrize("start", [(0, 0), (90, -180)])
@pytest.mark.parametrize("servo", SERVOS)
def test_joint_limits_are_kept_by_the_servo_itself(servo, start, monkeypatch):
    recorder = Recorder(SERVOS[servo])
    monkeypatch.setitem(SERVOS, servo, recorder)
    session = Session(Settings.paper(servo=servo, transfer="linear", start_deg=start, demonstrator_deg=(2, -175)))
    for _ in range(60):
        session.step()
    assert len(recorder.answers) == 60
    for seen, displacement in recorder.answers:
        assert (seen.displacement + displacement >= seen.lower - 1e-12).all()
        assert (seen.displacement + displacement <= seen.upper + 1e-12).all()
