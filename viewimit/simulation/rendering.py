"""Pictures of both arms in a plain room, rendered by PyBullet, and image points detected in them.

Only detections and the motion of arms with mass reach the method.
"""

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..estimation.views import VIEWS
from ..sensing.detection import Detections, detect, reject_partly_hidden
from .camera import Camera
from .disturbances import ActuatorSettings, ArmDisturbance, drive
from .physics import Arm, BulletClient, connect, quiet, write_urdf
from .robot import Angles, load_markers
from .scene import Base, Scene
from .world import World

NEAR_M, FAR_M = 0.05, 20.0
SAMPLES = 2  # for each pixel and axis, as a sensor gathers light over the whole pixel
PEDESTAL_M = 0.16  # half the width
MARGIN_M, HEIGHT_M, THICK_M = 2.5, 3.0, 0.05  # of the room, around the bases and the head
FLOOR_GREY, WALL_GREY, PEDESTAL_GREY = 0.55, 0.8, 0.4
SEARCHED_WIDTH = 0.56  # fraction of a picture's width: the head turns to the body that it watches
MAX_FACE_DEPTH = 1.2  # from a ball's centre to the nearest visible surface, in radii
NOISE_PX = 0.08  # standard deviation of a coordinate, as `viewimit bench pictures` measures it
LIGHT = {
    "lightDirection": (-1.5, 0.5, 3.0),
    "lightColor": (1.0, 1.0, 1.0),
    "lightAmbientCoeff": 0.55,
    "lightDiffuseCoeff": 0.4,
    "lightSpecularCoeff": 0.0,
    "shadow": 0,
}


Floats = NDArray[np.float64]
Visible = NDArray[np.bool_]
Picture = NDArray[np.uint8]
Colours = NDArray[np.uint32]


class Studio:
    """A room in which an arm stands at each of two bases.

    The room is rendered once for each camera, and the arms are drawn over it where they are nearer. `arms` and `room`
    are the two PyBullet clients.
    """

    def __init__(self, scene: Scene, urdf: Path):
        self.arms: Any = connect()
        self.room: Any = connect()
        self._bodies = [self._stand(urdf, base) for base in (scene.demonstrator, scene.learner)]
        joints = range(self.arms.getNumJoints(self._bodies[0]))
        revolute = self.arms.JOINT_REVOLUTE
        self._joints = [k for k in joints if self.arms.getJointInfo(self._bodies[0], k)[2] == revolute]
        self._build_room(scene)
        self._empty: dict[bytes, tuple[Colours, NDArray[np.float32], Picture]] = {}  # rays, depths, picture of the room

    def pose(self, theta_demo: Floats, theta_own: Floats) -> None:
        """Place both arms at postures, (m,) rad each."""
        for body, theta in zip(self._bodies, (theta_demo, theta_own)):
            for joint, angle in zip(self._joints, theta, strict=True):
                self.arms.resetJointState(body, joint, float(angle))

    def picture(self, camera: Camera) -> Picture:
        """Render (height, width, 3) RGB, each pixel the mean of SAMPLES² rays."""
        key = camera.T_world_camera.tobytes()
        if key not in self._empty:
            room, depth = _render(self.room, camera)
            self._empty[key] = room, depth, _mean(room)
        (arms, depth), (room, room_depth, empty) = _render(self.arms, camera), self._empty[key]
        nearer, picture = depth < room_depth, empty.copy()
        if nearer.any():  # elsewhere the picture is that of the empty room
            rows, columns = (_pixel_range(np.asarray(nearer.any(axis))) for axis in (1, 0))
            rays = tuple(slice(SAMPLES * part.start, SAMPLES * part.stop) for part in (rows, columns))
            picture[rows, columns] = _mean(np.where(nearer[rays], arms[rays], room[rays]))
        return picture

    def depth_m(self, camera: Camera) -> Floats:
        """Return the depth of the arms without the room, (SAMPLES height, SAMPLES width) m."""
        _, depth = _render(self.arms, camera)
        return FAR_M * NEAR_M / (FAR_M - depth.astype(float) * (FAR_M - NEAR_M))

    def _stand(self, urdf: Path, base: Base) -> int:
        half = np.radians(base.yaw_deg) / 2
        with quiet():
            return self.arms.loadURDF(str(urdf), base.position, (0, 0, np.sin(half), np.cos(half)), useFixedBase=True)

    def _build_room(self, scene: Scene) -> None:
        bases = (scene.demonstrator, scene.learner)
        places = np.array([scene.head.position, *(base.position for base in bases)])
        low, high = places.min(0) - MARGIN_M, places.max(0) + MARGIN_M
        (x, y), (half_x, half_y) = (low + high)[:2] / 2, (high - low)[:2] / 2
        self._box((x, y, -THICK_M), (half_x, half_y, THICK_M), FLOOR_GREY)
        for side in (-1, 1):
            wall_x, wall_y = x + side * (half_x + THICK_M), y + side * (half_y + THICK_M)
            self._box((wall_x, y, HEIGHT_M / 2), (THICK_M, half_y, HEIGHT_M / 2), WALL_GREY)
            self._box((x, wall_y, HEIGHT_M / 2), (half_x, THICK_M, HEIGHT_M / 2), WALL_GREY)
        for base in bases:
            x, y, height = base.position
            if height > 0:
                self._box((x, y, height / 2), (PEDESTAL_M, PEDESTAL_M, height / 2), PEDESTAL_GREY)

    def _box(self, centre: Sequence[float], half: Sequence[float], grey: float) -> None:
        colour = (grey, grey, grey, 1)
        shape = self.room.createVisualShape(self.room.GEOM_BOX, halfExtents=[float(m) for m in half], rgbaColor=colour)
        self.room.createMultiBody(0, -1, shape, [float(m) for m in centre])


def _render(client: BulletClient, camera: Camera) -> tuple[Colours, NDArray[np.float32]]:
    """Packed RGBA colours and depths in 0 … 1 of all samples, (SAMPLES height, SAMPLES width) each."""
    view, projection = opengl_matrices(camera, SAMPLES)
    width, height = SAMPLES * camera.width, SAMPLES * camera.height
    options = {"renderer": client.ER_TINY_RENDERER, "flags": client.ER_NO_SEGMENTATION_MASK, **LIGHT}
    _, _, colours, depth, _ = client.getCameraImage(width, height, view, projection, **options)
    colours = np.ascontiguousarray(colours, np.uint8).view(np.uint32)  # a flat tuple if built without numpy
    return colours.reshape(height, width), np.asarray(depth, np.float32).reshape(height, width)


def _mean(rays: Colours) -> Picture:
    """Mean over each pixel, rounded: (SAMPLES h, SAMPLES w) packed colours -> (h, w, 3)."""
    colours = np.ascontiguousarray(rays)[..., None].view(np.uint8)[..., :3]
    total = np.full((rays.shape[0] // SAMPLES, rays.shape[1] // SAMPLES, 3), SAMPLES**2 // 2, np.uint16)
    for row in range(SAMPLES):
        for column in range(SAMPLES):
            total += colours[row::SAMPLES, column::SAMPLES]
    return (total // SAMPLES**2).astype(np.uint8)


def _pixel_range(hit: NDArray[np.bool_]) -> slice:
    """Pixels from the first to the last whose rays are hit: (SAMPLES n,) bool -> slice."""
    where = np.flatnonzero(hit)
    return slice(int(where[0]) // SAMPLES, int(where[-1]) // SAMPLES + 1)


def opengl_matrices(camera: Camera, samples: int) -> tuple[list[float], list[float]]:
    """Return OpenGL's view and projection matrices, column by column, for `samples` rays in each pixel and axis.

    The renderer sends each ray through the upper right corner of its sample instead of the centre. The projection
    shifts by half a sample, so that points are drawn where `Camera.project` puts them.
    """
    width, height, half = camera.width, camera.height, 0.5 / samples
    view = np.diag([1.0, -1.0, -1.0, 1.0]) @ np.linalg.inv(camera.T_world_camera)
    projection = np.zeros((4, 4))
    (fx, fy), (cx, cy) = camera.lens.focal, camera.lens.centre
    projection[0, 0], projection[1, 1] = 2 * fx / width, 2 * fy / height
    projection[0, 2] = 1 - 2 * (cx - half) / width
    projection[1, 2] = 2 * (cy + half) / height - 1
    projection[2, 2:] = -(FAR_M + NEAR_M) / (FAR_M - NEAR_M), -2 * FAR_M * NEAR_M / (FAR_M - NEAR_M)
    projection[3, 2] = -1
    return view.T.ravel().tolist(), projection.T.ravel().tolist()


class RenderedEyes:
    """Detects marked points in rendered pictures, and moves arms with mass. See `SimulatedEyes`.

    Attributes
    ----------
    pictures, detections : dict
        The latest picture by view l, r, L, R, (height, width, 3) RGB, and the markers detected in it.
    theta : dict
        By pair of views, the posture (m,) rad at which its arm was last seen; at first `rest`.
    """

    noise_px = NOISE_PX

    def __init__(self, scene: Scene):
        self.markers = load_markers(scene.robot)
        self.world = World(scene, body=self.markers.body)
        with tempfile.TemporaryDirectory() as folder:
            urdf = write_urdf(scene, self.markers, Path(folder))
            self._arm, self._studio = Arm(urdf), Studio(scene, urdf)
        self._cameras: dict[str, Camera] = dict(zip(VIEWS, (*self.world.demo_cameras, *self.world.own_cameras)))
        rest = np.radians(scene.posture_deg)[scene.moving]
        self.rest = {"lr": rest, "LR": rest}
        self.theta = dict(self.rest)
        self.pictures: dict[str, Picture] = {}
        self.detections: dict[str, Detections] = {}

    def demo_images(self, theta: Angles) -> tuple[Floats, Visible]:
        return self._images("lr", theta)

    def own_images(self, theta: Angles) -> tuple[Floats, Visible]:
        return self._images("LR", theta)

    def settle(self, theta: Floats) -> Floats:
        return self._arm.drive(theta, theta)

    def drive(self, settings: ActuatorSettings, theta: Floats, sent: Floats, commanded: Floats) -> Floats:
        """The disturbed command is the goal of the motors; `sent` is not used."""
        scene = self.world.scene
        goal = drive(settings.amounts(ArmDisturbance), settings.start_rad, commanded)
        return self._arm.drive(theta, np.clip(goal, scene.lower, scene.upper))

    def look(self, view: str) -> Picture:
        """Render one view, detect its markers, and return the picture."""
        self._studio.pose(self.theta["lr"], self.theta["LR"])
        self.pictures[view] = self._studio.picture(self._cameras[view])
        self.detections[view] = detect(self.pictures[view], self.markers.hue_deg, SEARCHED_WIDTH)
        return self.pictures[view]

    def look_at(self, pair: str) -> None:
        """Render a pair of views and detect the markers that are not partly hidden in either."""
        for view in pair:
            self.look(view)
        both = reject_partly_hidden(*(self.detections[view] for view in pair))
        self.detections.update(zip(pair, both))

    def truth(self, view: str) -> tuple[Floats, Visible]:
        """Return the true image of each ball, (N, 2) px, and whether the centre of its face is visible, (N,).

        Visibility is decided by the renderer's depth. For benchmarks and tests.
        """
        pair = "lr" if view in "lr" else "LR"
        base = self.world.T_world_demo if pair == "lr" else self.world.T_world_own
        camera = self._cameras[view]
        points = self.world.points_world(self.theta[pair], base)
        image, inside = camera.project(points.T)
        self._studio.pose(self.theta["lr"], self.theta["LR"])
        surface = self._studio.depth_m(camera)
        last = np.array(surface.shape) - 1
        row, column = np.clip((SAMPLES * image[::-1]).astype(int), 0, last[:, None])
        depth = (points - camera.T_world_camera[:3, 3]) @ camera.T_world_camera[:3, 2]
        return image.T, inside & (np.abs(surface[row, column] - depth) < MAX_FACE_DEPTH * self.markers.radius)

    def _images(self, pair: str, theta: Angles) -> tuple[Floats, Visible]:
        """Images at one posture after another, for m arrays broadcast against each other."""
        theta = np.stack(np.broadcast_arrays(*theta), -1)
        points, visible = [], []
        for posture in theta.reshape(-1, theta.shape[-1]):
            self.theta[pair] = posture
            self.look_at(pair)
            points.append(np.concatenate([self.detections[view].points for view in pair], -1))
            visible.append(np.stack([self.detections[view].found for view in pair], -1))
        shape = theta.shape[:-1] + (len(self.world.body),)
        return np.array(points).reshape((*shape, 4)), np.array(visible).reshape((*shape, 2))
