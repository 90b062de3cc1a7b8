"""What the browser computes for lessons, computed by the library: tests compare answers and measures with it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from viewimit.app.lab.lessons.situation import Situation

from viewimit.analysis.construction import CROSSING
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
NEARER = (-0.3, 0)  # m back, sideways
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


# Two cameras at one arm, and their lines


def two_cameras(situation: Situation) -> tuple[Camera, Camera]:
    """[l], and [L] carried to the demonstrator, which it sees as [L] sees the learner in the same posture."""
    world = situation.world
    first, second = world.demo_cameras[0], world.own_cameras[0]
    carried = world.T_world_demo @ np.linalg.inv(world.T_world_own) @ second.T_world_camera
    return first, replace(second, T_world_camera=carried)


def dollied(camera: Camera, target: Array, times: float) -> Camera:
    """A camera so many times as far from a target, whose picture is so many times as large."""
    T = camera.T_world_camera.copy()
    T[:3, 3] = target + times * (T[:3, 3] - target)
    focal = tuple(times * np.array(camera.lens.focal))
    at = project(camera, target)
    centre = tuple((at + times * (np.array(camera.lens.centre) - at)).tolist())
    return replace(camera, T_world_camera=T, lens=replace(camera.lens, focal=focal, centre=centre))


def project(camera: Camera, points: Array) -> Array:
    """(…, 3) m in the world -> (…, 2) px."""
    flat = np.atleast_2d(points).T
    return camera.project(flat, np.eye(4))[0].T.reshape(np.shape(points)[:-1] + (2,))


def along_ray(camera: Camera, point: Array, shares: Array) -> Array:
    """(k, 3) m: places on the camera's ray of a point, by their share of its distance."""
    centre = camera.T_world_camera[:3, 3]
    return centre + np.asarray(shares)[:, None] * (point - centre)


def straightness(points: Array) -> float:
    """px by which points (k, 2) leave their best line, the largest."""
    centre = points - points.mean(0)
    return float(np.abs(centre @ np.linalg.svd(centre)[2][-1]).max())


def ray_angles(situation: Situation, times: float) -> tuple[float, float]:
    """Largest angle, degrees, between the lines of three points' rays in the second picture, and px from the arm's
    middle to the epipole."""
    points = situation.world.points_world(situation.start.theta_demo, situation.world.T_world_demo)
    first, second = (dollied(camera, points.mean(0), times) for camera in two_cameras(situation))
    epipole = project(second, first.T_world_camera[:3, 3])
    images = project(second, points)
    away = images - epipole
    angles = np.degrees(np.arctan2(away[:, 1], away[:, 0]))
    return float(np.ptp(angles)), float(np.linalg.norm(images.mean(0) - epipole))


def lines_in_L(situation: Situation, point: int) -> Array:
    """(2, 3) px: the epipolar lines of a point from [l] and from [r], of length 1 normals."""
    lines = situation.start.epipolar_lines(point)
    assert lines is not None
    found = lines[CROSSING[0]]
    return found / np.hypot(found[:, 0], found[:, 1])[:, None]


# Arrows and ways


def arrows(situation: Situation) -> Array:
    """(N, 2, 2) px from diamonds to dots, in L and R."""
    return situation.start.e.reshape(-1, 2, 2)


def ways(situation: Situation) -> Array:
    """(N, 2, 2) px from dots to the ghost's, in L and R."""
    goal, _ = situation.world.own_images(situation.start.theta_demo)
    return (goal - situation.start.views.own).reshape(-1, 2, 2)


def cosine(situation: Situation, points: Array | slice = slice(None)) -> float:
    """Of some points' arrows, followed from dot to diamond, with the way to the ghost."""
    back, way = -arrows(situation)[points], ways(situation)[points]
    return float((back * way).sum() / np.sqrt((back**2).sum() * (way**2).sum()))


# The demonstrator carried across the room


def carried_to(situation: Situation, back_m: float, sideways_m: float, turned_deg: float = 0.0) -> Situation:
    """Carry the demonstrator across the room, away from the head and away from the learner. The eyes turn after it."""
    scene = situation.scene
    base, gaze = scene.demonstrator, scene.head.gaze_demonstrator
    moved = np.array([back_m, sideways_m, 0.0])
    return replace(
        situation,
        scene_fields={
            **situation.scene_fields,
            "demonstrator": {"position": (base.position + moved).tolist(), "yaw_deg": base.yaw_deg + turned_deg},
            "head": {**situation.scene_fields.get("head", {}), "gaze_demonstrator": (gaze + moved).tolist()},
        },
    )


# Bets


def brier(bets: Sequence[float], holds: Sequence[bool]) -> float:
    """Mean squared difference between bets and outcomes (Brier, Monthly Weather Review 1950)."""
    return float(np.mean((np.array(bets) - np.array(holds, float)) ** 2))


# Teaching by showing


@dataclass(frozen=True, eq=False)
class Servoing:
    """Steps towards a goal that was shown as a picture."""

    off_px: Array  # (K + 1,) root mean square over the points
    postures: Array  # (K + 1, 2) rad
    images: Array  # (K + 1, 2 n) px
    goal: Array  # (2 n,) px

    def steps(self, within_px: float = 2.0) -> float:
        """Steps after which the points were within it for the first time; NaN for never."""
        return float(next((k for k, off in enumerate(self.off_px) if off < within_px), np.nan))

    @property
    def turns(self) -> float:
        """Of a single point about its goal, in the first 20 steps."""
        off = self.images - self.goal
        angles = np.unwrap(np.arctan2(off[:, 1], off[:, 0]))
        return float((angles[20] - angles[0]) / (2 * np.pi))


def teach_by_showing(
    situation: Situation,
    gain: float,
    update: bool,
    coordinates: Sequence[int],
    probe_deg: float,
    roll_deg: float = 0.0,
    steps: int = 40,
) -> Servoing:
    """Go by u = λ J⁺ (y* - y), with J from a probe of each joint before the camera was turned about its axis."""
    world, theta = situation.world, situation.start.theta
    centre, angle = np.array(world.own_cameras[0].lens.centre), -np.radians(roll_deg)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])

    def see(posture: Array, turned: bool = True) -> Array:
        points = world.own_images(posture)[0].reshape(-1, 2)
        points = centre + (points - centre) @ turn.T if turned else points
        return points.ravel()[list(coordinates)]

    rest, probe = see(theta, False), np.radians(probe_deg)
    J = np.stack([(see(theta + probe * axis, False) - rest) / probe for axis in np.eye(2)], -1)
    goal, postures, images = see(situation.start.theta_demo), [theta], [see(theta)]
    for _ in range(steps):
        wanted = gain * np.linalg.lstsq(J, goal - images[-1], rcond=None)[0]
        there = np.clip(postures[-1] + wanted, world.scene.lower, world.scene.upper)
        moved, seen = there - postures[-1], see(there)
        if update and moved @ moved > 0:
            J = J + np.outer(seen - images[-1] - J @ moved, moved) / (moved @ moved)
        postures.append(there)
        images.append(seen)
    off = np.sqrt(((np.array(images) - goal) ** 2).sum(1) / (len(goal) / 2))
    return Servoing(off, np.array(postures), np.array(images), goal)
