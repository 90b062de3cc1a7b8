"""Pictures show what the rays of their samples meet, points where Camera.project puts them, and what PyBullet shows."""

import numpy as np
import pytest
from viewimit.assets import ROOT

from viewimit.estimation.views import VIEWS
from viewimit.geometry.distortion import RadialDistortion
from viewimit.geometry.rigid import look_rotation, rigid_transform
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.simulation.camera import Camera, Lens
from viewimit.simulation.depth_buffer import DepthBuffer, Triangles
from viewimit.simulation.meshes import first_hit, ray_distances
from viewimit.simulation.rendering import RenderedEyes, Skin, Studio
from viewimit.simulation.robot import Markers, link_meshes, load_markers
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World

POSE = rigid_transform(look_rotation([1.0, 0.3, -0.4]), [0.1, -0.2, 1.5])
SMALL = Camera(32, 24, Lens((20.0, 22.0), (15.5, 12.25)), POSE)
LENSES = [
    Lens((256.0, 256.0), (320.0, 120.0)),
    Lens((300.0, 280.0), (301.0, 140.5)),
    Lens((256.0, 256.0), (320.0, 120.0), RadialDistortion(-0.1, 0.02)),
]


@pytest.fixture(scope="module")
def eyes():
    return RenderedEyes(load_scene("panda"))


def studio_of(name):
    scene = load_scene(name)
    markers = load_markers(scene.robot)
    world = World(scene, body=markers.body)
    return scene, markers, world, Studio(world, markers)


def rays_of(camera, samples):
    """Of all samples, with depth 1: (samples height, samples width, 3)"""
    rows, columns = ((np.arange(samples * size) + 0.5) / samples for size in (camera.height, camera.width))
    return camera.ray(np.stack(np.meshgrid(columns, rows), -1))


def test_each_sample_shows_the_nearest_triangle_that_its_ray_meets():
    """The oracle intersects each ray with each triangle. Those turned away are left out of it, too."""
    rng = np.random.default_rng(0)
    middles = POSE[:3, 3] + rng.uniform((-1, -0.8, 1), (1, 0.8, 4), (40, 3)) @ POSE[:3, :3].T
    corners = middles[:, None] + rng.normal(0, 0.4, (40, 3, 3))
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    towards = ((POSE[:3, 3] - corners[:, 0]) * normals).sum(-1) > 0
    ahead = ((corners - POSE[:3, 3]) @ POSE[:3, 2] > 0.05).all(-1)
    buffer = DepthBuffer(SMALL, 2)
    faces = np.arange(120).reshape(40, 3)
    buffer.add_triangles(Triangles(corners.reshape(-1, 3), faces, np.repeat(normals, 3, 0), np.ones(120)))
    rays = rays_of(SMALL, 2)
    drawn = corners[towards & ahead]
    expected = np.array([[1 / ray_distances(drawn, POSE[:3, 3], ray).min() for ray in row] for row in rays])
    np.testing.assert_allclose(buffer.inverse_depth, expected, rtol=1e-6, atol=1e-12)
    assert 0.1 < (expected > 0).mean() < 0.99 and len(drawn) > 10


@pytest.mark.parametrize("name", ["panda", "iiwa"])
def test_an_arm_is_drawn_where_rays_meet_it_from_either_side(name):
    """So leaving out the triangles that are turned away leaves no hole: the shipped meshes are closed."""
    scene, _, world, _ = studio_of(name)
    meshes, camera, rng = link_meshes(scene.robot), world.own_cameras[0], np.random.default_rng(2)
    frames = world.link_frames(rng.uniform(scene.lower, scene.upper), world.T_world_own)
    buffer = DepthBuffer(camera, 1)
    buffer.add_triangles(Skin(meshes, Markers(0.02, ())).at(frames))
    depth, rays, origin = buffer.inverse_depth, rays_of(camera, 1), camera.T_world_camera[:3, 3]
    rows, columns = np.nonzero(depth)
    missed = 0
    for _ in range(250):
        row, column = rng.integers((rows.min() - 3, columns.min() - 3), (rows.max() + 3, columns.max() + 3))
        if not (0 <= row < 240 and 0 <= column < 640):
            continue
        ray = rays[row, column]
        hit = first_hit(meshes, frames, origin, ray)
        expected = 0.0 if hit is None else np.linalg.norm(ray) / hit.distance
        missed += abs(depth[row, column] - expected) > 1e-5 * expected + 1e-9
    assert missed <= 1  # a ray along an edge


@pytest.mark.parametrize("lens", LENSES)
def test_a_ball_is_drawn_where_the_camera_projects_it(lens):
    """Means over many: a picture's own grain is 0.05 px. A ball near the border looks like an ellipse."""
    camera, rng, errors = Camera(640, 240, lens, POSE), np.random.default_rng(3), []
    for _ in range(30):
        image, depth = rng.uniform((200, 40), (440, 200)), rng.uniform(0.9, 1.6)
        centre = POSE[:3, 3] + depth * camera.ray(image)
        buffer = DepthBuffer(camera, 2)
        buffer.add_balls(centre[None], np.array([[1.0, 0, 0]]), 0.03)
        rows, columns = np.nonzero(buffer.inverse_depth)
        errors.append((np.array([columns.mean(), rows.mean()]) + 0.5) / 2 - image)
        assert len(rows) == pytest.approx(4 * np.pi * (0.03 / depth) ** 2 * np.prod(lens.focal), rel=0.3)
        assert 0 < 1 / buffer.inverse_depth.max() - (depth - 0.03) < 2e-3  # at the sample nearest to that point
    assert np.abs(np.mean(errors, 0)).max() < 0.04 and np.std(errors, 0).max() < 0.1


def test_only_detections_reach_a_session():
    session = Session(Settings.paper(sensor="rendered", transfer="projective", servo="likelihood"))
    now = session.snapshot
    found = session.eyes.detections
    np.testing.assert_array_equal(now.views.visible, np.stack([found[view].found for view in VIEWS], -1))
    np.testing.assert_array_equal(now.views.own, np.concatenate([found["L"].points, found["R"].points], -1))
    assert session.step() and np.isfinite(session.snapshot.E)


def test_the_learner_arrives_by_pictures(ask_json):
    _, result = ask_json("imitate", "--sensor", "rendered", "--start", "35,-60", "--max-motions", 60)
    assert result["error_deg"] < 1


def test_pictures_need_a_robot_with_markers(ask, tmp_path):
    urdf = tmp_path / "mine.urdf"
    urdf.write_text((ROOT / "robots/panda/panda.urdf").read_text())
    status, _, err = ask("imitate", "--sensor", "rendered", "--robot", urdf)
    assert status == 2 and "--sensor" in err and "iiwa and panda" in err
