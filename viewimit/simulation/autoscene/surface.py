"""Sample places on the surfaces of an arm's links, and choose its body points among them."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...geometry.arrays import Floats
from ..camera import Camera
from ..meshes import Mesh
from ..robot import BodyPoints, Robot

LINK_SAMPLES, BASE_SAMPLES = 80, 400
BODY_SAMPLES = 3_000  # for each link, to find collisions
MAX_BASE_DISTANCE = 0.6  # of the arm's length: farther parts of the base do not belong to the arm
MIN_BASE_PLACES = 24  # the nearest ones, if fewer are near
CELL_PX = 6.0  # of a grid in an image: the nearest places of a cell hide the others
DEPTH_TOL = 0.03  # of the distance to a camera, by which a visible place may lie behind the nearest one
MIN_VISIBLE_FRACTION = 0.6  # of the views, for a place to be chosen
MIN_PLACES_PER_PART = 6  # if fewer are visible so often, the most visible ones are used

Ints = NDArray[np.int_]


@dataclass(frozen=True)
class Surface:
    """K places on the surface of an arm."""

    link: Ints  # (K,) as in `BodyPoints`
    local: Floats  # (K, 3) in that link's frame [m]
    normal: Floats  # (K, 3) unit vectors in that frame

    def and_also(self, other: "Surface") -> "Surface":
        """Return its places, and then those of another surface."""
        return Surface(*(np.concatenate(both) for both in zip(vars(self).values(), vars(other).values())))

    def only(self, chosen: NDArray[np.bool_]) -> "Surface":
        """Return the chosen places, (K,)."""
        return Surface(self.link[chosen], self.local[chosen], self.normal[chosen])

    def at(self, T_base_links: Floats) -> tuple[Floats, Floats]:
        """Return places and normals in the base frame, (K, 3) each, given the frames of the links, (n + 1, 4, 4)."""
        R = T_base_links[self.link, :3, :3]
        return BodyPoints(self.link, self.local).at(T_base_links), np.einsum("kij,kj->ki", R, self.normal)


def sample_arm(meshes: Mapping[int, Mesh], robot: Robot, rest: Floats, first: int) -> Surface:
    """Sample places evenly over each link, and over the base near the arm.

    rest: posture, (n,) rad; first: number, from 1, of the first joint that moves.
    """
    surface = sample_links(meshes)
    frames = robot.link_frames(rest)
    places, _ = surface.at(frames)
    distance = np.linalg.norm(places - frames[first][:3, 3], axis=1)
    moves = surface.link >= first
    length = distance[moves].max() if moves.any() else distance.max()
    still = np.sort(distance[~moves])
    nearest = still[min(MIN_BASE_PLACES, len(still)) - 1] if len(still) else 0.0
    return surface.only(moves | (distance <= max(MAX_BASE_DISTANCE * length, nearest)))


def sample_body(meshes: Mapping[int, Mesh], robot: Robot, rest: Floats) -> Floats:
    """Sample places all over the body at a posture (n,) rad: (K, 3) m in the base frame."""
    return _sample(meshes, BODY_SAMPLES, BODY_SAMPLES).at(robot.link_frames(rest))[0]


def sample_links(meshes: Mapping[int, Mesh]) -> Surface:
    """Sample places evenly over each link and over the base."""
    return _sample(meshes, LINK_SAMPLES, BASE_SAMPLES)


def _sample(meshes: Mapping[int, Mesh], per_link: int, on_base: int) -> Surface:
    rng = np.random.default_rng(0)
    link, local, normal = [np.empty(0, int)], [np.empty((0, 3))], [np.empty((0, 3))]
    for number, mesh in meshes.items():
        areas = mesh.area_faces
        if not areas.sum() > 0:
            continue
        count = per_link if number else on_base
        faces = rng.choice(len(areas), count, p=areas / areas.sum())
        weights = rng.dirichlet(np.ones(3), count)
        link.append(np.full(count, number))
        local.append(np.einsum("kc,kcx->kx", weights, mesh.triangles[faces]))
        normal.append(mesh.face_normals[faces])
    return Surface(np.concatenate(link), np.concatenate(local), np.concatenate(normal))


def visible_fraction(cameras: list[Camera], T_world_base: Floats, places: Floats, normals: Floats) -> Floats:
    """Return the fraction of the cameras that see each place: facing the camera and not hidden.

    (K, 3) m places and (K, 3) normals in the base frame -> (K,).
    """
    count = np.zeros(len(places))
    for camera in cameras:
        image, inside = camera.project(places.T, T_world_base)
        eye = np.linalg.inv(T_world_base) @ np.append(camera.T_world_camera[:3, 3], 1.0)
        ray = places - eye[:3]
        distance = np.linalg.norm(ray, axis=1)
        facing = (ray * normals).sum(1) < 0
        cell = np.floor(np.where(inside, image, -1.0) / CELL_PX).astype(int)
        _, index = np.unique(cell, axis=1, return_inverse=True)
        nearest = np.full(index.max() + 1, np.inf)
        np.minimum.at(nearest, index.ravel(), distance)
        count += inside & facing & (distance < (1 + DEPTH_TOL) * nearest[index.ravel()])
    return count / len(cameras)


def parts_of(link: Ints, moving: list[int]) -> Ints:
    """Return the part of the arm on which each place is, (K,): 0 = base, then one for each moving joint."""
    return np.searchsorted(np.array(moving), link, side="right")


def choose_layout(surface: Surface, places: Floats, visible: Floats, part: Ints, count: int) -> Ints:
    """Choose body points far from each other, with a share for each part of the arm.

    The parts take turns. Each takes the place that is farthest from all those chosen before. places: (K, 3) m in the
    base frame at rest; visible: (K,), fraction of the views that show each; part: (K,), from `parts_of`. Returns
    indices of places, base first, tip last; fewer than count if there are no more places.
    """
    candidates = {number: _most_visible(visible, np.flatnonzero(part == number)) for number in np.unique(part)}
    middle = np.median(places, axis=0)
    spacing = np.linalg.norm(places - middle, axis=1) * 1e-3  # the first choice is the outermost place of its part
    chosen: list[int] = []
    while len(chosen) < count:
        for number in sorted(candidates, reverse=True):
            left = candidates[number]
            if len(chosen) < count and len(left):
                best = int(left[np.argmax(spacing[left])])
                distance = np.linalg.norm(places - places[best], axis=1)
                spacing = distance if not chosen else np.minimum(spacing, distance)
                candidates[number] = left[left != best]
                chosen.append(best)
        if not any(len(left) for left in candidates.values()):
            break
    return np.array(sorted(chosen, key=lambda k: (surface.link[k], k)))


def _most_visible(visible: Floats, among: Ints) -> Ints:
    often = among[visible[among] >= MIN_VISIBLE_FRACTION]
    if len(often) >= MIN_PLACES_PER_PART:
        return often
    return among[np.argsort(-visible[among], kind="stable")][: 4 * MIN_PLACES_PER_PART]
