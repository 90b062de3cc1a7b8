"""The arms in 3-D: meshes once on the server, poses a client. A mesh hangs under nested frames /robot/arm/j1/…/ji on
the server's scene. Each page adds frames of the same names on its own scene; they shadow the shared ones, and the
shared meshes follow them. So their colour is shared, too: one tint, near the role's in light and in dark, which each
page's own light makes darker. The opponent of a duel stands where the learner does, so one sees through it."""

import zlib
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from math import cos, sin

import numpy as np
from numpy.typing import NDArray
from viser import ClientHandle, ViserServer

from viewimit.drawing.theme import half_white, rgb
from viewimit.simulation.robot import link_meshes
from viewimit.simulation.scene import Scene
from viewimit.simulation.urdf.reference import is_reference
from viewimit.simulation.world import World

from ..viser_private import push_orientation
from .nodes import Nodes, quaternion

ALWAYS_SEEN = ("learner", "demonstrator")
OPACITY = {"learner": None, "demonstrator": None, "opponent": 0.35}
SHRUNK = 0.97  # of the see-through links' size, which so lie inside the learner's where both agree


def robot_root(scene: Scene, arm: str) -> str:
    """The node that carries an arm's base."""
    return f"/{_slug(scene.robot)}/{arm}"


def link_name(scene: Scene, arm: str, link: int) -> str:
    """The node that moves with a link; 0 is the base."""
    return robot_root(scene, arm) + "".join(f"/j{i}" for i in range(1, link + 1))


def share_meshes(server: ViserServer, robot: str, arm: str) -> None:
    """Put a robot's links on the server's scene, hidden until a page shows that arm. robot: as a scene names it."""
    shapes, opacity = link_meshes(robot), OPACITY[arm]
    name = f"/{_slug(robot)}/{arm}"
    server.scene.add_frame(name, show_axes=False, visible=False)
    for link in range(max(shapes) + 1):
        if link > 0:
            name += f"/j{link}"
            server.scene.add_frame(name, show_axes=False)
        if link not in shapes:
            continue
        mesh = shapes[link]
        middle = (mesh.vertices.min(0) + mesh.vertices.max(0)) / 2
        server.scene.add_mesh_simple(
            f"{name}/mesh",
            middle + SHRUNK * (mesh.vertices - middle) if opacity else mesh.vertices,
            mesh.faces,
            color=rgb(arm) if opacity else half_white(arm),
            opacity=opacity,
            side="double" if is_reference(robot) else "front",  # its meshes may be open, or inside out
            cast_shadow=opacity is None,
            receive_shadow=opacity is None,
        )


class Arm:
    """One arm of one page: its shadowing frames, turned at every draw."""

    def __init__(self, client: ClientHandle, nodes: Nodes, world: World, arm: str, T_world_base: NDArray):
        self._client, self._nodes = client, nodes
        self._robot, self._joints, self._moving = world.robot, world.robot.joints, world.scene.moving
        add = partial(client.scene.add_frame, show_axes=False)
        turn, position = quaternion(T_world_base[:3, :3]), T_world_base[:3, 3]
        self._frame = nodes.keep(add(robot_root(world.scene, arm), wxyz=turn, position=position))
        self._visible = True
        self._rest = [quaternion(joint.T_parent_joint[:3, :3]) for joint in self._joints]
        self._axes = [(joint.axis / np.linalg.norm(joint.axis)).tolist() for joint in self._joints]
        self._names = [link_name(world.scene, arm, i + 1) for i in range(len(self._joints))]
        self._angles = np.array(world.joint_angles(np.zeros(len(world.scene.moving))), float).tolist()
        for i, joint in enumerate(self._joints):
            nodes.keep(add(self._names[i], wxyz=self._turned(i), position=joint.T_parent_joint[:3, 3]))

    def draw(self, theta: NDArray) -> None:
        """theta: (m,) rad, of the moving joints. Only those that turned are sent."""
        for i, angle in self._turning(theta):
            if angle != self._angles[i]:
                self._angles[i] = angle
                push_orientation(self._client, self._names[i], self._turned(i))

    def _turning(self, theta: NDArray) -> Iterable[tuple[int, float]]:
        """Joints, from 0, that may have turned, and their angles, rad."""
        if not self._robot.has_mimics:
            return zip(self._moving, theta.tolist())
        angles = list(self._angles)
        for i, angle in zip(self._moving, theta.tolist()):
            angles[i] = angle
        return enumerate(np.array(self._robot.with_mimics(angles), float).tolist())

    def show(self, visible: bool) -> None:
        """Or hide it. viser's setter looks up types, which takes longer than the pose does."""
        if visible != self._visible:
            self._visible = self._frame.visible = visible

    def _turned(self, i: int) -> tuple[float, float, float, float]:
        return joint_quaternion(self._rest[i], self._axes[i], self._angles[i])


class Arms:
    """Those of one page in one world. share(robot, arm): puts meshes on the server's scene, before they are shown."""

    def __init__(self, client: ClientHandle, nodes: Nodes, world: World, share: Callable[[str, str], None]):
        self._share_opponent = partial(share, world.scene.robot, "opponent")
        for arm in ALWAYS_SEEN:
            share(world.scene.robot, arm)
        self._learner = Arm(client, nodes, world, "learner", world.T_world_own)
        self._demonstrator = Arm(client, nodes, world, "demonstrator", world.T_world_demo)
        self._opponent = Arm(client, nodes, world, "opponent", world.T_world_own)
        self._opponent.show(False)

    def draw(self, theta: NDArray, theta_demo: NDArray, theta_opponent: NDArray | None = None) -> None:
        """(m,) rad each. theta_opponent: None without a duel, which hides that arm."""
        self._learner.draw(theta)
        self._demonstrator.draw(theta_demo)
        if theta_opponent is not None:
            self._share_opponent()
            self._opponent.draw(theta_opponent)
        self._opponent.show(theta_opponent is not None)


def _slug(robot: str) -> str:
    """A node name from a robot's name or the path of its URDF, of which another one may differ in signs alone."""
    plain = "".join(c if c.isalnum() else "_" for c in robot)
    return plain if plain == robot else f"{plain}_{zlib.crc32(robot.encode()):08x}"


def joint_quaternion(
    T_parent_joint_wxyz: Sequence[float], axis: Sequence[float], angle: float
) -> tuple[float, float, float, float]:
    """Orientation of a joint's frame at `angle` rad: that of angle 0 times the turn about its axis, (3,)."""
    a, b, c, d = T_parent_joint_wxyz
    s, w = sin(angle / 2), cos(angle / 2)
    x, y, z = s * axis[0], s * axis[1], s * axis[2]
    return (
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    )
