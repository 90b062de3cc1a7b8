"""Shapes in 3-D are seen, lit and shaded from outside only, so all of them are closed and face outwards."""

import numpy as np
import pytest
import trimesh

from viewimit.simulation import scene_geometry
from viewimit.simulation.robot import link_meshes, robot_names

RADIUS, HEIGHT = 0.2, 0.3  # m, of a pedestal's plate and of all of it
SHAPES = {
    "pedestal": scene_geometry.pedestal(HEIGHT),
    "stand": scene_geometry.stand(1.0),
    "box": scene_geometry.box((0.1, 0.2, 0.3)),
    "octahedron": scene_geometry.octahedron(0.02),
}


def welded(vertices, faces):
    places, of_vertex = np.unique(np.round(vertices, 6), axis=0, return_inverse=True)
    mesh = trimesh.Trimesh(places, of_vertex.ravel()[faces], process=False)
    mesh.update_faces(mesh.nondegenerate_faces())
    return mesh


@pytest.mark.parametrize("name", SHAPES)
def test_a_shape_is_closed_and_faces_outwards(name):
    mesh = welded(*SHAPES[name])
    assert mesh.is_watertight and mesh.is_winding_consistent
    assert mesh.volume > 0


def first_met(mesh, origins, ways):
    """(k,) face that each ray meets first, -1 for none; by Möller and Trumbore's intersection."""
    a, ab, ac = mesh.triangles[:, 0], *np.moveaxis(mesh.triangles[:, 1:] - mesh.triangles[:, :1], 1, 0)
    p = np.cross(ways[:, None], ac)
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = 1 / (ab * p).sum(-1)
        u = ((origins[:, None] - a) * p).sum(-1) * scale
        q = np.cross(origins[:, None] - a, ab)
        v = (ways[:, None] * q).sum(-1) * scale
        far = np.where((u >= 0) & (v >= 0) & (u + v <= 1), (ac * q).sum(-1) * scale, np.inf)
    return np.where(np.isfinite(far.min(1)), far.argmin(1), -1)


@pytest.mark.parametrize("robot", robot_names())
def test_a_link_that_is_seen_from_outside_shows_its_outside(robot):
    """Nearly all that is met first faces who looks: through cracks between shells one sees others from inside."""
    for mesh in link_meshes(robot).values():
        places = trimesh.creation.icosphere(subdivisions=3).vertices
        aims = mesh.triangles.mean(1)[:: max(len(mesh.faces) // 10, 1)]
        ways = (aims[:, None] - 2 * places[::13]).reshape(-1, 3)
        met = first_met(mesh, np.tile(2 * places[::13], (len(aims), 1)), ways)
        facing = (ways * mesh.face_normals[met]).sum(1) < 0
        assert (met >= 0).mean() > 0.95
        assert facing[met >= 0].mean() > 0.98
