"""Triangle meshes of links: the file format of the shipped robots, and the intersection of a ray with an arm.

trimesh reads all other files. Loading it takes nearly as long as everything else that a server needs, so only a
user's own robot needs it.
"""

import json
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..geometry.arrays import Floats

HEADER, CHUNK = struct.Struct("<4sII"), struct.Struct("<I4s")  # magic, version, bytes in all; bytes, kind
VERTEX_TYPE, INDEX_TYPE = "<f4", "<u4"
PARALLEL_M2 = 1e-12  # determinant below which a ray lies in the plane of a triangle


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles of a surface."""

    vertices: Floats  # (V, 3) m
    faces: NDArray[np.int_]  # (F, 3) indices of vertices, counter-clockwise from outside

    @cached_property
    def triangles(self) -> Floats:
        """(F, 3, 3) corners of each face [m]."""
        return self.vertices[self.faces]

    @cached_property
    def face_normals(self) -> Floats:
        """(F, 3) unit vectors; 0 for a face without area."""
        return self._cross / np.where(self._twice_areas > 0, self._twice_areas, 1.0)[:, None]

    @cached_property
    def vertex_normals(self) -> Floats:
        """(V, 3) unit vectors: the mean of the faces at each vertex, weighted by their areas."""
        total = np.zeros_like(self.vertices)
        for corner in range(3):
            np.add.at(total, self.faces[:, corner], self._cross)
        return total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), np.finfo(float).tiny)

    @property
    def area_faces(self) -> Floats:
        """(F,) m²."""
        return self._twice_areas / 2

    @cached_property
    def bounds(self) -> Floats:
        """(2, 3) smallest and largest coordinates of the vertices [m]."""
        return np.array([self.vertices.min(0), self.vertices.max(0)])

    @cached_property
    def _cross(self) -> Floats:
        a, b, c = np.moveaxis(self.triangles, 1, 0)
        return np.cross(b - a, c - a)

    @cached_property
    def _twice_areas(self) -> Floats:
        return np.linalg.norm(self._cross, axis=1)


def read_glb(path: Path) -> dict[str, Mesh]:
    """Read meshes by name, from a file that assets/build_robots.py wrote: one primitive each, without materials."""
    content = path.read_bytes()
    size, _ = CHUNK.unpack_from(content, HEADER.size)
    begin = HEADER.size + CHUNK.size
    header, data = json.loads(content[begin : begin + size]), begin + size + CHUNK.size

    def array(accessor: int, kind: str) -> NDArray[np.number]:
        view = header["bufferViews"][header["accessors"][accessor]["bufferView"]]
        count = view["byteLength"] // np.dtype(kind).itemsize
        return np.frombuffer(content, kind, count, data + view.get("byteOffset", 0)).reshape(-1, 3)

    meshes = {}
    for mesh in header["meshes"]:
        (primitive,) = mesh["primitives"]
        vertices = array(primitive["attributes"]["POSITION"], VERTEX_TYPE)
        faces = array(primitive["indices"], INDEX_TYPE)
        meshes[mesh["name"]] = Mesh(vertices.astype(float), faces.astype(np.int64))
    return meshes


@dataclass(frozen=True, eq=False)
class SurfaceHit:
    """The point where a ray meets an arm."""

    distance: float  # along the ray [m]
    link: int  # 0 = base, i = moved by joint i
    local: Floats  # (3,) in that link's frame [m]


def first_hit(
    meshes: Mapping[int, Mesh], T_world_links: Floats, origin: Floats, direction: Floats
) -> SurfaceHit | None:
    """Intersect a ray with an arm, from either side of its surface.

    meshes: by link number, each in its link's frame [m]; T_world_links: (n + 1, 4, 4), the frames; origin, direction:
    (3,) m, the ray in the world. Returns the nearest intersection in front of the origin, if there is one.
    """
    direction = direction / np.linalg.norm(direction)
    found: SurfaceHit | None = None
    for link, mesh in meshes.items():
        R, t = T_world_links[link][:3, :3], T_world_links[link][:3, 3]
        local_origin, local_direction = (origin - t) @ R, direction @ R
        low, high = mesh.bounds
        centre, radius = (low + high) / 2 - local_origin, np.linalg.norm(high - low) / 2
        along = max(float(centre @ local_direction), 0.0)
        if np.linalg.norm(centre - along * local_direction) > radius:  # it misses the sphere around the mesh's box
            continue
        distance = ray_distances(mesh.triangles, local_origin, local_direction).min(initial=np.inf)
        if np.isfinite(distance) and (found is None or distance < found.distance):
            found = SurfaceHit(float(distance), link, local_origin + distance * local_direction)
    return found


def ray_distances(triangles: Floats, origin: Floats, direction: Floats) -> Floats:
    """Return the distance along a ray to each triangle, in lengths of its direction; inf if it misses.

    (F, 3, 3) m -> (F,). See Möller and Trumbore, Fast, minimum storage ray-triangle intersection, 1997.
    """
    corner = triangles[:, 0]
    a, b = triangles[:, 1] - corner, triangles[:, 2] - corner
    p = np.cross(direction, b)
    determinant = (a * p).sum(1)
    crosses = np.abs(determinant) > PARALLEL_M2
    inverse = 1 / np.where(crosses, determinant, 1.0)
    s = origin - corner
    q = np.cross(s, a)
    u, v, t = (s * p).sum(1) * inverse, q @ direction * inverse, (b * q).sum(1) * inverse
    return np.where(crosses & (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0), t, np.inf)
