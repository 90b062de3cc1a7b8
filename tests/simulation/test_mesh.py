"""Meshes of the shipped robots are what trimesh reads and makes of them."""

import numpy as np
import pytest
import trimesh
from viewimit.assets import ROOT

from viewimit.simulation.meshes import Mesh
from viewimit.simulation.robot import link_meshes, robot_names


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


def test_a_face_without_area_has_no_normal():
    mesh = Mesh(np.eye(3), np.array([[0, 1, 2], [0, 1, 1]]))
    np.testing.assert_allclose(mesh.face_normals, [np.full(3, 1 / np.sqrt(3)), np.zeros(3)])
    np.testing.assert_allclose(mesh.area_faces, [np.sqrt(3) / 2, 0])
