"""The simulated world: two arms of the same build and a stereo head, from postures to image points.

It knows the ground truth, so no estimator and no servo may import it.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..estimation.views import FourViews
from ..geometry.arrays import Floats
from ..geometry.rigid import rigid_transform, rotation_about_axis
from .camera import Camera, Cameras
from .robot import Angles, BodyPoints, Robot
from .scene import Base, Scene, load_robot

HAND_ITERATIONS, FD_STEP_RAD, DAMPING = 12, 1e-4, 1e-4
MAX_HAND_STEP_RAD = 0.5

Visible = NDArray[np.bool_]


class World:
    """Two robots and the cameras of both gazes, as a scene places them.

    Postures are m arrays of angles of the scene's moving joints [rad], broadcast against each other. So
    (θ2[:, None], θ4[None, :]) is a grid, and its images have shape (91, 181, N, 4).

    Parameters
    ----------
    scene : Scene
        Robots, bases, cameras and joint limits.
    points : int
        Layout of body points.
    robot : Robot, optional
        Instead of the scene's.
    body : BodyPoints, optional
        Instead of the layout.
    """

    def __init__(self, scene: Scene, points: int = 10, robot: Robot | None = None, body: BodyPoints | None = None):
        self.scene = scene
        self.robot: Robot = robot or load_robot(scene.robot)
        self.body: BodyPoints = scene.body_points(points) if body is None else body
        self._chain, self._links = self.robot.with_fixed_joints(np.radians(scene.posture_deg), scene.moving)
        self._chain_body = self._links.points(self.body)
        self._rest = np.radians(scene.posture_deg).tolist()
        head = scene.stereo_head()
        self.demo_cameras: tuple[Camera, Camera] = head.gaze(scene.head.gaze_demonstrator)
        self.own_cameras: tuple[Camera, Camera] = head.gaze(scene.head.gaze_learner)
        self.demo_pair: Cameras = Cameras(self.demo_cameras)
        self.own_pair: Cameras = Cameras(self.own_cameras)
        self._local = np.concatenate([self._chain_body.local, np.ones((len(self.body), 1))], 1)[:, :, None]
        self._last_frames: tuple[tuple[bytes, bytes], Floats] | None = None
        self._last_points: tuple[Floats, Floats] | None = None
        self.T_world_demo: Floats = _placed(scene.demonstrator)
        self.T_world_own: Floats = _placed(scene.learner)

    def joint_angles(self, theta: Angles) -> list[ArrayLike]:
        """Return the angles of all joints: the moving ones from theta, the others at rest.

        Parameters
        ----------
        theta : m arrays
            Angles of the moving joints [rad], broadcast against each other to shape (...).

        Returns
        -------
        list of n arrays
            Angles of the robot's joints [rad].
        """
        angles = list(self._rest)
        for joint, angle in zip(self.scene.moving, theta, strict=True):
            angles[joint] = angle
        return list(self.robot.with_mimics(angles))

    def demo_images(self, theta: Angles) -> tuple[Floats, Visible]:
        """Project the demonstrator's points into [l] and [r].

        Parameters
        ----------
        theta : m arrays
            Angles of the moving joints [rad], broadcast against each other to shape (...).

        Returns
        -------
        (..., N, 4) and (..., N, 2) arrays
            Points [px], and whether they are visible.
        """
        return self._images(theta, self.T_world_demo, self.demo_pair)

    def own_images(self, theta: Angles) -> tuple[Floats, Visible]:
        """Project the learner's points into [L] and [R].

        Parameters
        ----------
        theta : m arrays
            Angles of the moving joints [rad], broadcast against each other to shape (...).

        Returns
        -------
        (..., N, 4) and (..., N, 2) arrays
            Points [px], and whether they are visible.
        """
        return self._images(theta, self.T_world_own, self.own_pair)

    def look(self, theta_demo: Floats, theta_own: Floats) -> FourViews:
        """Return all four views, undisturbed, for one posture of each arm.

        Parameters
        ----------
        theta_demo, theta_own : (m,) arrays
            Angles of the moving joints [rad].

        Returns
        -------
        FourViews
            Image points of both arms [px].
        """
        demo, demo_visible = self.demo_images(theta_demo)
        own, own_visible = self.own_images(theta_own)
        return FourViews(demo, own, np.concatenate([demo_visible, own_visible], -1))

    def link_frames(self, theta: Angles, T_world_base: Floats) -> Floats:
        """Return the frames of every link of an arm in one posture.

        Parameters
        ----------
        theta : (m,) array
            Angles of the moving joints [rad].
        T_world_base : (4, 4) array
            Where the arm stands [m].

        Returns
        -------
        (n + 1, 4, 4) array
            T_world_link of the base and of the n links [m].
        """
        return self._links.link_frames(self._chain_frames(theta, T_world_base))

    def points_world(self, theta: Angles, T_world_base: Floats) -> Floats:
        """Return the body points of an arm in one posture.

        Parameters
        ----------
        theta : (m,) array
            Angles of the moving joints [rad].
        T_world_base : (4, 4) array
            Where the arm stands [m].

        Returns
        -------
        (N, 3) array
            Points in the world [m], read-only.
        """
        frames, last = self._chain_frames(theta, T_world_base), self._last_points
        if last is None or last[0] is not frames:
            last = self._last_points = frames, (frames[self._chain_body.link] @ self._local)[:, :3, 0]
        return last[1]

    def _chain_frames(self, theta: Angles, T_world_base: Floats) -> Floats:
        """T_world_link of the base and the moving links of an arm in one posture, read-only."""
        angles = np.array(self._chain.expand_mimics(theta), float)
        key = angles.tobytes(), T_world_base.tobytes()
        last = self._last_frames
        if last is None or last[0] != key:  # each posture is first projected, and then drawn
            last = self._last_frames = key, self._chain.link_frames(angles, T_world_base)
        return last[1]

    def _images(self, theta: Angles, T_world_base: Floats, pair: Cameras) -> tuple[Floats, Visible]:
        if all(np.ndim(angle) == 0 for angle in theta):  # one posture: few points, so few numpy calls
            images, visible = pair.project(self.points_world(theta, T_world_base))
            return np.concatenate((images[0], images[1]), 1), visible.T
        shape = np.broadcast_shapes(*(np.shape(angle) for angle in theta))
        points = np.empty((4, len(self.body)) + shape)  # components first: long batches stay contiguous
        visible = np.empty((2, len(self.body)) + shape, bool)
        placed = self._chain.place_points(self._chain.expand_mimics(theta), self._chain_body)
        together = np.concatenate([xyz.reshape(3, -1) for _, xyz in placed], 1)
        for side, camera in enumerate(pair.cameras):
            images, seen = camera.project(together, T_world_base)
            done = 0
            for index, xyz in placed:
                these = slice(done, done := done + xyz[0].size)
                points[2 * side : 2 * side + 2, index] = images[:, these].reshape(2, *xyz.shape[1:])
                visible[side, index] = seen[these].reshape(xyz.shape[1:])
        last = *range(2, points.ndim), 1, 0
        return points.transpose(last), visible.transpose(last)


def _placed(base: Base) -> Floats:
    return rigid_transform(rotation_about_axis([0, 0, 1], np.radians(base.yaw_deg)), base.position)


class SimulatedEyes:
    """How a simulated head sees N body points, matched by index; here as the cameras' geometry projects them.

    Attributes
    ----------
    world : World
        The ground truth, for viewers only.
    noise_px : float
        Standard deviation of an image coordinate [px], without disturbances.
    """

    noise_px: float = 0.0

    def __init__(self, scene: Scene, points: int = 10, body: BodyPoints | None = None):
        """points, body: as of `World`."""
        self.world: World = World(scene, points, body=body)

    def demo_images(self, theta: Angles) -> tuple[Floats, Visible]:
        """Take the images of the demonstrator, [l] and [r], as `World.demo_images` returns them."""
        return self.world.demo_images(theta)

    def own_images(self, theta: Angles) -> tuple[Floats, Visible]:
        """Take the images of the learner, [L] and [R]."""
        return self.world.own_images(theta)


def hand_position(world: World, theta: Floats, T_world_base: Floats) -> Floats:
    """Return the origin of the last link: (m,) rad -> (3,) m."""
    return world.link_frames(theta, T_world_base)[-1][:3, 3]


def hand_jacobian(world: World, theta: Floats, T_world_base: Floats) -> Floats:
    """Return the Jacobian of the hand's position by finite differences: (m,) rad -> (3, m) m/rad."""
    start = hand_position(world, theta, T_world_base)
    moved = [hand_position(world, theta + FD_STEP_RAD * unit, T_world_base) for unit in np.eye(len(theta))]
    return (np.stack(moved, -1) - start[:, None]) / FD_STEP_RAD


def pose_for_hand(world: World, target: Floats, theta: Floats) -> Floats:
    """Return the demonstrator's posture whose hand is nearest to a target, by damped least squares within the limits.

    target: (3,) m in the world; theta: (m,) rad, posture at which to start.
    """
    for _ in range(HAND_ITERATIONS):
        J = hand_jacobian(world, theta, world.T_world_demo)
        away = target - hand_position(world, theta, world.T_world_demo)
        step = np.linalg.solve(J.T @ J + DAMPING * np.eye(len(theta)), J.T @ away)
        moved = np.clip(
            theta + np.clip(step, -MAX_HAND_STEP_RAD, MAX_HAND_STEP_RAD), world.scene.lower, world.scene.upper
        )
        if np.max(np.abs(moved - theta)) < 1e-4:
            break
        theta = moved
    return theta
