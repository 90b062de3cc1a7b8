"""Pictures show points where Camera.project puts them; arms with weight sag, obey and repeat themselves."""

import tempfile
from pathlib import Path

import numpy as np
import pytest

pybullet = pytest.importorskip("pybullet")
pytest.importorskip("cv2")

from viewimit.estimation.views import VIEWS  # noqa: E402
from viewimit.geometry.rigid import look_rotation, rigid_transform  # noqa: E402
from viewimit.loop.session import Session  # noqa: E402
from viewimit.loop.settings import Settings  # noqa: E402
from viewimit.simulation.camera import Camera, Lens  # noqa: E402
from viewimit.simulation.physics import Arm, connect, write_urdf  # noqa: E402
from viewimit.simulation.rendering import LIGHT, SAMPLES, RenderedEyes, Studio, opengl_matrices  # noqa: E402
from viewimit.simulation.robot import load_markers  # noqa: E402
from viewimit.simulation.scene import load_scene  # noqa: E402


@pytest.fixture(scope="module")
def eyes():
    return RenderedEyes(load_scene("panda"))


@pytest.fixture(scope="module")
def arm():
    scene = load_scene("panda")
    with tempfile.TemporaryDirectory() as folder:
        return Arm(write_urdf(scene, load_markers("panda"), Path(folder)))


@pytest.fixture(scope="module")
def studio():
    scene = load_scene("panda")
    with tempfile.TemporaryDirectory() as folder:
        return Studio(scene, write_urdf(scene, load_markers("panda"), Path(folder)))


@pytest.mark.parametrize("focal, centre", [((256.0, 256.0), (320.0, 120.0)), ((300.0, 280.0), (301.0, 140.5))])
def test_a_sphere_is_drawn_where_the_camera_projects_it(focal, centre):
    """Means over many: a picture's own grain is 0.05 px."""
    pose = rigid_transform(look_rotation([1.0, 0.3, -0.4]), [0.1, -0.2, 1.5])
    camera, client, rng = Camera(640, 240, Lens(focal, centre), pose), connect(), np.random.default_rng(3)
    view, projection = opengl_matrices(camera, SAMPLES)
    shape = client.createVisualShape(client.GEOM_SPHERE, radius=0.03, rgbaColor=(1, 0, 0, 1))
    ball = client.createMultiBody(0, -1, shape)
    errors = []
    for _ in range(30):
        image, depth = rng.uniform((200, 40), (440, 200)), rng.uniform(0.9, 1.6)
        ray = pose[:3, :3] @ np.append((image - centre) / focal, 1.0)
        client.resetBasePositionAndOrientation(ball, pose[:3, 3] + depth * ray, (0, 0, 0, 1))
        how = {"renderer": client.ER_TINY_RENDERER, **LIGHT}
        pixels = client.getCameraImage(SAMPLES * 640, SAMPLES * 240, view, projection, **how)[2]
        pixels = np.reshape(pixels, (SAMPLES * 240, SAMPLES * 640, 4)).astype(int)
        rows, columns = np.nonzero(pixels[..., 0] - pixels[..., 1] > 30)
        errors.append((np.array([columns.mean(), rows.mean()]) + 0.5) / SAMPLES - image)
    assert np.abs(np.mean(errors, 0)).max() < 0.03 and np.std(errors, 0).max() < 0.1


def test_a_picture_is_the_mean_over_the_nearest_of_arms_and_room_along_each_ray(eyes, studio):
    eyes.own_images(np.radians([25.0, -25.0]))
    studio.pose(eyes.theta["lr"], eyes.theta["LR"])
    camera = eyes.world.own_cameras[0]
    view, projection = opengl_matrices(camera, SAMPLES)
    layers = []
    for client in (studio.arms, studio.room):
        how = {"renderer": client.ER_TINY_RENDERER, **LIGHT}
        _, _, colours, depth, _ = client.getCameraImage(SAMPLES * 640, SAMPLES * 240, view, projection, **how)
        layers.append((np.reshape(colours, (240 * SAMPLES, -1, 4)), np.reshape(depth, (240 * SAMPLES, -1))))
    (arms, near), (room, far) = layers
    rays = np.where((near < far)[..., None], arms, room)[..., :3].reshape(240, SAMPLES, 640, SAMPLES, 3)
    eyes.look("L")
    np.testing.assert_array_equal(eyes.pictures["L"], np.floor(rays.mean((1, 3)) + 0.5))
    assert 0.02 < (near < far).mean() < 0.5


def test_detected_middles_are_those_of_the_balls(eyes):
    rng, scene = np.random.default_rng(1), eyes.world.scene
    for _ in range(3):
        demo, own = rng.uniform(scene.lower, scene.upper, (2, 2))
        (l_r, seen_l_r), (L_R, seen_L_R) = eyes.demo_images(demo), eyes.own_images(own)
        truth = eyes.world.look(demo, own)
        for points, seen, real in ((l_r, seen_l_r, truth.demo), (L_R, seen_L_R, truth.own)):
            away = np.linalg.norm((points - real).reshape(-1, 2, 2), axis=-1)[seen]
            assert np.median(away) < 0.12 and away.max() < 1.5  # no ball is taken for another
            assert 0.4 < seen.mean() < 1 and np.isnan(points[~np.repeat(seen, 2, -1)]).all()
        assert (seen_l_r.all(-1) & seen_L_R.all(-1)).sum() >= 6


def test_several_postures_are_looked_at_one_by_one(eyes):
    first, second = np.radians([20.0, 50.0]), np.radians([-100.0, -30.0])
    points, seen = eyes.own_images((first[:, None], second))
    assert points.shape == (2, 2, len(eyes.world.body), 4)
    one, seen_one = eyes.own_images((first[1], second[0]))
    np.testing.assert_array_equal(points[1, 0], one)
    np.testing.assert_array_equal(seen[1, 0], seen_one)
    assert all(eyes.pictures[view].dtype == np.uint8 and eyes.pictures[view].shape == (240, 640, 3) for view in VIEWS)


def test_an_arm_sags_and_obeys_and_repeats_itself(arm):
    start, goal = np.radians([25.0, -25.0]), np.radians([45.0, -90.0])
    reached = arm.drive(start, goal)
    sag = np.degrees(reached - goal)
    assert 0.02 < np.abs(sag).max() < 0.5 and sag[0] > 0  # joint 2 leans forwards
    np.testing.assert_array_equal(arm.drive(start, goal), reached)
    np.testing.assert_allclose(arm.drive(np.radians([80.0, -150.0]), goal), reached, atol=np.radians(0.01))
    np.testing.assert_allclose(arm.drive(reached, goal), reached, atol=np.radians(0.01))


def test_only_detections_reach_a_session():
    session = Session(Settings.paper(sensor="rendered", transfer="projective", servo="trust-region"))
    now = session.snapshot
    found = session.eyes.detections
    np.testing.assert_array_equal(now.views.visible, np.stack([found[view].found for view in VIEWS], -1))
    np.testing.assert_array_equal(now.views.own, np.concatenate([found["L"].points, found["R"].points], -1))
    assert session.step() and np.isfinite(session.snapshot.E)
    assert np.abs(session.snapshot.theta - session.snapshot.commanded).max() > 0  # what it was told is not where it is


def test_the_learner_arrives_by_pictures(ask_json):
    _, result = ask_json("imitate", "--sensor", "rendered", "--start", "35,-60", "--max-motions", 60)
    assert result["error_deg"] < 5


def test_pictures_need_a_robot_with_markers(ask, tmp_path):
    urdf = tmp_path / "mine.urdf"
    urdf.write_text((Path(__file__).parents[2] / "assets/robots/panda/panda.urdf").read_text())
    status, _, err = ask("imitate", "--sensor", "rendered", "--robot", urdf)
    assert status == 2 and "--sensor" in err and "iiwa and panda" in err


@pytest.mark.parametrize("package, extra", [("pybullet", "pybullet"), ("cv2", "opencv")])
def test_missing_packages_are_reported(ask, monkeypatch, package, extra):
    import importlib.util

    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == package else find(name))
    monkeypatch.setattr("viewimit.simulation.eyes.pybullet_has_wheel", lambda: True)
    status, _, err = ask("imitate", "--sensor", "rendered")
    assert status == 2 and f"pip install 'viewimit[{extra}]'" in err
    assert Session(Settings()).snapshot.transfer is not None
