"""What the browser computes for lessons, computed by the library: the statements of the lessons are tested with it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from viewimit.app.lab.lessons.situation import Situation

from viewimit.analysis.landscape import Landscape, conflict_of_images, grid_axes
from viewimit.estimation.transfers import epipolar
from viewimit.estimation.transfers.epipolar import EpipolarTransfer
from viewimit.estimation.views import FourViews
from viewimit.geometry.affine import MIN_POINTS, centred
from viewimit.simulation.camera import Camera
from viewimit.simulation.robot import BodyPoints
from viewimit.simulation.world import World

Array = NDArray[np.float64]
MAP_STEP_DEG = 3.0
DEPTH_STEP_M = 1e-4  # of first derivatives of a projection
FEWEST = 4  # points: these fit any images
PLANE_SHARE = 0.1  # of the points' distances from a plane: exactly in it, rounding errors would make the map


def without_depth(situation: Situation) -> float:
    """E at the start, px², if all points of each arm were as far away as their middle: with affine cameras."""
    world, start = situation.world, situation.start
    demo = _affine_images(world.demo_cameras, world.points_world(start.theta_demo, world.T_world_demo))
    own = _affine_images(world.own_cameras, world.points_world(start.theta, world.T_world_own))
    views = FourViews(demo, own, np.ones((len(demo), 4), bool))
    return float(start.fit(views).conflict(views))


def _affine_images(cameras: Sequence[Camera], points: Array) -> Array:
    """(N, 4) px: projections to first order about the middle of points, (N, 3) m in the world."""
    middle, step = points.mean(0), DEPTH_STEP_M * np.eye(3)
    images = []
    for camera in cameras:
        near = camera.project(np.concatenate([middle + step, middle - step, middle[None]]).T, np.eye(4))[0].T
        slope = (near[:3] - near[3:6]) / (2 * DEPTH_STEP_M)
        images.append(near[6] + (points - middle) @ slope)
    return np.concatenate(images, 1)


# Few points, and points in a plane


@dataclass(frozen=True, eq=False)
class Matches:
    """Maps with some of the points only."""

    order: NDArray[np.int_]  # (N,) indices: the four that determine most first, then one after the other
    by_count: Mapping[int, Landscape]  # of the first 4, 5, … N of them, with conditions from 5 on
    plane: Landscape  # of all, pressed towards the plane in which the arm moves, with conditions


@cache
def matches(situation: Situation) -> Matches:
    """Compute the paper's E with fewer and fewer points, and with points near a plane."""
    world, start = situation.world, situation.start
    seen = np.flatnonzero(start.usable)
    order = seen[best_order(start.views.demo[seen])]
    by_count = {n: _landscape_of(world, start.theta_demo, order[:n]) for n in range(FEWEST, len(order) + 1)}
    flat = World(world.scene, body=pressed(world, start.theta_demo))
    return Matches(order, by_count, _landscape_of(flat, start.theta_demo, order))


def best_order(stereo: Array) -> NDArray[np.int_]:
    """Order points (N, 4) px in [l, r]: the four with the largest third singular value, then whichever makes it largest
    when it is added."""

    def depth(chosen: tuple[int, ...]) -> float:
        return float(np.linalg.svd(centred(stereo[list(chosen)])[1], compute_uv=False)[2])

    chosen = max(combinations(range(len(stereo)), FEWEST), key=depth)
    while len(chosen) < len(stereo):
        left = (k for k in range(len(stereo)) if k not in chosen)
        chosen = max(((*chosen, k) for k in left), key=depth)
    return np.array(chosen)


def _landscape_of(world: World, theta_demo: Array, points: NDArray[np.int_]) -> Landscape:
    """E of the paper's transfer with points (k,) only, k ≥ 4."""
    axes = grid_axes(world, MAP_STEP_DEG)
    demo, demo_visible = (array[points] for array in world.demo_images(theta_demo))
    own, own_visible = (array[..., points, :] for array in world.own_images((axes[0][:, None], axes[1])))
    if len(points) >= MIN_POINTS:
        return Landscape(axes, *conflict_of_images(epipolar.fit, demo, demo_visible, own, own_visible, True))
    views = FourViews(demo, own.reshape((-1,) + own.shape[-2:]), np.ones(1, bool))
    E = np.asarray(fit_few(views).conflict(views)).reshape(own.shape[:-2])
    return Landscape(axes, np.where(own_visible.all((-2, -1)) & demo_visible.all(), E, np.nan))


def fit_few(views: FourViews) -> EpipolarTransfer:
    """Fit the paper's transfer to four points as well, whose fundamental matrices fit any images exactly."""
    demo_mean, demo = centred(views.demo)
    own_mean, own = centred(views.own)
    batch = own.shape[:-2]
    f = epipolar.constraints(demo, own)
    matrix = epipolar.solve(f).transpose(2, 0, 1).reshape(batch + (4, 4))
    return EpipolarTransfer(matrix, demo_mean, own_mean, f.reshape((4, 5) + batch))


def pressed(world: World, theta: Array, share: float = PLANE_SHARE) -> BodyPoints:
    """Move the body points on their links, at theta (m,) rad, towards the plane in which the arm moves.

    share: what is left of their distances from it. Where all moving joints turn about one direction, the points stay
    as near to a plane.
    """
    frames = world.link_frames(theta, world.T_world_demo)
    axes = np.array([frames[k + 1, :3, :3] @ world.robot.joints[k].axis for k in world.scene.moving])
    normal = (axes * np.where(axes @ axes[0] < 0, -1.0, 1.0)[:, None]).sum(0)
    normal /= np.linalg.norm(normal)
    points = world.points_world(theta, world.T_world_demo)
    flat = points - (1 - share) * ((points - points.mean(0)) @ normal)[:, None] * normal
    T_world_link = frames[world.body.link]
    local = np.einsum("nji,nj->ni", T_world_link[:, :3, :3], flat - T_world_link[:, :3, 3])
    return BodyPoints(world.body.link, local)


def left_out_px(situation: Situation, theta: Array) -> Array:
    """Fit the lines of [l] in [L] to all points but one, for each: px from that point to its line, (N,).

    theta: (m,) rad, the learner's posture.
    """
    views = situation.world.look(situation.start.theta_demo, theta)
    found = []
    for k in range(len(views.demo)):
        rest = np.delete(np.arange(len(views.demo)), k)
        u = np.concatenate([views.demo_left, views.own_left], 1)
        mean = u[rest].mean(0)
        f = np.linalg.svd(u[rest] - mean)[2][-1]
        found.append(abs((u[k] - mean) @ f) / np.hypot(f[2], f[3]))
    return np.array(found)
