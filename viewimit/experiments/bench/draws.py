"""Bodies, postures and scenes drawn at random for the benchmarks.

- Points on the surface of the robot's links (`surface_points`), seen where it faces the camera (`SurfaceEyes`).
- Markers that are symmetric about the arm's plane (`draw_marked_arm`). The iiwa moves in that plane, and its axes lie
  on one line when it is stretched. With pairs of markers at both ends of the axes the posture -θ is, point by point,
  the mirror image of θ, which affine and projective maps allow. The Panda turns out of the plane, by joints whose
  limits allow θ and -θ; with markers in the plane -θ is the mirror image again.
- A demonstrator near or far, moved along the line of sight, and a short or long baseline (`draw_distant_scene`).
- Scenes about the shipped ones (`draw_scene`): robot, head, baseline, bases, yaws and points. Both arms are in all four
  images over the whole range. Heads have two equal, parallel cameras, or any: toed in, with unlike lenses, and a
  learner of another size.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, lru_cache

import msgspec
import numpy as np
from numpy.typing import NDArray

from ...simulation.camera import Camera
from ...simulation.eyes import SimulatedEyes, open_eyes
from ...simulation.robot import Angles, BodyPoints, link_meshes, load_robot
from ...simulation.scene import Eye, Head, Scene, load_scene
from ...simulation.world import World

MAX_BODIES = 200  # drawn until one has enough points in sight at both ends
DEMO_DEG = 20.0  # of a demonstrator from the scene's own posture, if starts are drawn about it

MARKER_SIDE_M = 0.07  # of a pair's markers from its axis
MARKER_ALONG_M = 0.03  # of a pair along the stretched arm, at most
MARKER_OFFSET_M = 0.002, 0.010  # of a marker from exact symmetry
EXACT_SHARE = 0.5  # of the symmetric bodies
X, Y, Z = range(3)  # of the arm's base; the plane of the stretched arm is that of X and Z

DISTANT_SCENE, DISTANT_POINTS = "panda", 16
DISTANCE_M = 0.6, 6.0  # on the ground, from the head to the demonstrator's base
DISTANT_BASELINE_M = 0.05, 0.60

ROBOTS = "panda", "iiwa"
HEAD_M, BASE_M, BASELINE_M, YAW_DEG = 0.25, (0.15, 0.15, 0.045), (0.3, 0.8), 45.0
POINT_COUNTS = 8, 10, 16
FIRST_MIDDLE_LINK, FIRST_OUTER_LINK = 2, 4
MIN_POINTS_PER_PART = 2  # below, between and beyond these links
CHECKED_POSTURES = 64  # in which all points must be seen
ANY_HEAD_POINTS, SIZES = (10, 40), (0.8, 1.2)  # for any head: number of points, and the learner's size
TOE_IN_DEG, ZOOM, ASPECT, OFFSET_PX = (0.0, 20.0), (0.75, 1.15), (0.9, 1.1), 15.0


def draw_postures(scene: Scene, rng: np.random.Generator, offset_deg: float | None = None) -> dict[str, tuple]:
    """Draw demonstrator and start, as fields of `Settings`.

    Both are uniform over the range. With offset_deg the demonstrator is within DEMO_DEG of the scene's own posture, and
    the start so far from the demonstrator, at most, in each joint.
    """
    low, high = np.transpose(scene.range_deg)
    if offset_deg is None:
        demo, start = rng.uniform(low, high, (2, len(low)))
    else:
        rest = np.array(scene.posture_deg)[scene.moving]
        demo = np.clip(rest + rng.uniform(-DEMO_DEG, DEMO_DEG, len(low)), low, high)
        start = np.clip(demo + rng.uniform(-offset_deg, offset_deg, len(low)), low, high)
    return {"demonstrator_deg": tuple(demo.tolist()), "start_deg": tuple(start.tolist())}


def shared_eyes(sensor: str, scene: Scene, points: int) -> SimulatedEyes:
    """Open eyes as `open_eyes`. Those that project points keep nothing of a run, so runs share them."""
    if sensor != "projected":
        return open_eyes(sensor, scene, points)
    return _projected(msgspec.msgpack.encode(scene), points)


@lru_cache(2)
def _projected(scene: bytes, points: int) -> SimulatedEyes:
    return SimulatedEyes(msgspec.msgpack.decode(scene, type=Scene), points)


class SurfaceEyes(SimulatedEyes):
    """Points on the robot's surface, hidden where it is turned away from the camera.

    scene: `body` takes the place of its layouts; body: N points; normals: (N, 3), unit normals in the links' frames,
    None if all points are seen; hidden: a point is hidden up to this cosine of the angle between its normal and the
    direction to a camera.
    """

    def __init__(self, scene: Scene, body: BodyPoints, normals: NDArray[np.float64] | None, hidden: float = 0.0):
        super().__init__(scene, body=body)
        self._hidden = hidden
        self._normal_ends = None if normals is None else World(scene, body=BodyPoints(body.link, body.local + normals))

    def demo_images(self, theta: Angles) -> tuple[NDArray, NDArray]:
        images, visible = super().demo_images(theta)
        return images, visible & self._facing(theta, self.world.T_world_demo, self.world.demo_cameras)

    def own_images(self, theta: Angles) -> tuple[NDArray, NDArray]:
        images, visible = super().own_images(theta)
        return images, visible & self._facing(theta, self.world.T_world_own, self.world.own_cameras)

    def _facing(self, theta: Angles, T_world_base: NDArray, cameras: Sequence[Camera]) -> NDArray:
        """Which points face which camera: (N, 2)."""
        if self._normal_ends is None:
            return np.ones((len(self.world.body), len(cameras)), bool)
        points = self.world.points_world(theta, T_world_base)
        normals = self._normal_ends.points_world(theta, T_world_base) - points
        to_camera = [camera.T_world_camera[:3, 3] - points for camera in cameras]
        facing = [(normals * to).sum(-1) / np.linalg.norm(to, axis=-1) for to in to_camera]
        return np.stack(facing, -1) > self._hidden


def surface_points(
    robot: str, links: Sequence[int], count: int, rng: np.random.Generator
) -> tuple[BodyPoints, NDArray[np.float64]]:
    """Draw points evenly over the surface of these links, and return the unit normals there, (count, 3)."""
    corners, normals, areas, link = _faces(robot)
    among = np.flatnonzero(np.isin(link, links))
    chosen = rng.choice(among, count, p=areas[among] / areas[among].sum())
    weights = rng.dirichlet(np.ones(3), count)
    return BodyPoints(link[chosen], np.einsum("nc,ncx->nx", weights, corners[chosen])), normals[chosen]


@cache
def _faces(robot: str) -> tuple[NDArray, NDArray, NDArray, NDArray]:
    """Triangles of all links: corners (f, 3, 3) m, normals (f, 3), areas (f,), links (f,)."""
    meshes = link_meshes(robot).items()
    corners = np.concatenate([mesh.triangles for _, mesh in meshes])
    normals = np.concatenate([mesh.face_normals for _, mesh in meshes])
    areas = np.concatenate([mesh.area_faces for _, mesh in meshes])
    return corners, normals, areas, np.concatenate([np.full(len(mesh.faces), link) for link, mesh in meshes])


ARMS = (  # text of a scene file, and the axis along which the two markers of a pair differ: across the arm's plane, or
    # in it; the other joints are at 0, or turn about axes across the plane
    (
        'extends = "iiwa"\nrange_deg = [[-50, 50], [-100, 100]]\nstart_deg = [-20, 30]\n'
        "posture_deg = [0, 30, 0, -40, 0, 0, 0]\n",
        Y,
    ),
    (
        'extends = "panda"\nmoving_joints = [3, 5]\nrange_deg = [[-60, 60], [-80, 80]]\nstart_deg = [-20, 30]\n'
        "posture_deg = [0, 45, 30, -90, -40, 90, 0]\n",
        X,
    ),
    (
        'extends = "iiwa"\nmoving_joints = [2, 4, 6]\nrange_deg = [[-50, 50], [-90, 90], [-90, 90]]\n'
        "start_deg = [-20, 30, 20]\nposture_deg = [0, 30, 0, -40, 0, 30, 0]\n",
        Y,
    ),
)


def draw_marked_arm(rng: np.random.Generator, symmetric: bool) -> tuple[str, BodyPoints]:
    """Draw the text of a scene, and a pair of markers at the arm's base and at each joint, one after the other.

    symmetric: about the arm's plane, exactly or with each marker moved by 2 to 10 mm. False: each anywhere across the
    plane, within MARKER_SIDE_M.
    """
    text, pair_axis = ARMS[rng.choice(len(ARMS))]
    return text, _markers(load_scene(text), pair_axis, rng, symmetric)


def _markers(scene: Scene, pair_axis: int, rng: np.random.Generator, symmetric: bool) -> BodyPoints:
    robot = load_robot(scene.robot)
    stretched = np.radians(scene.posture_deg)
    stretched[scene.moving] = 0.0
    frames = robot.link_frames(stretched)
    links = np.repeat(np.arange(len(frames)), 2)
    frames = frames[links]
    places, sides = frames[:, :3, 3].copy(), MARKER_SIDE_M * np.tile([1.0, -1.0], len(links) // 2)
    places[:, pair_axis] += sides
    places[:, Z] += np.repeat(rng.uniform(-MARKER_ALONG_M, MARKER_ALONG_M, len(links) // 2), 2)
    off = rng.normal(size=places.shape)
    off *= rng.uniform(*MARKER_OFFSET_M) / np.linalg.norm(off, axis=1, keepdims=True)
    if not symmetric:
        places[:, Y] = sides * rng.uniform(-1, 1, len(places))
    elif rng.random() > EXACT_SHARE:
        places += off
    return BodyPoints(links, np.einsum("nji,nj->ni", frames[:, :3, :3], places - frames[:, :3, 3]))


def draw_distant_scene(rng: np.random.Generator) -> str:
    """Draw a scene's text; distance and baseline are uniform on a logarithmic scale."""
    distance, baseline = (float(np.exp(rng.uniform(*np.log(span)))) for span in (DISTANCE_M, DISTANT_BASELINE_M))
    return distant_scene(distance, baseline)


def distant_scene(distance_m: float, baseline_m: float) -> str:
    """Return the text of DISTANT_SCENE with this distance of the demonstrator and this baseline."""
    scene = load_scene(DISTANT_SCENE)
    head, base, gaze = map(np.array, (scene.head.position, scene.demonstrator.position, scene.head.gaze_demonstrator))
    away = base[:2] - head[:2]
    shift = (distance_m / np.linalg.norm(away) - 1) * np.append(away, 0.0)
    return (
        f'extends = "{DISTANT_SCENE}"\n'
        f"[head]\nbaseline = {baseline_m}\ngaze_demonstrator = {(gaze + shift).tolist()}\n"
        f"[demonstrator]\nposition = {(base + shift).tolist()}\n"
    )


@dataclass(frozen=True)
class DrawnScene:
    """A random scene."""

    scene: Scene
    points: int  # of the scene's new layout
    size: float = 1.0  # of the learner, relative to the robot's


def draw_scene(rng: np.random.Generator, any_head: bool = False) -> DrawnScene:
    """Draw scenes until one has both arms in all four images."""
    while True:
        drawn = _drawn(rng, any_head)
        world = World(drawn.scene, drawn.points)
        resize(world, drawn.size)
        if _all_seen(world, rng):
            return drawn


def open_resized(camera: str, scene: Scene, points: int, size: float) -> SimulatedEyes:
    """Open eyes that see a learner of this size."""
    eyes = SimulatedEyes(scene, points)
    resize(eyes.world, size)
    return eyes


def resize(world: World, size: float) -> None:
    """Scale the learner's points about its base."""
    world.T_world_own = world.T_world_own @ np.diag([size, size, size, 1.0])


def _drawn(rng: np.random.Generator, any_head: bool) -> DrawnScene:
    scene = load_scene(str(rng.choice(ROBOTS)))
    known = list(dict.fromkeys(point for layout in scene.points.values() for point in layout))
    if any_head:
        points = int(rng.integers(ANY_HEAD_POINTS[0], ANY_HEAD_POINTS[1] + 1))
        known = _with_points_between(known, rng)
    else:
        points = int(rng.choice([count for count in POINT_COUNTS if count <= len(known)]))
    shifts = rng.uniform(-1, 1, (2, 3)) * BASE_M
    yaws = rng.uniform(-YAW_DEG, YAW_DEG, 2)
    bases = {}
    for name, shift, yaw in zip(("demonstrator", "learner"), shifts, yaws):
        base = getattr(scene, name)
        bases[name] = msgspec.structs.replace(base, position=_moved(base.position, shift), yaw_deg=float(yaw))
    head = msgspec.structs.replace(
        scene.head,
        position=_moved(scene.head.position, rng.uniform(-HEAD_M, HEAD_M, 3)),
        baseline=float(rng.uniform(*BASELINE_M)),
        gaze_demonstrator=_moved(scene.head.gaze_demonstrator, shifts[0]),
        gaze_learner=_moved(scene.head.gaze_learner, shifts[1]),
    )
    layouts = {**scene.points, str(points): _layout(known, points, rng)}
    scene = msgspec.structs.replace(scene, title="random", head=head, points=layouts, **bases)
    if not any_head:
        return DrawnScene(scene, points)
    return DrawnScene(
        msgspec.structs.replace(scene, head=_with_any_cameras(head, rng)), points, float(rng.uniform(*SIZES))
    )


def _with_any_cameras(head: Head, rng: np.random.Generator) -> Head:
    """Toe the cameras in, and draw a lens for each: focal length, aspect ratio, centre."""
    eyes = {}
    for side in ("left", "right"):
        across = head.focal * float(rng.uniform(*ZOOM))
        focal = across, across * float(rng.uniform(*ASPECT))
        x, y = _moved(head.centre, rng.uniform(-OFFSET_PX, OFFSET_PX, 2))
        eyes[side] = Eye(focal, (x, y))
    return msgspec.structs.replace(head, toe_in_deg=float(rng.uniform(*TOE_IN_DEG)), **eyes)


def _with_points_between(known: list[tuple], rng: np.random.Generator) -> list[tuple]:
    """Add points between two on the same link, until there are twice as many as a layout may have."""
    points = dict.fromkeys(known)
    while len(points) < 2 * ANY_HEAD_POINTS[1]:
        link, *first = known[int(rng.integers(len(known)))]
        others = [point[1:] for point in known if point[0] == link and list(point[1:]) != first]
        if others:
            second, share = others[int(rng.integers(len(others)))], rng.uniform()
            new = link, *(np.array(first) + share * (np.array(second) - first)).tolist()
            points[new] = None
    return list(points)


def _layout(points: list[tuple], count: int, rng: np.random.Generator) -> tuple[tuple, ...]:
    """Draw a layout with points on the lower, the middle and the outer links."""
    while True:
        chosen = tuple(points[k] for k in sorted(rng.permutation(len(points))[:count]))
        link = np.array([point[0] for point in chosen])
        parts = np.bincount(np.digitize(link, (FIRST_MIDDLE_LINK, FIRST_OUTER_LINK)), minlength=3)
        if parts.min() >= MIN_POINTS_PER_PART:
            return chosen


def _all_seen(world: World, rng: np.random.Generator) -> bool:
    theta = rng.uniform(world.scene.lower, world.scene.upper, (CHECKED_POSTURES, len(world.scene.lower))).T
    return bool(world.demo_images(theta)[1].all() and world.own_images(theta)[1].all())


def _moved(position: Sequence[float], shift: NDArray) -> tuple[float, ...]:
    return tuple((np.array(position) + shift).tolist())
