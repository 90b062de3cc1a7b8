"""Places on the surface of an arm's links, from which its body points are chosen."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..mesh import Mesh
from ..robot import Robot

A_LINK, OF_THE_BASE = 80, 400  # places on each
ALL_OVER = 3_000  # places on each, where all of a body counts
NEAR_THE_ARM = 0.6  # of the arm's reach: farther off, a base is no part of it
MIN_BASE_PLACES = 24  # places on the base, the nearest if so few are near


@dataclass(frozen=True)
class Surface:
    """K places. link: (K,) as in `BodyPoints`; local, normal: (K, 3), m and unit vectors in that link's frame."""

    link: NDArray
    local: NDArray
    normal: NDArray

    def only(self, chosen: NDArray) -> "Surface":
        return Surface(self.link[chosen], self.local[chosen], self.normal[chosen])

    def at(self, T_base_links: NDArray) -> tuple[NDArray, NDArray]:
        """Places and normals in the base frame, (K, 3) each. T_base_links: (n + 1, 4, 4)."""
        T = T_base_links[self.link]
        turned = np.einsum("kij,kj->ki", T[:, :3, :3], self.local)
        return turned + T[:, :3, 3], np.einsum("kij,kj->ki", T[:, :3, :3], self.normal)


def sample(meshes: Mapping[int, Mesh], robot: Robot, rest: NDArray, first: int) -> Surface:
    """Even over each link. meshes: by link number; rest: (n,) rad; first: the number of the joint at which the arm
    begins to move."""
    found = _sampled(meshes, A_LINK, OF_THE_BASE)
    return found.only(_near(found, robot.link_frames(rest), first))


def whole(meshes: Mapping[int, Mesh], robot: Robot, rest: NDArray) -> NDArray:
    """(K, 3) m in the base frame, all over the body at rest (n,) rad."""
    return _sampled(meshes, ALL_OVER, ALL_OVER).at(robot.link_frames(rest))[0]


def _sampled(meshes: Mapping[int, Mesh], a_link: int, of_the_base: int) -> Surface:
    """So many places, even over each link."""
    rng = np.random.default_rng(0)
    link, local, normal = [], [], []
    for number, mesh in meshes.items():
        areas = mesh.area_faces
        if not areas.sum() > 0:
            continue
        count = a_link if number else of_the_base
        faces = rng.choice(len(areas), count, p=areas / areas.sum())
        weights = rng.dirichlet(np.ones(3), count)
        link.append(np.full(count, number))
        local.append(np.einsum("kc,kcx->kx", weights, mesh.triangles[faces]))
        normal.append(mesh.face_normals[faces])
    return Surface(np.concatenate(link), np.concatenate(local), np.concatenate(normal))


def _near(surface: Surface, T_base_links: NDArray, first: int) -> NDArray:
    """(K,) bool: of what does not move, only what is near the arm."""
    places, _ = surface.at(T_base_links)
    away = np.linalg.norm(places - T_base_links[first][:3, 3], axis=1)
    moves = surface.link >= first
    reach = away[moves].max() if moves.any() else away.max()
    still = np.sort(away[~moves])
    limit = max(NEAR_THE_ARM * reach, still[min(MIN_BASE_PLACES, len(still)) - 1] if len(still) else 0.0)
    return moves | (away <= limit)
