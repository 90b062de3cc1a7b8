"""Two arms of the same build and a stereo head: postures in, image points out.

The simulated world. It knows the truth, so nothing in `transfer` or `servo` may import it.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..estimation.views import FourViews
from ..geometry.rigid import rigid_transform, rotation_about_axis
from .camera import Camera, Cameras
from .robot import BodyPoints, Robot
from .scene import Base, Scene, load_robot


class World:
    """A scene set up: the two robots placed, the head's two gazes taken.

    Postures are of the scene's moving joints: m arrays of angles in rad, broadcast against each
    other, so that (θ2[:, None], θ4[None, :]) is a grid. Own images of a grid are (91, 181, N, 4).
    """

    def __init__(self, scene: Scene, points: int = 10, robot: Robot | None = None, body: BodyPoints | None = None):
        self.scene = scene
        self.robot = robot or load_robot(scene.robot)
        self.body: BodyPoints = scene.body_points(points) if body is None else body
        self._chain, self._links = self.robot.with_fixed_joints(np.radians(scene.posture_deg), scene.moving)
        self._chain_body = self._links.points(self.body)
        self._rest = np.radians(scene.posture_deg).tolist()
        head = scene.stereo_head()
        self.demo_cameras: tuple[Camera, Camera] = head.gaze(scene.head.gaze_demonstrator)
        self.own_cameras: tuple[Camera, Camera] = head.gaze(scene.head.gaze_learner)
        self.demo_pair, self.own_pair = Cameras(self.demo_cameras), Cameras(self.own_cameras)
        self._local = np.concatenate([self._chain_body.local, np.ones((len(self.body), 1))], 1)[:, :, None]
        self._last_frames: tuple[tuple[bytes, bytes], NDArray] | None = None
        self._last_points: tuple[NDArray, NDArray] | None = None
        self.T_world_demo = _placed(scene.demonstrator)
        self.T_world_own = _placed(scene.learner)

    def joint_angles(self, theta: Sequence[ArrayLike] | NDArray) -> list:
        """Angles of all n joints, rad: the moving ones from theta, the others at rest."""
        angles = list(self._rest)
        for joint, angle in zip(self.scene.moving, theta, strict=True):
            angles[joint] = angle
        return list(self.robot.with_mimics(angles))

    def demo_images(self, theta) -> tuple[NDArray, NDArray]:
        """The demonstrator in [l], [r] → points (..., N, 4) px, visible (..., N, 2)."""
        return self._images(theta, self.T_world_demo, self.demo_pair)

    def own_images(self, theta) -> tuple[NDArray, NDArray]:
        """The learner in [L], [R] → points (..., N, 4) px, visible (..., N, 2)."""
        return self._images(theta, self.T_world_own, self.own_pair)

    def look(self, theta_demo, theta_own) -> FourViews:
        """All four views, undisturbed, for one posture of each arm, (m,) rad."""
        demo, demo_visible = self.demo_images(theta_demo)
        own, own_visible = self.own_images(theta_own)
        return FourViews(demo, own, np.concatenate([demo_visible, own_visible], -1))

    def link_frames(self, theta, T_world_base: NDArray) -> NDArray:
        """T_world_link of every link of an arm in one posture: (n + 1, 4, 4)."""
        return self._links.link_frames(self._chain_frames(theta, T_world_base))

    def points_world(self, theta, T_world_base: NDArray) -> NDArray:
        """Body points of an arm in one posture: (N, 3) m, not to be written into."""
        frames, last = self._chain_frames(theta, T_world_base), self._last_points
        if last is None or last[0] is not frames:
            last = self._last_points = frames, (frames[self._chain_body.link] @ self._local)[:, :3, 0]
        return last[1]

    def _chain_frames(self, theta, T_world_base: NDArray) -> NDArray:
        """T_world_link of what moves of an arm in one posture, and of its base, not to be written into."""
        angles = np.array(self._chain.expand_mimics(theta), float)
        key = angles.tobytes(), T_world_base.tobytes()
        last = self._last_frames
        if last is None or last[0] != key:  # a posture is looked at first, and then shown
            last = self._last_frames = key, self._chain.link_frames(angles, T_world_base)
        return last[1]

    def _images(self, theta, T_world_base: NDArray, pair: Cameras) -> tuple[NDArray, NDArray]:
        if all(np.ndim(angle) == 0 for angle in theta):  # one posture: few points, whose price is the number of steps
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


def _placed(base: Base) -> NDArray:
    """T_world_base"""
    return rigid_transform(rotation_about_axis([0, 0, 1], np.radians(base.yaw_deg)), base.position)


# Where an arm's hand is, how the joints move it, and a posture that brings it somewhere.
# For people who pose the demonstrator, and for the truth about a learner: it needs the arm's model, which no servo has.

ROUNDS, DIFFERENCE, DAMPING = 12, 1e-4, 1e-4


def hand_position(world: World, theta: NDArray, T_world_base: NDArray) -> NDArray:
    """(3,) m: the origin of the last link. theta: (m,) rad."""
    return world.link_frames(theta, T_world_base)[-1][:3, 3]


def hand_jacobian(world: World, theta: NDArray, T_world_base: NDArray) -> NDArray:
    """(3, m) m/rad, by difference quotients."""
    here = hand_position(world, theta, T_world_base)
    turned = [hand_position(world, theta + DIFFERENCE * unit, T_world_base) for unit in np.eye(len(theta))]
    return (np.stack(turned, -1) - here[:, None]) / DIFFERENCE


def pose_for_hand(world: World, target: NDArray, theta: NDArray) -> NDArray:
    """The posture whose hand is nearest. target: (3,) m in the world; theta: (m,) rad, where to begin → (m,) rad.

    Damped least squares within the limits.
    """
    for _ in range(ROUNDS):
        J = hand_jacobian(world, theta, world.T_world_demo)
        away = target - hand_position(world, theta, world.T_world_demo)
        step = np.linalg.solve(J.T @ J + DAMPING * np.eye(len(theta)), J.T @ away)
        moved = np.clip(theta + np.clip(step, -0.5, 0.5), world.scene.lower, world.scene.upper)
        if np.max(np.abs(moved - theta)) < 1e-4:
            break
        theta = moved
    return theta
