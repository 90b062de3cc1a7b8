"""Demonstrators and arms that are not as the method assumes, and points that one body lacks.

Each function draws its own misfit, and returns the eyes of a session that has it.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from ...geometry.arrays import Floats
from ...simulation.arms import SimulatedArm
from ...simulation.camera import Cameras, Lens
from ...simulation.disturbances import ArmAmounts
from ...simulation.eyes import SimulatedEyes
from ...simulation.robot import Angles, BodyPoints, Robot
from ...simulation.scene import Scene
from ...simulation.world import World
from .draws import resize

POINT_M, LINK_POINTS_M = (0.008, 0.020), 0.010  # displacement of one point; standard deviation of each of a link's
MIXED_UP = 3, 6  # points, from and below
FOCAL, BASELINE, CENTRE_PX = (0.85, 1.15), (0.8, 1.2), 30.0  # of another head, relative to the own one
LENS_K1 = 0.03, 0.06  # of both cameras, negative

Rng = np.random.Generator


class OtherDemonstrator(SimulatedEyes):
    """Eyes that see another demonstrator than the scene's: of another world, mirrored, or with its points mixed up."""

    def __init__(
        self,
        scene: Scene,
        points: int,
        robot: Robot | None = None,
        body: BodyPoints | None = None,
        cameras: Cameras | None = None,
        mirrored: bool = False,
        order: NDArray[np.int_] | None = None,
    ):
        super().__init__(scene, points)
        self.other = World(scene, points, robot, body)
        self._cameras, self._mirrored, self._order = cameras or self.other.demo_pair, mirrored, order

    def demo_images(self, theta: Angles) -> tuple[NDArray, NDArray]:
        T = self.other.T_world_demo
        points = self.other.points_world(theta, T)
        if self._mirrored:
            points = (points - T[:3, 3]) @ T[:3, :3] * (1, -1, 1) @ T[:3, :3].T + T[:3, 3]
        images, visible = self._cameras.project(points)
        found = np.concatenate(list(images), 1), visible.T
        return found if self._order is None else (found[0][self._order], found[1][self._order])


class StopsShort(SimulatedArm):
    """An arm that stops short of every commanded posture, by a share of the motion."""

    def __init__(self, scene: Scene, share: float):
        super().__init__(scene)
        self._share = share

    def drive(self, amounts: ArmAmounts, start: Floats, theta: Floats, sent: Floats, commanded: Floats) -> Floats:
        return np.asarray(theta + (1 - self._share) * (commanded - theta))


def stretched(scene: Scene, robot: Robot, stretch: Floats) -> Robot:
    """Return a robot whose moving joints are attached farther out, by (m,) shares; points stay where they are."""
    chain, frames = robot.with_fixed_joints(np.radians(scene.posture_deg), scene.moving)
    joints = list(robot.joints)
    for joint, kept, share in zip(scene.moving, chain.joints, stretch):
        T = kept.T_parent_joint.copy()
        T[:3, 3] *= 1 + share
        joints[joint] = replace(joints[joint], T_parent_joint=np.linalg.inv(frames.T_chain_link[joint]) @ T)
    return replace(robot, joints=tuple(joints))


def every_link(share: float, rng: Rng, scene: Scene, points: int) -> SimulatedEyes:
    """Each joint, moving or not, is attached farther or nearer by a share of its own."""
    robot, joints = World(scene, points).robot, []
    for joint in robot.joints:
        T = joint.T_parent_joint.copy()
        T[:3, 3] *= 1 + rng.uniform(-share, share)
        joints.append(replace(joint, T_parent_joint=T))
    return OtherDemonstrator(scene, points, replace(robot, joints=tuple(joints)))


def moving_joints(share: float, rng: Rng, scene: Scene, points: int) -> SimulatedEyes:
    robot = World(scene, points).robot
    stretch = rng.uniform(-share, share, len(scene.moving))
    return OtherDemonstrator(scene, points, stretched(scene, robot, stretch))


def _moved(body: BodyPoints, index: NDArray, offsets: Floats) -> BodyPoints:
    local = body.local.copy()
    local[index] += offsets
    return BodyPoints(body.link, local)


def point(rng: Rng, scene: Scene, points: int) -> SimulatedEyes:
    body, offset = World(scene, points).body, rng.normal(size=3)
    offset *= rng.uniform(*POINT_M) / np.linalg.norm(offset)
    return OtherDemonstrator(scene, points, body=_moved(body, rng.integers(len(body), size=1), offset))


def link_points(rng: Rng, scene: Scene, points: int) -> SimulatedEyes:
    body = World(scene, points).body
    rigid = np.searchsorted(np.array(scene.moving) + 1, body.link, side="right")  # groups of links that move as one
    index = np.flatnonzero(rigid == rng.integers(len(scene.moving) + 1))
    return OtherDemonstrator(scene, points, body=_moved(body, index, LINK_POINTS_M * rng.normal(size=(len(index), 3))))


def mixed_up(rng: Rng, scene: Scene, points: int) -> SimulatedEyes:
    order = np.arange(len(World(scene, points).body))
    some = rng.permutation(len(order))[: rng.integers(*MIXED_UP)]
    order[some] = order[np.roll(some, 1)]
    return OtherDemonstrator(scene, points, order=order)


def other_head(rng: Rng, scene: Scene, points: int) -> SimulatedEyes:
    head, zoom, wider = scene.stereo_head(), rng.uniform(*FOCAL), rng.uniform(*BASELINE)
    shift = rng.uniform(-CENTRE_PX, CENTRE_PX)

    def changed(lens: Lens) -> Lens:
        (across, down), (x, y) = lens.focal, lens.centre
        return replace(lens, focal=(zoom * across, zoom * down), centre=(x + shift, y))

    other = replace(head, baseline_m=wider * head.baseline_m, left=changed(head.left), right=changed(head.right))
    return OtherDemonstrator(scene, points, cameras=Cameras(other.gaze(scene.head.gaze_demonstrator)))


def mirrored(rng: Rng, scene: Scene, points: int) -> SimulatedEyes:
    return OtherDemonstrator(scene, points, mirrored=True)


def lens(rng: Rng, scene: Scene, points: int) -> SimulatedEyes:
    bend = (-rng.uniform(*LENS_K1), 0.0)
    left, right = (msgspec.structs.replace(eye, distortion=bend) for eye in (scene.head.left, scene.head.right))
    head = msgspec.structs.replace(scene.head, left=left, right=right)
    return SimulatedEyes(msgspec.structs.replace(scene, head=head), points)


class OtherPoints(SimulatedEyes):
    """Projected points, of which some of the demonstrator's are hidden, and others are seen that no body has.

    scene, points: as of `SimulatedEyes`; missing: points of the demonstrator that are hidden; extra: points beside it,
    anywhere in the box around its points. They come after all others, and the learner has none; seed: of both.
    """

    def __init__(self, scene: Scene, points: int, missing: int = 0, extra: int = 0, seed: Sequence[int] = ()):
        super().__init__(scene, points)
        rng = np.random.default_rng([*seed, 1])
        self._missing = rng.permutation(len(self.world.body))[:missing]
        self._shares: NDArray[np.float64] = rng.random((extra, 3))

    @classmethod
    def open(cls, sensor: str, scene: Scene, points: int, size: float = 1.0, **others: Any) -> SimulatedEyes:
        """Open these eyes for a session, with a learner of this size."""
        eyes = cls(scene, points, **others)
        resize(eyes.world, size)
        return eyes

    def demo_images(self, theta: Angles) -> tuple[NDArray, NDArray]:
        points, visible = super().demo_images(theta)
        visible = visible.copy()
        visible[self._missing] = False
        body = self.world.points_world(theta, self.world.T_world_demo)
        low, high = body.min(0), body.max(0)
        images, seen = self.world.demo_pair.project(low + self._shares * (high - low))
        return np.concatenate([points, np.concatenate(list(images), 1)]), np.concatenate([visible, seen.T])

    def own_images(self, theta: Angles) -> tuple[NDArray, NDArray]:
        points, visible = super().own_images(theta)
        extra = len(self._shares)
        return np.concatenate([points, np.zeros((extra, 4))]), np.concatenate([visible, np.zeros((extra, 2), bool)])
