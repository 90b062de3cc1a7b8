"""The phases of the trust region: their transitions, the region's radius, and the ends of a run."""

from dataclasses import replace

import numpy as np
import pytest
from linear_world import LinearWorld

from viewimit import Session, Settings
from viewimit.servo import ServoStatus, TrustRegion, TrustRegionOptions
from viewimit.servo.observation import Visit
from viewimit.servo.trust_region import algorithm
from viewimit.servo.trust_region.algorithm import PHASES
from viewimit.servo.trust_region.rules import updated_region
from viewimit.servo.trust_region.state import Phase, Region, TrustRegionState

OPTIONS = TrustRegionOptions()
DEG = np.radians(1.0)


def visit(*posture_deg):
    return Visit(np.radians(posture_deg), np.zeros((5, 4)), np.ones((5, 2), bool))


def state_with(*visits, **fields):
    return TrustRegionState(visits, (), fields.pop("region", Region(25 * DEG)), 1.0, **fields)


def test_phases_follow_each_other_as_the_table_says_and_each_is_reached(monkeypatch):
    made = set()

    def recorded(phase, run):
        def phase_recorded(state, context):
            outcome = run(state, context)
            made.add((phase, outcome[0] if outcome[2] is None else "motion"))
            return outcome

        return phase_recorded

    table = {phase: (recorded(phase, run), after) for phase, (run, after) in PHASES.items()}
    monkeypatch.setattr(algorithm, "PHASES", table)
    cases = (
        *({}, {"swapped": 0.2}, {"noise_px": 0.5}, {"transfer": "linear"}, {"matched": False}),
        {"points": 16, "missing": 0.4, "frames": 1},
    )
    for changes in cases:
        Session(Settings(servo="trust-region", seed=2, **changes)).run(40)
    assert {phase for phase, _ in made} == set(Phase)
    assert all(after == "motion" or after in PHASES[phase][1] for phase, after in made)
    assert {phase for phase, after in made if after == "motion"} == set(Phase) - {Phase.PLAN}


@pytest.mark.parametrize(
    "step_deg, actual, radius_deg, rejected",
    [
        (22, 1.0, 50, 0),  # as predicted, by a full step: the region grows
        (20, 0.5, 25, 0),  # half of what was predicted: it stays
        (20, 0.2, 8, 0),  # little: 0.4 of the step
        (20, -0.5, 8, 0),  # E rose
        (5, 1.0, 25, 0),  # as predicted, well inside the region
        (0.9, -0.5, 0.5, 1),  # a short step did not reduce E: the smallest region, and one rejection
        (0.9, 0.2, 0.5, 0),
    ],
)
def test_the_radius_follows_actual_over_predicted_reduction(step_deg, actual, radius_deg, rejected):
    """Nocedal and Wright, Algorithm 4.1."""
    state = state_with(visit(0, 0), visit(step_deg, 0), region=Region(25 * DEG, predicted_reduction=2.0))
    region = updated_region(state, np.array([10.0, 10.0 - 2.0 * actual]), replace(OPTIONS, max_radius=60 * DEG))
    assert np.degrees(region.radius) == pytest.approx(radius_deg) and region.n_rejected == rejected
    assert region.predicted_reduction is None


def driven(servo, world, motions, moving=False):
    theta, state, steps = np.zeros(len(world.aim)), None, []
    for motion in range(motions):
        seen = world.observe(theta, motion)
        state = servo.start(seen) if state is None else state
        state = servo.retarget(state, seen) if moving and motion else state
        state, step = servo.step(state, seen, world.residuals)
        steps.append(step)
        if moving:
            world.aim = world.aim + 0.002
        elif not step.any():
            break
        theta = theta + step
    return state, np.array(steps)


def test_without_kinematics_no_motion_is_longer_than_images_are_predicted():
    """Far beyond the visits a Gaussian process predicts nothing: a restart goes there in several motions."""
    world = LinearWorld(2, np.random.default_rng(1), 9, limit=2.0)
    world.least[0, 0] = 30.0  # so that it searches elsewhere
    short = replace(OPTIONS, fit_kinematics_at=(), max_step=0.3)
    state, steps = driven(TrustRegion(short), world, 40)
    assert state.search.n_restarts > 0 and np.abs(steps).max() <= 0.3 + 1e-12


def test_while_the_demonstrator_keeps_moving_it_makes_no_motion_aside():
    """A verification would only leave the learner behind."""
    state, _ = driven(TrustRegion(), LinearWorld(2, np.random.default_rng(1), 9), 14, moving=True)
    assert state.search.n_verifications == 0 and state.phase is Phase.DESCEND
    still, _ = driven(TrustRegion(), LinearWorld(2, np.random.default_rng(1), 9), 14)
    assert still.search.n_verifications > 0 and still.status == ServoStatus.CONVERGED


def behind_deg(speed_deg, noise_px):
    """Mean distance from a demonstrator that makes a motion for each one of the learner, in three runs."""
    behind = []
    for k in range(3):
        rng = np.random.default_rng([3, k])
        shown, start = rng.uniform((25, -130), (65, -60)), rng.uniform((0, -180), (90, 0))
        way = rng.normal(size=2)
        settings = Settings(demonstrator_deg=tuple(shown), start_deg=tuple(start), seed=k, noise_px=noise_px)
        session = Session(settings)
        session.run(12)
        for _ in range(14):
            shown = np.clip(shown + speed_deg * way / np.abs(way).max(), (0, -180), (90, 0))
            session.pose(np.radians(shown))
            session.step()
            behind.append(np.abs(np.degrees(session.snapshot.theta) - shown).max())
    return np.mean(behind)


def test_a_learner_that_follows_is_one_motion_behind():
    assert behind_deg(speed_deg=1.0, noise_px=0.0) < 1.1


def test_where_the_demonstrator_moves_slowly_it_waits_and_makes_no_verification():
    """With verification motions meanwhile it would be 0.9° behind."""
    assert behind_deg(speed_deg=0.02, noise_px=0.25) < 0.4
