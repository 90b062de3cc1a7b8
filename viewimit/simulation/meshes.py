"""Triangles of a link's surface, and the files that the shipped robots' are in.

trimesh reads all other files. To load it, with what it finds beside it, takes nearly as long as all else that a server
needs, so that only a robot of one's own asks for it.
"""

import json
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

HEADER, CHUNK = struct.Struct("<4sII"), struct.Struct("<I4s")  # magic, version, bytes in all; bytes, kind
FLOAT, INDEX = "<f4", "<u4"  # of a vertex, of a face


@dataclass(frozen=True, eq=False)
class Mesh:
    """vertices: (V, 3) m; faces: (F, 3) indices of them, counter-clockwise from outside."""

    vertices: NDArray
    faces: NDArray

    @cached_property
    def triangles(self) -> NDArray:
        """(F, 3, 3) m"""
        return self.vertices[self.faces]

    @cached_property
    def face_normals(self) -> NDArray:
        """(F, 3), of length 1; 0 of a face without area."""
        return self._across / np.where(self._twice_areas > 0, self._twice_areas, 1.0)[:, None]

    @property
    def area_faces(self) -> NDArray:
        """(F,) m²"""
        return self._twice_areas / 2

    @cached_property
    def bounds(self) -> NDArray:
        """(2, 3) m: the least and the largest coordinates of its vertices."""
        return np.array([self.vertices.min(0), self.vertices.max(0)])

    @cached_property
    def _across(self) -> NDArray:
        a, b, c = np.moveaxis(self.triangles, 1, 0)
        return np.cross(b - a, c - a)

    @cached_property
    def _twice_areas(self) -> NDArray:
        return np.linalg.norm(self._across, axis=1)


def read_glb(path: Path) -> dict[str, Mesh]:
    """By name, as assets/build_robots.py writes them: a primitive each, of vertices and of faces alone."""
    content = path.read_bytes()
    size, _ = CHUNK.unpack_from(content, HEADER.size)
    begin = HEADER.size + CHUNK.size
    told, data = json.loads(content[begin : begin + size]), begin + size + CHUNK.size

    def array(accessor: int, kind: str) -> NDArray:
        found = told["accessors"][accessor]
        view = told["bufferViews"][found["bufferView"]]
        count = view["byteLength"] // np.dtype(kind).itemsize
        return np.frombuffer(content, kind, count, data + view.get("byteOffset", 0)).reshape(-1, 3)

    meshes = {}
    for mesh in told["meshes"]:
        (primitive,) = mesh["primitives"]
        vertices, faces = array(primitive["attributes"]["POSITION"], FLOAT), array(primitive["indices"], INDEX)
        meshes[mesh["name"]] = Mesh(vertices.astype(float), faces.astype(np.int64))
    return meshes


# Where a ray meets the surface of an arm: a triangle a face, by Möller and Trumbore (1997).

PARALLEL = 1e-12  # m², of a determinant: the ray lies in the triangle's plane


@dataclass(frozen=True, eq=False)
class SurfaceHit:
    """distance: m along the ray; link: 0 = base, i = moved by joint i; local: (3,) m in that link's frame."""

    distance: float
    link: int
    local: NDArray


def first_hit(
    meshes: Mapping[int, Mesh], T_world_links: NDArray, origin: NDArray, direction: NDArray
) -> SurfaceHit | None:
    """The nearest place in front where a ray meets an arm, from whichever side; None if it meets none.

    meshes: by link number, in the link's frame, m; T_world_links: (n + 1, 4, 4); origin (3,) m, direction (3,).
    """
    direction = direction / np.linalg.norm(direction)
    found: SurfaceHit | None = None
    for link, mesh in meshes.items():
        R, t = T_world_links[link][:3, :3], T_world_links[link][:3, 3]
        here, towards = (origin - t) @ R, direction @ R
        if not _near(mesh, here, towards):
            continue
        distance = distances(mesh.triangles, here, towards).min(initial=np.inf)
        if np.isfinite(distance) and (found is None or distance < found.distance):
            found = SurfaceHit(float(distance), link, here + distance * towards)
    return found


def _near(mesh: Mesh, origin: NDArray, direction: NDArray) -> bool:
    """Whether a ray, of direction 1, meets the sphere about a mesh's box."""
    low, high = mesh.bounds
    away, radius = (low + high) / 2 - origin, np.linalg.norm(high - low) / 2
    aside = away - max(float(away @ direction), 0.0) * direction
    return bool(np.linalg.norm(aside) <= radius)


def distances(triangles: NDArray, origin: NDArray, direction: NDArray) -> NDArray:
    """Along the ray to each triangle, in lengths of its direction; inf where it misses.

    triangles: (F, 3, 3) m → (F,)
    """
    corner = triangles[:, 0]
    a, b = triangles[:, 1] - corner, triangles[:, 2] - corner
    across = np.cross(direction, b)
    determinant = (a * across).sum(1)
    crosses = np.abs(determinant) > PARALLEL
    inverse = 1 / np.where(crosses, determinant, 1.0)
    away = origin - corner
    along = np.cross(away, a)
    u, v, far = (away * across).sum(1) * inverse, along @ direction * inverse, (b * along).sum(1) * inverse
    return np.where(crosses & (u >= 0) & (v >= 0) & (u + v <= 1) & (far > 0), far, np.inf)
