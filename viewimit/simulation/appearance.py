"""What both arms look like in the four views, as plain arrays for whoever draws them: silhouettes, skeletons, and
where their points may be. The truth, for viewers only.

A silhouette is the hull of each link. Its support function is the largest projection onto a direction. Few directions,
and the vertex that is extreme in each, give a polygon inside the hull that lacks at most 2 px at its corners.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..estimation.transfers import FittedTransfer
from .camera import Cameras
from .world import World

DIRECTIONS = 12  # corners of a polygon at most
NEAR = 0.05  # m, to which what is nearer to a camera is set back
KEPT = 48  # directions in 3-D in which a link's vertices are kept
POSTURES_A_JOINT, POSTURES = 9, 200  # of the grid with two joints; drawn at random with more
NEAR_POSTURE = np.radians(20)  # a joint, with more of them


class Moment(Protocol):
    """The postures of both arms at one time, and the transfer fitted then."""

    @property
    def theta(self) -> NDArray[np.float64]:
        """(m,) learner's posture [rad]."""
        ...

    @property
    def theta_demo(self) -> NDArray[np.float64]:
        """(m,) demonstrator's posture [rad]."""
        ...

    @property
    def transfer(self) -> FittedTransfer | None:
        """None if there are too few points to fit one."""
        ...


@dataclass(frozen=True, eq=False)
class ArmImages:
    """An arm in its two images. hulls: (2, links, DIRECTIONS, 2) px, closed polygons whose corners may repeat;
    origins: (2, n + 1, 2) px, of all links; memory: whatever those who draw it want to keep with it."""

    hulls: NDArray
    origins: NDArray
    memory: dict[Any, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Bodies:
    """What is seen of both arms. demo: in l, r; own: in L, R; recovered: (2, n + 1, 2) px, what the transfer makes in
    L, R of the demonstrator's links, None without one; frame: width and height of the images, px."""

    demo: ArmImages
    own: ArmImages
    recovered: NDArray | None
    frame: tuple[int, int]


class Silhouettes:
    """Polygons and skeletons of arms. meshes: by link (0 = base), vertices (V, 3) m in the link's frame.

    Without meshes, as of a robot from a user's own URDF, there are skeletons only.
    """

    def __init__(self, meshes: Mapping[int, NDArray], world: World):
        self._world = world
        self._links = np.array(sorted(meshes), int)
        chosen = {link: extreme_vertices(np.asarray(meshes[link], float)) for link in self._links.tolist()}
        most = max(map(len, chosen.values()), default=1)
        # of every link its origin and its vertices, (n + 1, 1 + most, 4), the last coordinate 1; short lists are filled
        # up with their first vertex, which changes no hull
        self._vertices = np.zeros((len(world.robot.joints) + 1, 1 + most, 4))
        self._vertices[..., 3] = 1.0
        for link, vertices in chosen.items():
            self._vertices[link, 1:, :3] = vertices[0]
            self._vertices[link, 1 : 1 + len(vertices), :3] = vertices
        self._pair, self._link = np.ogrid[:2, : len(chosen), :1][:2]
        self._latest: dict[str, tuple[bytes, ArmImages]] = {}  # by arm: the demonstrator rests while the learner moves

    def bodies(self, snapshot: Moment) -> Bodies:
        """Both arms where they are in truth. Of an arm that has not moved they are the same object as before."""
        world = self._world
        demo = self._arm("demonstrator", snapshot.theta_demo, world.T_world_demo, world.demo_pair)
        own = self._arm("learner", snapshot.theta, world.T_world_own, world.own_pair)
        found = None
        if snapshot.transfer is not None:
            recovered = snapshot.transfer.recover(demo.origins[0], demo.origins[1])
            found = np.stack([recovered[:, :2], recovered[:, 2:]])
        return Bodies(demo, own, found, world.scene.head.image)

    def _arm(self, arm: str, theta: NDArray, T_world_base: NDArray, cameras: Cameras) -> ArmImages:
        key, latest = theta.tobytes(), self._latest.get(arm)
        if latest is None or latest[0] != key:
            seen = self.seen(self._world.link_frames(theta, T_world_base), cameras)
            latest = self._latest[arm] = key, ArmImages(*seen)
        return latest[1]

    def seen(self, T_world_links: NDArray, cameras: Cameras) -> tuple[NDArray, NDArray]:
        """By a stereo pair: closed polygons of the links, (2, links, DIRECTIONS, 2) px, whose corners may repeat, and
        the origins of all links, (2, n + 1, 2) px."""
        images = cameras.images_on(T_world_links, self._vertices, NEAR)
        corners = images[:, self._links, 1:]
        largest = (corners @ _COMPASS.T).argmax(2)  # (2, links, DIRECTIONS)
        return corners[self._pair, self._link, largest], images[:, :, 0]


def extreme_vertices(vertices: NDArray) -> NDArray:
    """Those that reach farthest in some of KEPT directions spread over the sphere (Fibonacci's spiral)."""
    i = np.arange(KEPT) + 0.5
    z, turn = 1 - 2 * i / KEPT, np.pi * (1 + 5**0.5) * i
    level = np.sqrt(1 - z * z)
    directions = np.stack([level * np.cos(turn), level * np.sin(turn), z])
    return vertices[np.unique((vertices @ directions).argmax(0))]


_ANGLES = 2 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
_COMPASS = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], -1)


def reachable_image_points(world: World, held: Sequence[NDArray] = ()) -> dict[str, NDArray]:
    """Where both arms' points can be: (k, 2) px by view.

    held: postures, (m,) rad. With more than two joints an arm reaches nearly everywhere, so that it is where the points
    are near these postures, not over the whole range.
    """
    theta = _postures(world, held)
    return _by_view(world.demo_images(theta), world.own_images(theta))


def arm_image_points(world: World, snapshot: Moment) -> dict[str, NDArray]:
    """Where both arms' points are, as they would be seen without noise: (k, 2) px by view."""
    return _by_view(world.demo_images(snapshot.theta_demo), world.own_images(snapshot.theta))


def _by_view(demo: tuple[NDArray, NDArray], own: tuple[NDArray, NDArray]) -> dict[str, NDArray]:
    points = {}
    for pair, (images, visible) in (("lr", demo), ("LR", own)):
        for side, view in enumerate(pair):
            points[view] = images[..., 2 * side : 2 * side + 2][visible[..., side]].reshape(-1, 2)
    return points


def _postures(world: World, held: Sequence[NDArray]) -> list[NDArray]:
    """The moving joints' angles, one flat array a joint: over the range of two, or near the postures to be held."""
    lower, upper = world.scene.lower, world.scene.upper
    if len(lower) <= 2:
        axes = [np.linspace(low, high, POSTURES_A_JOINT) for low, high in zip(lower, upper)]
        return [axis.ravel() for axis in np.meshgrid(*axes)]
    centres = np.array([np.radians(world.scene.posture_deg)[world.scene.moving], *held])
    near = np.random.default_rng(0).uniform(
        -NEAR_POSTURE, NEAR_POSTURE, (len(centres), -(-POSTURES // len(centres)), len(lower))
    )
    return list(np.clip(centres[:, None] + near, lower, upper).reshape(-1, len(lower)).T)
