"""Pictures show what the rays of their samples meet, points where Camera.project puts them, and what PyBullet shows."""

import msgspec
import numpy as np
import pytest
from viewimit.assets import ROOT

from viewimit.estimation.views import VIEWS
from viewimit.experiments.paper import fig8
from viewimit.geometry.distortion import RadialDistortion
from viewimit.geometry.rigid import look_rotation, rigid_transform
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.sensing.detection import detect
from viewimit.simulation.camera import Camera, Lens
from viewimit.simulation.depth_buffer import Balls, DepthBuffer, Triangles
from viewimit.simulation.meshes import first_hit, ray_distances
from viewimit.simulation.rendering import SEARCHED_WIDTH, RenderedEyes, Room, Skin, Studio
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


def test_neighbouring_triangles_leave_no_gap_and_a_sample_has_one_colour():
    grid = np.stack(np.meshgrid(np.linspace(-2, 2, 9), np.linspace(-2, 2, 9), [2.0]), -1).reshape(-1, 3)
    first = (np.arange(8)[:, None] * 9 + np.arange(8)).ravel()
    faces = np.concatenate(
        [np.stack([first, first + 9, first + 1], -1), np.stack([first + 1, first + 9, first + 10], -1)]
    )
    camera = Camera(32, 24, Lens((16.0, 16.0), (16.0, 12.0)), np.eye(4))  # corners and edges lie on samples
    buffer = DepthBuffer(camera, 1)
    buffer.add_triangles(Triangles(grid, faces, np.tile([0, 0, -1.0], (81, 1)), np.ones(81)))
    np.testing.assert_allclose(buffer.inverse_depth, 0.5, rtol=1e-6)
    assert len(np.unique(buffer.colours)) == 1


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
        buffer.add_balls(Balls(centre[None], np.array([[1.0, 0, 0]]), 0.03))
        rows, columns = np.nonzero(buffer.inverse_depth)
        errors.append((np.array([columns.mean(), rows.mean()]) + 0.5) / 2 - image)
        assert len(rows) == pytest.approx(4 * np.pi * (0.03 / depth) ** 2 * np.prod(lens.focal), rel=0.3)
        assert 0 < 1 / buffer.inverse_depth.max() - (depth - 0.03) < 2e-3  # at the sample nearest to that point
    assert np.abs(np.mean(errors, 0)).max() < 0.04 and np.std(errors, 0).max() < 0.1


def test_what_reaches_too_near_or_behind_a_camera_is_left_out():
    for depth, shown in ((-1.0, False), (0.03, False), (0.06, False), (0.2, True)):
        buffer = DepthBuffer(SMALL, 2)
        middle = POSE[:3, 3] + depth * POSE[:3, 2]
        buffer.add_balls(Balls(middle[None], np.ones((1, 3)), 0.02))
        assert buffer.inverse_depth.any() == shown
    corners = POSE[:3, 3] + np.array([[-1, 0, -1.0], [1, 0, 3], [0, 1, 3]]) @ POSE[:3, :3].T
    for faces in ([[0, 1, 2]], [[0, 2, 1]]):
        buffer.add_triangles(Triangles(corners, np.array(faces), np.ones((3, 3)), np.ones(3)))
    assert np.count_nonzero(buffer.inverse_depth) < 100  # of the ball alone


def test_the_room_has_a_floor_walls_and_pedestals():
    scene = load_scene("panda")
    camera = World(scene).demo_cameras[0]
    inverse_depth, _ = Room(scene).seen_by(camera)
    points = camera.T_world_camera[:3, 3] + rays_of(camera, 2) / inverse_depth[..., None]
    low = np.array([-2.5, -3.2, 0.0])  # 2.5 m beyond the bases and the head
    high = np.array([0.9 + 2.5, 3.2, 3.0])
    seen = inverse_depth > 0
    planes = np.abs(np.concatenate([points - low, points - high], -1))[seen]
    on_pedestal = (np.abs(points[..., :2] - (0.9, 0.7)) <= 0.16 + 1e-9).all(-1)[seen]
    assert (planes.min(-1)[~on_pedestal] < 1e-9).all() and 0.001 < on_pedestal.mean() < 0.1
    assert (points[seen] >= low - 1e-9).all() and (points[seen] <= high + 1e-9).all()


@pytest.mark.parametrize("name", ["panda", "iiwa", "panda-toed", "panda-verged"])
def test_markers_are_detected_where_they_are_in_pybullets_pictures(name):
    """Its balls have flat faces, which makes them 4 % narrower: a ball at the limit of what is taken may be lost."""
    pytest.importorskip("pybullet")
    from bullet_pictures import BulletStudio

    scene, markers, world, studio = studio_of(name)
    bullet, rng, away, found = BulletStudio(scene), np.random.default_rng(4), [], []
    for _ in range(3):
        postures = rng.uniform(scene.lower, scene.upper, (2, 2))
        for camera in (*world.demo_cameras, *world.own_cameras):
            pictures = [each.picture(camera, *postures) for each in (studio, bullet)]
            ours, theirs = (detect(picture, markers.hue_deg, SEARCHED_WIDTH) for picture in pictures)
            both = ours.found & theirs.found
            away.append((ours.points - theirs.points)[both])
            found.append([both.sum(), (ours.found ^ theirs.found).sum()])
            shown = studio.depth_m(camera, *postures)
            behind, _ = Room(scene).seen_by(camera)
            drawn = 1 / shown > behind
            there = bullet.depth_m(camera, *postures)
            shifted = [np.roll(there, shift, (0, 1)) for shift in np.ndindex(3, 3)]  # outlines differ by a sample
            shifted = [np.roll(each, (-1, -1), (0, 1)) for each in shifted]
            apart = np.min([np.abs(each - shown) for each in shifted], 0)[drawn]
            assert (apart < 0.02).mean() > 0.998  # so the same things are hidden
    coordinate = np.concatenate(away)
    assert np.sqrt((coordinate**2).mean()) < 0.05 and np.abs(coordinate.mean(0)).max() < 0.01
    same, other = np.sum(found, 0)
    assert same > 180 and other < 0.07 * same


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


def test_a_distorted_lens_distorts_the_picture():
    scene = load_scene("panda")
    bent = msgspec.structs.replace(scene.head.left, distortion=(-0.08, 0.01))
    eyes = RenderedEyes(msgspec.structs.replace(scene, head=msgspec.structs.replace(scene.head, left=bent, right=bent)))
    postures = np.radians([[45.0, -90.0], [25.0, -45.0]])
    (points, seen), truth = eyes.demo_images(postures[0]), eyes.world.look(*postures).demo
    away = np.linalg.norm((points - truth).reshape(-1, 2, 2), axis=-1)[seen]
    assert np.median(away) < 0.12 and away.max() < 1.5 and seen.sum() > 20
    straight = World(scene, body=eyes.markers.body).look(*postures).demo
    assert np.linalg.norm((truth - straight).reshape(-1, 2, 2), axis=-1)[seen].max() > 2


def test_several_postures_are_looked_at_one_by_one(eyes):
    first, second = np.radians([20.0, 50.0]), np.radians([-100.0, -30.0])
    points, seen = eyes.own_images((first[:, None], second))
    assert points.shape == (2, 2, len(eyes.world.body), 4)
    one, seen_one = eyes.own_images((first[1], second[0]))
    np.testing.assert_array_equal(points[1, 0], one)
    np.testing.assert_array_equal(seen[1, 0], seen_one)
    assert all(eyes.pictures[view].dtype == np.uint8 and eyes.pictures[view].shape == (240, 640, 3) for view in VIEWS)


def test_only_detections_reach_a_session():
    session = Session(Settings.paper(sensor="rendered", transfer="projective", servo="trust-region"))
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


def test_fig_8_on_pictures_has_the_postures_of_its_grid():
    grid = np.array([20.0, 45.0]), np.array([-90.0, -60.0, -30.0])
    found = fig8.run(Settings.paper(sensor="rendered"), grid_deg=grid)
    assert found.usable.shape == (2, 3) and (found.sag_deg == 0).all()  # arms without mass
    assert all(np.isfinite(surface.landscape.E).sum() > 3 for surface in found.surfaces.values())
