"""Image points that were detected in pictures, and arms with weight: nothing else reaches the method."""

import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...estimation.views import VIEWS
from ...loop.settings import Settings
from ...sensing.detection import Detections, as_large_in_both, detect
from ..camera import Camera
from ..disturbances import ArmDisturbance, drive
from ..markers import load_markers
from ..physics.arm import Arm
from ..physics.model import write_urdf
from ..physics.studio import SAMPLES, Studio
from ..robot import Angles
from ..scene import Scene
from ..world import World

MIDDLE = 0.56  # of a picture's width: the head turns to the body that it watches, so that the other one is beyond
FACE = 1.2  # times its radius, from a ball's middle to the nearest of its surface in sight, at most
NOISE_PX = 0.08  # standard deviation of a coordinate, as `viewimit bench pictures` measures it


class RenderedEyes:
    """See `protocol.SimulatedEyes`. pictures: (height, width, 3) uint8 of the views l, r, L, R, as last taken, and
    what was detected in them, `detections`; theta: by pair of views, the posture (m,) rad in which its arm was last
    looked at, all that one look leaves to the next, at first `rest`."""

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
        self.pictures: dict[str, NDArray] = {}
        self.detections: dict[str, Detections] = {}

    def demo_images(self, theta: Angles) -> tuple[NDArray, NDArray]:
        return self._images("lr", theta)

    def own_images(self, theta: Angles) -> tuple[NDArray, NDArray]:
        return self._images("LR", theta)

    def settle(self, theta: NDArray) -> NDArray:
        return self._arm.drive(theta, theta)

    def drive(self, settings: Settings, theta: NDArray, sent: NDArray, commanded: NDArray) -> NDArray:
        """What the actuator makes of a command is where the motors are told to go; `sent` plays no part."""
        start, scene = settings.start_rad, self.world.scene
        told = drive(settings.amounts(ArmDisturbance), start, commanded)
        return self._arm.drive(theta, np.clip(told, scene.lower, scene.upper))

    def look(self, view: str) -> NDArray:
        """Take a picture of VIEWS with the arms as they stand → (height, width, 3) uint8, and detect its markers."""
        self._studio.pose(self.theta["lr"], self.theta["LR"])
        self.pictures[view] = self._studio.picture(self._cameras[view])
        self.detections[view] = detect(self.pictures[view], self.markers.hue_deg, MIDDLE)
        return self.pictures[view]

    def look_at(self, pair: str) -> None:
        """Take both pictures of a pair of views, and detect in both the markers that nothing hides a part of in one."""
        for view in pair:
            self.look(view)
        both = as_large_in_both(*(self.detections[view] for view in pair))
        self.detections.update(zip(pair, both))

    def truth(self, view: str) -> tuple[NDArray, NDArray]:
        """Where the view's balls are as the arms stand: (N, 2) px, and (N,) whether the middle of a ball's face is in
        sight, by the renderer's depth. For benchmarks and tests."""
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
        return image.T, inside & (np.abs(surface[row, column] - depth) < FACE * self.markers.radius)

    def _images(self, pair: str, theta: Angles) -> tuple[NDArray, NDArray]:
        """One after the other, if theta, m arrays broadcast against each other, says several postures."""
        theta = np.stack(np.broadcast_arrays(*theta), -1)
        points, visible = [], []
        for posture in theta.reshape(-1, theta.shape[-1]):
            self.theta[pair] = posture
            self.look_at(pair)
            points.append(np.concatenate([self.detections[view].points for view in pair], -1))
            visible.append(np.stack([self.detections[view].found for view in pair], -1))
        shape = theta.shape[:-1] + (len(self.world.body),)
        return np.array(points).reshape((*shape, 4)), np.array(visible).reshape((*shape, 2))
