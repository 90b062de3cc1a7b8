"""Places on the surface of an arm's links, from which its body points are chosen."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..camera import Camera
from ..meshes import Mesh
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


# Which places on an arm become its body points: seen from the head, a share for each part, far from each other.

CELL_PX = 6.0  # of a grid in an image: in each the nearest places are in front
BEHIND = 0.03  # of the distance to a camera, that a place in front may be nearer
USUALLY = 0.6  # of the looks, in which a place must be seen to be chosen
MIN_PLACES_PER_PART = 6  # places a part, of which the most often seen are taken where fewer are seen usually


def seen_from(cameras: list[Camera], T_world_base: NDArray, places: NDArray, normals: NDArray) -> NDArray:
    """(K,) share of the cameras that see each place: its surface turned to them, and nothing else's before it.

    places, normals: (K, 3) in the base frame."""
    share = np.zeros(len(places))
    for camera in cameras:
        image, inside = camera.project(places.T, T_world_base)
        eye = np.linalg.inv(T_world_base) @ np.append(camera.T_world_camera[:3, 3], 1.0)
        away = places - eye[:3]
        distance = np.linalg.norm(away, axis=1)
        facing = (away * normals).sum(1) < 0
        cell = np.floor(np.where(inside, image, -1.0) / CELL_PX).astype(int)
        _, index = np.unique(cell, axis=1, return_inverse=True)
        nearest = np.full(index.max() + 1, np.inf)
        np.minimum.at(nearest, index.ravel(), distance)
        share += inside & facing & (distance < (1 + BEHIND) * nearest[index.ravel()])
    return share / len(cameras)


def parts_of(link: NDArray, moving: list[int]) -> NDArray:
    """(K,) the part of the arm that each place is on: 0 = base, then one for each joint that moves."""
    return np.searchsorted(np.array(moving), link, side="right")


def layout(surface: Surface, places: NDArray, seen: NDArray, part: NDArray, count: int) -> NDArray:
    """(count,) indices of places, base first, tip last. places: (K, 3) m in the base frame at rest; seen, part: (K,).

    Parts take turns, and each takes the place that is farthest from all those chosen before."""
    candidates = {number: _usual(seen, np.flatnonzero(part == number)) for number in np.unique(part)}
    middle = np.median(places, axis=0)
    apart = np.linalg.norm(places - middle, axis=1) * 1e-3  # the first is the outermost of its part
    chosen: list[int] = []
    while len(chosen) < count:
        for number in sorted(candidates, reverse=True):
            left = candidates[number]
            if len(chosen) < count and len(left):
                best = int(left[np.argmax(apart[left])])
                distance = np.linalg.norm(places - places[best], axis=1)
                apart = distance if not chosen else np.minimum(apart, distance)
                candidates[number] = left[left != best]
                chosen.append(best)
        if not any(len(left) for left in candidates.values()):
            break
    return np.array(sorted(chosen, key=lambda k: (surface.link[k], k)))


def _usual(seen: NDArray, among: NDArray) -> NDArray:
    """Those that are seen usually, or else those seen most."""
    usual = among[seen[among] >= USUALLY]
    return (
        usual
        if len(usual) >= MIN_PLACES_PER_PART
        else among[np.argsort(-seen[among], kind="stable")][: 4 * MIN_PLACES_PER_PART]
    )
