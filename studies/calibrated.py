"""Calibrated visual servoing, an oracle beside the servos: it is given what they do not know.

Both laws are given the URDF, where each point is on the body, the calibrated cameras, where both arms stand and the
angles of the own joints. They show what knowledge of the model is worth, and what an error in it costs: two of ORACLES
are given each camera turned by 1°. They are no servos: those see image points only.

`image_based` (IBVS): u = -λ L⁺ (s - s*). The feature s is the own image points in [L, R]. s* is where they would be in
the demonstrator's posture: its points are triangulated from [l, r], moved to the own base, and projected. L is the
interaction matrix of the points times the arm's Jacobian, at the current posture.

`position_based` (PBVS): u = -λ (θ - θ*). Both postures are estimated from the images by the model: the least squares of
reprojection.

References
----------
Chaumette and Hutchinson, "Visual servo control. I. Basic approaches", IEEE Robotics & Automation Magazine 13(4), 2006:
Eqs. (1), (4) and (11), and the section on position-based visual servo.
"""

import copy
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from viewimit.estimation.residuals import ResidualFunction
from viewimit.estimation.views import FourViews
from viewimit.geometry.rigid import rotation_about_axis
from viewimit.loop.session import Session
from viewimit.servo import Observation
from viewimit.servo.image_jacobian import MIN_STEP_RAD
from viewimit.servo.least_squares import minimise
from viewimit.servo.status import ServoStatus
from viewimit.simulation.camera import Camera, Cameras, triangulate
from viewimit.simulation.world import World

GAIN = 1.0  # λ, per motion
MAX_STEP_RAD = np.radians(25.0)  # of a joint, in one motion; as of the other laws
MIN_POINTS = 3  # of a body, in both images: they determine its pose
PATIENCE, PROGRESS = 5, 0.99  # motions after which the law's error must have fallen to this share of its minimum
FD_STEP_RAD = 1e-5
MODEL_STREAM = 1  # of random numbers for errors of the model, beside that of the draw
N_SAMPLES, N_STARTS = 2048, 24  # postures at which the demonstrator is looked for at first, and the best ones of them

Floats = NDArray[np.float64]
Law = Callable[[World, Floats, Floats | None, FourViews], tuple[Floats, Floats, Floats | None]]
"""Model, own posture (m,) rad, the demonstrator's estimated before, images → motion (m,) rad, the error whose norm
should fall, and the demonstrator's posture as estimated now; None where a law does not estimate it."""


def image_based(
    model: World, theta: Floats, theta_demo: Floats | None, views: FourViews
) -> tuple[Floats, Floats, Floats | None]:
    """Return the motion of IBVS, see `Law`."""
    usable = views.usable
    points = triangulate(*model.demo_cameras, views.demo[usable])
    T_own_demo = model.T_world_own @ np.linalg.inv(model.T_world_demo)
    images, _ = model.own_pair.images(points @ T_own_demo[:3, :3].T + T_own_demo[:3, 3])
    error = (views.own[usable] - np.concatenate([*images], -1)).ravel()  # s - s*
    L = image_velocities(model, theta)[usable].reshape(-1, len(theta))
    return -GAIN * np.linalg.pinv(L) @ error, error, theta_demo


def image_velocities(model: World, theta: Floats) -> Floats:
    """Return how the own points move in [L, R] with each joint, by central differences: (m,) rad -> (N, 4, m) px/rad.

    This is the interaction matrix of each point times the Jacobian of the arm.
    """
    steps = FD_STEP_RAD * np.eye(len(theta))
    images, _ = model.own_images(tuple((theta + np.concatenate([steps, -steps])).T))  # (2 m, N, 4)
    return np.moveaxis((images[: len(theta)] - images[len(theta) :]) / (2 * FD_STEP_RAD), 0, -1)


def position_based(
    model: World, theta: Floats, theta_demo: Floats | None, views: FourViews
) -> tuple[Floats, Floats, Floats | None]:
    """Return the motion of PBVS, see `Law`."""
    seen = np.asarray(views.visible[:, :2].all(-1)), np.asarray(views.visible[:, 2:].all(-1))
    theta_demo = estimate_posture(model, model.demo_images, views.demo, seen[0], theta_demo)
    error = estimate_posture(model, model.own_images, views.own, seen[1], theta) - theta_demo
    return -GAIN * error, error, theta_demo


def estimate_posture(
    model: World, images_at: Callable, images: Floats, seen: NDArray[np.bool_], near: Floats | None
) -> Floats:
    """Estimate a posture from the images of a known arm in calibrated cameras, by nonlinear least squares.

    Parameters
    ----------
    model : World
        Gives the limits of the joints.
    images_at : callable
        Projects the arm's points in a posture, `World.demo_images` or `own_images`.
    images, seen : (N, 4) and (N,) arrays
        Points in both cameras [px], and which are visible in both.
    near : (m,) array or None
        Where the posture is looked for [rad]; None: anywhere.

    Returns
    -------
    (m,) array
        Posture [rad].
    """
    low, high = model.scene.lower, model.scene.upper

    def residual_at(theta: Floats) -> Floats:
        return images_at(tuple(np.moveaxis(theta, -1, 0)))[0][..., seen, :] - images[seen]

    if near is None:
        samples = np.random.default_rng(0).uniform(low, high, (N_SAMPLES, len(low)))
        starts = samples[np.argsort((residual_at(samples) ** 2).sum((1, 2)))[:N_STARTS]]
    else:
        starts = near[None]
    return minimise(residual_at, np.clip(starts, low, high), low, high).theta


@dataclass(frozen=True)
class Oracle:
    """A calibrated law, and how wrong its calibration is."""

    law: Law
    rotation_deg: float = 0.0  # by which it is given each camera turned about a random axis


ORACLES = {
    "oracle-ibvs": Oracle(image_based),
    "oracle-pbvs": Oracle(position_based),
    "oracle-ibvs-1deg": Oracle(image_based, rotation_deg=1.0),
    "oracle-pbvs-1deg": Oracle(position_based, rotation_deg=1.0),
}


@dataclass(frozen=True)
class CalibratedState:
    """State of a calibrated law."""

    theta_demo: Floats | None = None  # (m,) rad: the demonstrator's posture, as estimated
    best: float = np.inf  # the smallest norm of the law's error so far
    n_since_best: int = 0  # motions since then
    status: ServoStatus = ServoStatus.MOVING


class CalibratedServo:
    """Runs a calibrated law in a session, in the place of a servo. It reads the session's own images and posture.

    The errors of its model depend on `seed` alone.
    """

    session: Session
    model: World  # what the law is given; it may differ from the session's world

    def __init__(self, oracle: Oracle, seed: Sequence[int] = ()):
        self.law, self._rotation_deg, self._seed = oracle.law, oracle.rotation_deg, seed

    def attach(self, session: Session) -> None:
        """Run in this session, which was made with it."""
        self.session, self.model = session, session.world
        if self._rotation_deg:
            rng = np.random.default_rng([*self._seed, MODEL_STREAM])
            self.model = miscalibrated(session.world, self._rotation_deg, rng)

    def start(self, observation: Observation) -> CalibratedState:
        """Return the state before the first motion."""
        return CalibratedState()

    def step(
        self, state: CalibratedState, observation: Observation, residuals: ResidualFunction
    ) -> tuple[CalibratedState, Floats]:
        """Return the next state and the motion, (m,) rad."""
        now, rest = self.session.snapshot, np.zeros_like(observation.displacement)
        if min(now.views.usable.sum(), now.shown) < MIN_POINTS:
            return replace(state, status=ServoStatus.NO_PROGRESS), rest
        u, error, theta_demo = self.law(self.model, now.commanded, state.theta_demo, now.views)
        size = float(np.linalg.norm(error))
        has_progressed = size < PROGRESS * state.best
        best, n_since_best = (size, 0) if has_progressed else (state.best, state.n_since_best + 1)
        u = u * min(1.0, MAX_STEP_RAD / max(np.abs(u).max(), MIN_STEP_RAD))
        u = u.clip(observation.lower - observation.displacement, observation.upper - observation.displacement)
        has_arrived = np.abs(u).max() < MIN_STEP_RAD or n_since_best >= PATIENCE
        status = ServoStatus.SETTLED if has_arrived else ServoStatus.MOVING
        return CalibratedState(theta_demo, best, n_since_best, status), rest if has_arrived else u


def miscalibrated(world: World, rotation_deg: float, rng: np.random.Generator) -> World:
    """Return a world whose cameras are turned, as of a head that is calibrated wrongly.

    Parameters
    ----------
    world : World
        The true one.
    rotation_deg : float
        By which each camera is turned about a random axis of its own, equally in both gazes [degrees].
    rng : Generator
        Draws the axes.

    Returns
    -------
    World
        With the same arms and lenses.
    """
    wrong = copy.copy(world)
    turns = [rotation_about_axis(rng.normal(size=3), np.radians(rotation_deg)) for _ in world.own_cameras]
    wrong.demo_cameras, wrong.own_cameras = (
        (_turned(pair[0], turns[0]), _turned(pair[1], turns[1])) for pair in (world.demo_cameras, world.own_cameras)
    )
    wrong.demo_pair, wrong.own_pair = Cameras(wrong.demo_cameras), Cameras(wrong.own_cameras)
    return wrong


def _turned(camera: Camera, turn: Floats) -> Camera:
    T_world_camera = camera.T_world_camera.copy()
    T_world_camera[:3, :3] = T_world_camera[:3, :3] @ turn
    return replace(camera, T_world_camera=T_world_camera)
