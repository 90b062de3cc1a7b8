"""Which joints the images determine: the standard error of each joint per pixel of noise.

It follows from the curvature of E at its minimum, where E = |J δθ|²/2N. A joint is unobservable if turning it hardly
changes the residuals, or changes them as other joints do. These functions use the simulated world, so no learner can.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..estimation.views import FourViews
from ..geometry.affine import MIN_POINTS, flatness
from ..geometry.arrays import Floats
from ..loop.snapshot import Snapshot
from ..servo.certificate import MAX_STD_PER_PX
from ..simulation.autoscene.surface import Surface, choose_layout, parts_of, sample_arm, visible_fraction
from ..simulation.meshes import Mesh, first_hit
from ..simulation.robot import BodyPoints, link_meshes
from ..simulation.world import World
from .landscape import OwnImages

FD_STEP_RAD = 1e-3
MIN_SINGULAR_VALUE = 1e-9  # relative to the largest: directions below it are unobservable
WEAK_RATIO = 2.0  # a weak joint's error, relative to the median of the others
ITERATIONS = 6  # of damped Gauss-Newton steps in `sample_estimates`
MAX_PLACES = 64  # candidates for a further body point
MAX_DEPTH_M = 2e-3  # of a visible place under the surface
CANDIDATE_GRID = 0.0, 0.5, 1.0  # of the range of a joint
MAX_GRID_JOINTS = 2  # all combinations of CANDIDATE_GRID; with more joints, the given posture only
DAMPING, DAMPING_DECREASE, DAMPING_INCREASE = 1e-3, 0.2, 8.0  # initial, relative to the mean curvature; after a step


def residual_jacobian(residual_at: Callable[[Floats], Floats], theta: ArrayLike) -> Floats:
    """Return J, (n, m) px/rad, by central differences at theta, (m,) rad.

    residual_at maps postures (K, m) rad to residuals (K, ...) px, n for each posture.
    """
    theta = np.asarray(theta, float)
    offsets = FD_STEP_RAD * np.eye(len(theta))
    e = residual_at(np.concatenate([theta + offsets, theta - offsets])).reshape(2, len(theta), -1)
    return (e[0] - e[1]).T / (2 * FD_STEP_RAD)


def uncertainty(J: ArrayLike) -> Floats:
    """Return the standard error of each angle under independent noise of 1 px: √diag((JᵀJ)⁻¹), (m,) rad/px.

    J: (n, m) px/rad. An unobservable angle has the error inf.
    """
    _, s, Vt = np.linalg.svd(np.asarray(J, float), full_matrices=True)
    s = np.pad(s, (0, len(Vt) - len(s)))
    observable = s > MIN_SINGULAR_VALUE * s.max()
    if not observable.any():
        return np.full(len(Vt), np.inf)
    std = np.sqrt(((Vt[observable] / s[observable, None]) ** 2).sum(0))
    return np.where((np.abs(Vt[~observable]) > np.sqrt(MIN_SINGULAR_VALUE)).any(0), np.inf, std)


def unobservable_joints(std_per_px: ArrayLike) -> list[int]:
    """Return the indices of the joints that cannot be observed, those with the largest error first."""
    std = np.asarray(std_per_px, float)
    return [int(j) for j in np.argsort(-std, kind="stable") if std[j] >= MAX_STD_PER_PX]


def weak_joints(std_per_px: ArrayLike) -> list[int]:
    """Return the indices of the joints with over WEAK_RATIO times the median error of the others, worst first."""
    std = np.asarray(std_per_px, float)
    others = [np.median(np.delete(std, j)) if len(std) > 1 else np.inf for j in range(len(std))]
    return [int(j) for j in np.argsort(-std, kind="stable") if std[j] > WEAK_RATIO * others[j]]


def joint_uncertainty(
    world: OwnImages,
    fit: Callable,
    demo: Floats,
    demo_visible: NDArray[np.bool_],
    theta: ArrayLike,
) -> Floats | None:
    """Return the standard error of each joint, (m,) rad/px, under 1 px of noise in the learner's own images.

    world: gives these images; fit: fits a transfer to `FourViews`; demo, demo_visible: (N, 4) px and (N, 2), the
    demonstrator's images as the learner has them; theta: (m,) rad, the learner's posture. Only points seen there count.
    None if they are too few.
    """
    theta = np.asarray(theta, float)
    _, own_visible = world.own_images(theta)
    usable = own_visible.all(-1) & demo_visible.all(-1)
    if usable.sum() < MIN_POINTS:
        return None

    def residual_at(postures: Floats) -> Floats:
        own, _ = world.own_images(postures.T)
        views = FourViews(demo[usable], own[:, usable], np.ones(1, bool))
        return fit(views).residual(views)

    return uncertainty(residual_jacobian(residual_at, theta))


@dataclass(frozen=True, eq=False)
class PointInformation:
    """How well a set of body points determines the joints, in exact images of the demonstrator's posture."""

    count: int  # points
    visible: int  # points in all four images
    std_per_px: Floats | None  # (m,) rad/px, standard error of each joint; None with too few points
    flatness: float  # σ1/σ3 of the demonstrator's points in [l, r]

    @property
    def unobservable(self) -> list[int]:
        """Indices of the unobservable joints, worst first; empty with too few points."""
        return [] if self.std_per_px is None else unobservable_joints(self.std_per_px)


@dataclass(frozen=True, eq=False)
class Proposal:
    """A further body point."""

    point: BodyPoints  # a single one
    before: PointInformation  # without it
    after: PointInformation  # with it


def point_information(world: World, moment: Snapshot) -> PointInformation:
    """Assess the world's points with the snapshot's transfer, both arms in its demonstrator's posture."""
    theta = moment.theta_demo
    demo, visible = world.demo_images(theta)
    usable = visible.all(-1) & world.own_images(theta)[1].all(-1)
    enough = usable.sum() >= MIN_POINTS
    std = joint_uncertainty(world, moment.fit, demo, visible, theta) if enough else None
    flat = flatness(demo[usable]) if enough else np.inf
    return PointInformation(len(world.body), int(usable.sum()), std, flat)


def best_next(world: World, moment: Snapshot, candidates: BodyPoints) -> Proposal:
    """Choose the candidate that minimises the largest joint error, then the second largest, and so on.

    With too few visible points for any estimate, the candidate farthest from all others is chosen. Raises ValueError
    without candidates.
    """
    if not len(candidates):
        raise ValueError("no place on the arm is seen in all four images in this posture: move the demonstrator")
    before = point_information(world, moment)
    distance = _distance_to_points(world, candidates, moment.theta_demo)
    found = [point_information(with_point(world, candidates, k), moment) for k in range(len(candidates))]
    best = min(range(len(candidates)), key=lambda k: (_errors_descending(found[k]), -distance[k]))
    return Proposal(BodyPoints(candidates.link[[best]], candidates.local[[best]]), before, found[best])


def with_point(world: World, points: BodyPoints, k: int) -> World:
    """Return the world with the k-th of these points added to the body."""
    body = world.body
    link, local = np.append(body.link, points.link[k]), np.concatenate([body.local, points.local[[k]]])
    return World(world.scene, robot=world.robot, body=BodyPoints(link, local))


def _errors_descending(information: PointInformation) -> tuple[float, ...]:
    return () if information.std_per_px is None else tuple(sorted(information.std_per_px.tolist(), reverse=True))


def _distance_to_points(world: World, candidates: BodyPoints, theta: NDArray) -> NDArray:
    """(K,) m from each candidate to the nearest body point, in this posture."""
    places, points = candidates.at(world.link_frames(theta, np.eye(4))), world.points_world(theta, np.eye(4))
    return np.linalg.norm(places[:, None] - points, axis=-1).min(1, initial=np.inf)


def sample_estimates(
    world: World,
    fit: Callable,
    theta_demo: ArrayLike,
    noise_px: float,
    frames: int,
    runs: int,
    rng: np.random.Generator,
    noisy_demo: bool = True,
) -> Floats:
    """Draw noisy images and return the posture that minimises E for each draw, (runs, m) rad (Monte Carlo).

    All draws are searched at once by damped Gauss-Newton steps from the demonstrator's own posture, theta_demo. fit: as
    for `joint_uncertainty`; noise_px: standard deviation of a coordinate; frames: averaged in each draw; noisy_demo:
    whether the demonstrator's images have noise, too. Raises ValueError if a point is out of sight in that posture.
    """
    theta_demo = np.asarray(theta_demo, float)
    demo, visible = world.demo_images(theta_demo)
    if not (visible.all() and world.own_images(theta_demo)[1].all()):
        raise ValueError("all points must be in all four images at the demonstrator's posture")

    def noise() -> Floats:
        return rng.normal(0.0, noise_px, (runs, frames, *demo.shape)).mean(1)

    own_noise = noise()
    demos = demo + (noise() if noisy_demo else np.zeros_like(own_noise))

    def residual_at(theta: Floats) -> Floats:
        views = FourViews(demos, world.own_images(theta.T)[0] + own_noise, np.ones(1, bool))
        return fit(views).residual(views).reshape(runs, -1)

    return _levenberg_marquardt(residual_at, np.tile(theta_demo, (runs, 1)), world.scene.lower, world.scene.upper)


def _levenberg_marquardt(residual_at: Callable, theta: NDArray, low: NDArray, high: NDArray) -> NDArray:
    """Minimise the residuals of all runs: residual_at maps (runs, m) rad to (runs, n) px, each run its own."""
    e, m = residual_at(theta), theta.shape[1]
    damping = np.full(len(theta), DAMPING)
    for _ in range(ITERATIONS):
        J = np.stack([(residual_at(theta + FD_STEP_RAD * axis) - e) / FD_STEP_RAD for axis in np.eye(m)], -1)
        normal, gradient = np.einsum("rni,rnj->rij", J, J), np.einsum("rni,rn->ri", J, e)
        damped = normal + (damping * np.trace(normal, axis1=1, axis2=2) / m)[:, None, None] * np.eye(m)
        trial = np.clip(theta - np.linalg.solve(damped, gradient[..., None])[..., 0], low, high)
        e_trial = residual_at(trial)
        better = np.square(e_trial).sum(-1) < np.square(e).sum(-1)
        theta, e = np.where(better[:, None], trial, theta), np.where(better[:, None], e_trial, e)
        damping *= np.where(better, DAMPING_DECREASE, DAMPING_INCREASE)
    return theta


def find_candidates(world: World, theta: ArrayLike) -> BodyPoints:
    """Return candidates for a further body point, as visible in the four images as possible.

    They are rounded to 0.1 mm, and no surface hides them at a posture (m,) rad of both arms.
    """
    scene, robot = world.scene, world.robot
    meshes = link_meshes(scene.robot)
    theta = np.asarray(theta, float)
    rest = np.array(world.joint_angles(theta), float)
    surface = sample_arm(link_meshes(scene.robot, held_only=True), robot, rest, int(scene.moving[0]) + 1)
    postures = [theta]
    if len(scene.moving) <= MAX_GRID_JOINTS:
        grid = np.array(list(product(CANDIDATE_GRID, repeat=len(scene.moving))))
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
        places = points.at(frames)
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
