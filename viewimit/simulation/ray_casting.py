"""Where a ray meets the surface of an arm: a triangle a face, by Möller and Trumbore (1997)."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .mesh import Mesh

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
