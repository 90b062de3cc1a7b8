"""Places that could become body points: on the arm, in all four images, hidden by nothing, in every part of it."""

import numpy as np
import pytest

from viewimit.simulation.autoscene.candidates import MAX_PLACES, find_candidates
from viewimit.simulation.meshes import first_hit
from viewimit.simulation.robot import link_meshes
from viewimit.simulation.scene import load_scene, scene_names
from viewimit.simulation.scene_writing import saved_scene
from viewimit.simulation.world import World


@pytest.mark.parametrize("name, joints", [("panda", None), ("iiwa", None), ("panda", (1, 2, 3, 4, 5, 6, 7))])
def test_they_are_on_the_arm_and_every_camera_sees_them(name, joints):
    scene = load_scene(name, joints=joints)
    world, meshes = World(scene), link_meshes(name)
    theta = np.radians(scene.start_deg)
    found = find_candidates(world, theta)
    assert 20 < len(found) <= MAX_PLACES
    seen = World(scene, body=found)
    assert seen.demo_images(theta)[1].all() and seen.own_images(theta)[1].all()
    for k in range(len(found)):  # no vertex of its link is nearer than its faces are large
        assert np.linalg.norm(meshes[found.link[k]].vertices - found.local[k], axis=1).min() < 0.12
    for cameras, T in ((world.demo_cameras, world.T_world_demo), (world.own_cameras, world.T_world_own)):
        frames, places = world.link_frames(theta, T), seen.points_world(theta, T)
        for camera in cameras:
            eye = camera.T_world_camera[:3, 3]
            for place in places:
                hit = first_hit(meshes, frames, eye, place - eye)
                assert hit is None or np.linalg.norm(eye - place) - hit.distance < 3e-3


def test_what_does_not_move_and_what_every_joint_moves_have_their_share():
    scene = load_scene("panda")
    link = find_candidates(World(scene), np.radians(scene.start_deg)).link
    parts = np.bincount(np.searchsorted(scene.moving_joints, link, side="right"))
    assert len(parts) == 3 and parts.min() >= 6


@pytest.mark.parametrize("name", scene_names())
def test_a_scene_with_points_by_hand_is_the_same_after_its_file(name, tmp_path):
    points = tuple((k % 8, 0.0123 * k, -1e-5 / (k + 1), 0.1) for k in range(11))
    scene = load_scene(name, body_points=points)
    assert scene.points == {"11": points}
    path = tmp_path / "mine.toml"
    path.write_text(saved_scene(scene, "by hand"))
    assert load_scene(path) == scene


def test_points_by_hand_are_checked_as_those_of_a_file():
    for wrong, why in (((8, 0.0, 0.0, 0.0), "links are 0 … 7"), ((1, 0.0, np.nan, 0.0), "not all numbers are finite")):
        with pytest.raises(ValueError, match=why):
            load_scene("panda", body_points=[wrong] * 5)
