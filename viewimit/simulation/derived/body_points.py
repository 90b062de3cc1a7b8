"""Which places on an arm become its body points: seen from the head, a share for each part, far from each other."""

import numpy as np
from numpy.typing import NDArray

from ..camera import Camera
from .surface import Surface

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
    return usual if len(usual) >= MIN_PLACES_PER_PART else among[np.argsort(-seen[among], kind="stable")][: 4 * MIN_PLACES_PER_PART]
