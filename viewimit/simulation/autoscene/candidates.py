"""Find places on an arm that could become body points of a world: all four images show them, most of them often."""

from collections.abc import Mapping
from itertools import product

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..meshes import Mesh, first_hit
from ..robot import BodyPoints, link_meshes
from ..world import World
from .surface import Surface, choose_layout, parts_of, sample_arm, visible_fraction

MAX_PLACES = 64
MAX_DEPTH_M = 2e-3  # of a visible place under the surface
GRID = 0.0, 0.5, 1.0  # of the range of a joint
MAX_GRID_JOINTS = 2  # all combinations of GRID; with more joints, the given posture only

Floats = NDArray[np.float64]


def find_candidates(world: World, theta: ArrayLike) -> BodyPoints:
    """Return candidates, rounded to 0.1 mm, that no surface hides at a posture (m,) rad of both arms."""
    scene, robot = world.scene, world.robot
    meshes = link_meshes(scene.robot)
    theta = np.asarray(theta, float)
    rest = np.array(world.joint_angles(theta), float)
    surface = sample_arm(meshes, robot, rest, int(scene.moving[0]) + 1)
    postures = [theta]
    if len(scene.moving) <= MAX_GRID_JOINTS:
        grid = np.array(list(product(GRID, repeat=len(scene.moving))))
        postures += list(scene.lower + (scene.upper - scene.lower) * grid)
    views = [_visibility(world, surface, posture) for posture in postures]
    kept = np.all([inside for inside, _ in views], axis=0) & (views[0][1] == 1)
    surface, visible = surface.only(kept), np.mean([fraction for _, fraction in views], axis=0)[kept]
    places, part = surface.at(robot.link_frames(rest))[0], parts_of(surface.link, list(scene.moving_joints))
    chosen = np.array([], int)
    if len(places):
        chosen = choose_layout(surface, places, visible, part, MAX_PLACES)
    found = BodyPoints(surface.link[chosen], surface.local[chosen].round(4))
    unhidden = _is_unhidden(world, found, theta, meshes)
    return BodyPoints(found.link[unhidden], found.local[unhidden])


def _is_unhidden(world: World, points: BodyPoints, theta: Floats, meshes: Mapping[int, Mesh]) -> NDArray[np.bool_]:
    """Whether each of four rays reaches each point, (K,). This is exact; `visible_fraction` is approximate."""
    found = np.ones(len(points), bool)
    for T_world_base, cameras in ((world.T_world_demo, world.demo_cameras), (world.T_world_own, world.own_cameras)):
        frames = world.link_frames(theta, T_world_base)
        T = frames[points.link]
        places = np.einsum("kij,kj->ki", T[:, :3, :3], points.local) + T[:, :3, 3]
        for camera in cameras:
            eye = camera.T_world_camera[:3, 3]
            for k in np.flatnonzero(found):
                hit = first_hit(meshes, frames, eye, places[k] - eye)
                found[k] = hit is None or hit.distance > np.linalg.norm(places[k] - eye) - MAX_DEPTH_M
    return found


def _visibility(world: World, surface: Surface, theta: Floats) -> tuple[NDArray[np.bool_], Floats]:
    """Whether each place is inside all four images, (K,), and the fraction of them in which it is not hidden, (K,)."""
    places, normals = surface.at(world.link_frames(theta, np.eye(4)))
    inside, fractions = np.ones(len(places), bool), []
    for T_world_base, cameras in ((world.T_world_demo, world.demo_cameras), (world.T_world_own, world.own_cameras)):
        for camera in cameras:
            inside &= camera.project(places.T, T_world_base)[1]
        fractions.append(visible_fraction(list(cameras), T_world_base, places, normals))
    return inside, np.mean(fractions, axis=0)
