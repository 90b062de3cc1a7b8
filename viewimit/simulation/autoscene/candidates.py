"""Places on an arm that could become body points of a world: all four images show them, most of them usually."""

from collections.abc import Mapping
from itertools import product

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..meshes import Mesh, first_hit
from ..robot import BodyPoints, link_meshes
from ..world import World
from .surface import Surface, layout, parts_of, sample, seen_from

MOST = 64  # places
UNDER = 2e-3  # m, that a place may lie under what is seen
AXIS = 0.0, 0.5, 1.0  # of the range of a joint, where it is looked at
MOST_MOVING = 2  # joints, with all combinations of these; with more, at the posture given alone


def candidates(world: World, theta: ArrayLike) -> BodyPoints:
    """Rounded to 0.1 mm. theta: (m,) rad, a posture of both arms in which nothing hides them from any camera."""
    scene, robot = world.scene, world.robot
    meshes = link_meshes(scene.robot)
    rest = np.array(world.joint_angles(np.asarray(theta, float)), float)
    surface = sample(meshes, robot, rest, int(scene.moving[0]) + 1)
    postures = [np.asarray(theta, float)]
    if len(scene.moving) <= MOST_MOVING:
        grid = np.array(list(product(AXIS, repeat=len(scene.moving))))
        postures += list(scene.lower + (scene.upper - scene.lower) * grid)
    looks = [_seen(world, surface, posture) for posture in postures]
    now = np.all([within for within, _ in looks], axis=0) & (looks[0][1] == 1)
    surface, usual = surface.only(now), np.mean([share for _, share in looks], axis=0)[now]
    places, part = surface.at(robot.link_frames(rest))[0], parts_of(surface.link, list(scene.moving_joints))
    chosen = layout(surface, places, usual, part, MOST) if len(places) else np.array([], int)
    found = BodyPoints(surface.link[chosen], surface.local[chosen].round(4))
    bare = _bare(world, found, np.asarray(theta, float), meshes)
    return BodyPoints(found.link[bare], found.local[bare])


def _bare(world: World, points: BodyPoints, theta: NDArray, meshes: Mapping[int, Mesh]) -> NDArray:
    """(K,) whether no surface hides them from any of the four cameras: exactly, where places near tell it roughly."""
    found = np.ones(len(points), bool)
    for T_world_base, cameras in ((world.T_world_demo, world.demo_cameras), (world.T_world_own, world.own_cameras)):
        frames = world.link_frames(theta, T_world_base)
        T = frames[points.link]
        places = np.einsum("kij,kj->ki", T[:, :3, :3], points.local) + T[:, :3, 3]
        for camera in cameras:
            eye = camera.T_world_camera[:3, 3]
            for k in np.flatnonzero(found):
                hit = first_hit(meshes, frames, eye, places[k] - eye)
                found[k] = hit is None or hit.distance > np.linalg.norm(places[k] - eye) - UNDER
    return found


def _seen(world: World, surface: Surface, theta: NDArray) -> tuple[NDArray, NDArray]:
    """(K,) whether a place is within all four images, and the share of them in which nothing hides it."""
    places, normals = surface.at(world.link_frames(theta, np.eye(4)))
    within, shares = np.ones(len(places), bool), []
    for T_world_base, cameras in ((world.T_world_demo, world.demo_cameras), (world.T_world_own, world.own_cameras)):
        for camera in cameras:
            within &= camera.project(places.T, T_world_base)[1]
        shares.append(seen_from(list(cameras), T_world_base, places, normals))
    return within, np.mean(shares, axis=0)
