"""Meshes of the shipped robots against trimesh, and rays against a sphere and a box."""

import numpy as np
import pytest
import trimesh
from viewimit.assets import ROOT

from viewimit.simulation.meshes import first_hit, ray_distances
from viewimit.simulation.robot import link_meshes, robot_names
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World


@pytest.mark.parametrize("robot", robot_names())
def test_a_shipped_robot_is_read_as_trimesh_reads_it(robot):
    expected = trimesh.load_scene(ROOT / "robots" / robot / f"{robot}.glb", process=False).geometry
    meshes = link_meshes(robot)
    assert {f"link{link}" for link in meshes} == set(expected)
    for link, mesh in meshes.items():
        same = expected[f"link{link}"]
        np.testing.assert_array_equal(mesh.vertices, same.vertices)
        np.testing.assert_array_equal(mesh.faces, same.faces)
        for name in ("triangles", "face_normals", "area_faces", "bounds"):
            np.testing.assert_allclose(getattr(mesh, name), getattr(same, name), atol=1e-12, err_msg=name)


RNG = np.random.default_rng(3)


def slab_distance(half, origin, direction):
    """To an axis-aligned box about the origin, by its three pairs of planes; inf where it is missed."""
    first, last = np.sort(np.stack([(-half - origin) / direction, (half - origin) / direction]), 0)
    near, far = first.max(), last.min()
    return np.inf if near > far or far < 0 else near if near > 0 else far


@pytest.mark.parametrize("origin", [(0.1, -3.0, 0.2), (0.0, 0.05, 0.1)], ids=["outside", "inside"])
def test_a_box_is_met_where_its_planes_are(origin):
    half, origin = np.array([0.3, 0.5, 0.2]), np.array(origin)
    box = trimesh.creation.box(2 * half)
    aims = RNG.uniform(-0.9, 0.9, (200, 3)) - origin
    found = np.array([ray_distances(np.asarray(box.triangles), origin, aim).min() for aim in aims])
    true = np.array([slab_distance(half, origin, aim) for aim in aims])
    np.testing.assert_allclose(found, true, rtol=1e-9)
    assert np.isfinite(true).any() and (np.isinf(true).any() or np.abs(origin).max() < 1)


def test_a_ray_at_a_shipped_point_meets_the_arm_there():
    """Points of the scene lie on the surface within 1.6 mm, on a link that the first of the cameras may not see."""
    world = World(load_scene("panda"))
    theta, meshes = np.radians(world.scene.start_deg), link_meshes("panda")
    frames = world.link_frames(theta, world.T_world_own)
    points = world.points_world(theta, world.T_world_own)
    met = 0
    for k, point in enumerate(points):
        outwards = point - frames[world.body.link[k]][:3, 3]
        hit = first_hit(meshes, frames, point + 0.05 * outwards / np.linalg.norm(outwards), -outwards)
        if hit is not None and hit.link == world.body.link[k]:
            met += 1
            assert np.linalg.norm(hit.local - world.body.local[k]) < 0.03
    assert met >= 7
