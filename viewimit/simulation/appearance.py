"""What both arms look like in the four views: silhouettes, skeletons, and where their points can be.

This is ground truth, for viewers only. A silhouette is the convex hull of each link's image. The vertices that are
extreme in a few directions make a polygon inside the hull, at most 2 px smaller at its corners.
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
MIN_DEPTH_M = 0.05  # nearer vertices are moved back to it
HULL_DIRECTIONS = 48  # directions in 3-D in which a link's extreme vertices are kept
GRID_ANGLES, MIN_SAMPLES = 9, 200  # postures: angles for each of two joints; random samples for more joints
SAMPLE_RANGE_RAD = np.radians(20)  # of the random samples, about each posture

Floats = NDArray[np.float64]
Images = tuple[Floats, NDArray[np.bool_]]  # points (..., N, 4) px, visible (..., N, 2)


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
    """An arm in the two images of a stereo pair."""

    hulls: Floats  # (2, links, DIRECTIONS, 2) px, closed polygons whose corners may repeat
    origins: Floats  # (2, n + 1, 2) px, of all links
    memory: dict[Any, Any] = field(default_factory=dict)  # cache of the drawing code


@dataclass(frozen=True)
class Bodies:
    """Both arms in all four images."""

    demo: ArmImages  # in l, r
    own: ArmImages  # in L, R
    recovered: Floats | None  # (2, n + 1, 2) px in L, R: the demonstrator's links by the transfer, None without one
    frame: tuple[int, int]  # width and height of the images [px]


class Silhouettes:
    """Projects the polygons and skeletons of both arms.

    Parameters
    ----------
    meshes : mapping
        Vertices by link (0 = base), (V, 3) m in the link's frame. Without meshes there are skeletons only.
    world : World
    """

    def __init__(self, meshes: Mapping[int, Floats], world: World):
        self._world = world
        self._links = np.array(sorted(meshes), int)
        chosen = {link: extreme_vertices(np.asarray(meshes[link], float)) for link in self._links.tolist()}
        most = max(map(len, chosen.values()), default=1)
        # homogeneous origin and vertices of every link, (n + 1, 1 + most, 4); short lists repeat their first vertex
        self._vertices = np.zeros((len(world.robot.joints) + 1, 1 + most, 4))
        self._vertices[..., 3] = 1.0
        for link, vertices in chosen.items():
            self._vertices[link, 1:, :3] = vertices[0]
            self._vertices[link, 1 : 1 + len(vertices), :3] = vertices
        self._pair, self._link = np.ogrid[:2, : len(chosen), :1][:2]
        self._latest: dict[str, tuple[bytes, ArmImages]] = {}  # by arm: the demonstrator mostly stands still

    def bodies(self, moment: Moment) -> Bodies:
        """Return both arms at their true postures. The images of an arm that has not moved are the same object."""
        world = self._world
        demo = self._arm("demonstrator", moment.theta_demo, world.T_world_demo, world.demo_pair)
        own = self._arm("learner", moment.theta, world.T_world_own, world.own_pair)
        found = None
        if moment.transfer is not None:
            recovered = moment.transfer.recover(demo.origins[0], demo.origins[1])
            found = np.stack([recovered[:, :2], recovered[:, 2:]])
        return Bodies(demo, own, found, world.scene.head.image)

    def _arm(self, arm: str, theta: Floats, T_world_base: Floats, cameras: Cameras) -> ArmImages:
        key, latest = theta.tobytes(), self._latest.get(arm)
        if latest is None or latest[0] != key:
            seen = self.seen(self._world.link_frames(theta, T_world_base), cameras)
            latest = self._latest[arm] = key, ArmImages(*seen)
        return latest[1]

    def seen(self, T_world_links: Floats, cameras: Cameras) -> tuple[Floats, Floats]:
        """Return polygons (2, links, DIRECTIONS, 2) px and the links' origins (2, n + 1, 2) px in a stereo pair."""
        images = cameras.images_on(T_world_links, self._vertices, MIN_DEPTH_M)
        corners = images[:, self._links, 1:]
        largest = (corners @ _COMPASS.T).argmax(2)  # (2, links, DIRECTIONS)
        return corners[self._pair, self._link, largest], images[:, :, 0]


def extreme_vertices(vertices: Floats) -> Floats:
    """Return the vertices that are farthest in some direction of a Fibonacci spiral on the sphere: (V, 3) -> (K, 3)."""
    i = np.arange(HULL_DIRECTIONS) + 0.5
    z, turn = 1 - 2 * i / HULL_DIRECTIONS, np.pi * (1 + 5**0.5) * i
    level = np.sqrt(1 - z * z)
    directions = np.stack([level * np.cos(turn), level * np.sin(turn), z])
    return vertices[np.unique((vertices @ directions).argmax(0))]


_ANGLES = 2 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
_COMPASS = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], -1)


def reachable_image_points(world: World, held: Sequence[Floats] = ()) -> dict[str, Floats]:
    """Return image points of both arms over their range, (k, 2) px by view.

    With more than two joints an arm reaches nearly everywhere. So the postures are near the demonstrator's and near
    `held`, (m,) rad each.
    """
    theta = _sample_postures(world, held)
    return _by_view(world.demo_images(theta), world.own_images(theta))


def arm_image_points(world: World, moment: Moment) -> dict[str, Floats]:
    """Return the image points of both arms without noise, (k, 2) px by view."""
    return _by_view(world.demo_images(moment.theta_demo), world.own_images(moment.theta))


def _by_view(demo: Images, own: Images) -> dict[str, Floats]:
    points = {}
    for pair, (images, visible) in (("lr", demo), ("LR", own)):
        for side, view in enumerate(pair):
            points[view] = images[..., 2 * side : 2 * side + 2][visible[..., side]].reshape(-1, 2)
    return points


def _sample_postures(world: World, held: Sequence[Floats]) -> list[Floats]:
    """Angles of the moving joints, one flat array each: a grid over the range of two, or samples near `held`."""
    lower, upper = world.scene.lower, world.scene.upper
    if len(lower) <= 2:
        axes = [np.linspace(low, high, GRID_ANGLES) for low, high in zip(lower, upper)]
        return [axis.ravel() for axis in np.meshgrid(*axes)]
    centres = np.array([np.radians(world.scene.posture_deg)[world.scene.moving], *held])
    near = np.random.default_rng(0).uniform(
        -SAMPLE_RANGE_RAD, SAMPLE_RANGE_RAD, (len(centres), -(-MIN_SAMPLES // len(centres)), len(lower))
    )
    return list(np.clip(centres[:, None] + near, lower, upper).reshape(-1, len(lower)).T)
