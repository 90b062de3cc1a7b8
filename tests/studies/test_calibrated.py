"""Calibrated visual servoing arrives if it is given the truth, and misses if its calibration is wrong."""

import calibrated
import numpy as np
import pytest
from calibrated import ORACLES, CalibratedServo, Oracle, estimate_posture, image_velocities

from viewimit.experiments.bench.engine import run_once
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World

LAWS = {"IBVS": calibrated.image_based, "PBVS": calibrated.position_based}
SETTINGS = Settings.paper(transfer="projective")
START, DEMONSTRATOR = (25, -45), (45, -90)


def ended(law, rotation_deg=0.0, seed=0, **changes):
    servo = CalibratedServo(Oracle(law, rotation_deg), [seed])
    session = Session(SETTINGS, servo=servo)
    servo.attach(session)
    session.change(demonstrator_deg=DEMONSTRATOR, start_deg=START, **changes)
    return session.run(100)


def error_deg(result):
    return np.abs(np.degrees(result.theta) - DEMONSTRATOR).max()


@pytest.mark.parametrize("name", LAWS)
def test_a_law_that_is_told_the_truth_arrives_and_rests(name):
    result = ended(LAWS[name])
    assert error_deg(result) < 0.1  # shorter motions are not made
    assert result.status == "settled" and result.motions <= 6  # 45° at most 25° a motion, and a few to correct


@pytest.mark.parametrize("name", LAWS)
def test_a_wrong_calibration_costs_degrees_and_a_worse_one_more(name):
    medians = [np.median([error_deg(ended(LAWS[name], turn, seed)) for seed in range(9)]) for turn in (0.0, 0.2, 1.0)]
    assert medians[0] < 0.1 < medians[1] < medians[2] and medians[2] > 1.0


def test_the_velocities_are_the_interaction_matrix_of_chaumette_and_hutchinson_times_the_arms_jacobian():
    """A point p on a link turns about a joint's axis a through o: dp = a x (p - o). A camera that stands still sees a
    point move with v as one that moves with -v sees it at rest: Eq. (11) of Part I, its columns of translation."""
    world, theta = World(load_scene("panda"), 16), np.radians(START)
    found, points = image_velocities(world, theta), world.points_world(theta, world.T_world_own)
    frames = world.link_frames(theta, world.T_world_own)
    for column, joint in enumerate(world.scene.moving):
        moved = np.cross(frames[joint + 1][:3, :3] @ world.robot.joints[joint].axis, points - frames[joint + 1][:3, 3])
        moved[world.body.link <= joint] = 0
        for side, camera in enumerate(world.own_cameras):
            R, t = camera.T_world_camera[:3, :3], camera.T_world_camera[:3, 3]
            x, y, Z = ((points - t) @ R).T
            x, y = x / Z, y / Z
            L = np.stack([[-1 / Z, 0 * Z, x / Z], [0 * Z, -1 / Z, y / Z]])  # (2, 3, N)
            expected = camera.lens.focal[0] * np.einsum("ijn,nj->ni", L, -moved @ R)
            np.testing.assert_allclose(found[:, 2 * side : 2 * side + 2, column], expected, rtol=1e-5, atol=1e-4)


@pytest.mark.parametrize("joints", [(2, 4), (1, 2, 3, 4, 5, 6, 7)])
def test_a_posture_is_found_from_its_exact_images_without_a_first_guess(joints):
    world = World(load_scene("panda", joints=joints), 16)
    (low, high), rest = np.transpose(world.scene.range_deg), np.array(world.scene.posture_deg)[world.scene.moving]
    near = 180 if len(joints) == 2 else 45  # of seven joints some postures look too much alike to be searched for
    for offset in np.random.default_rng(4).uniform(-near, near, (4, len(joints))):
        theta = np.radians(np.clip(rest + offset, low, high))
        images, visible = world.demo_images(tuple(theta))
        found = estimate_posture(world, world.demo_images, images, visible.all(-1), None)
        np.testing.assert_allclose(found, theta, atol=np.radians(0.01))


def test_an_oracle_runs_in_any_case_of_the_comparison(compared, exact):
    for name in ORACLES:
        run = run_once(compared[1], exact, name, 5, 0, 60)
        assert run.servo == name and run.status == "settled" and not run.claimed
        assert run.error_deg < (0.5 if "1deg" not in name else 20)


def test_with_too_few_points_in_sight_it_says_that_it_makes_no_progress():
    assert ended(LAWS["IBVS"], missing=0.95, seed=3).status in ("no-progress", "too-few-points")
