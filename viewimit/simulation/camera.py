"""Lenses, cameras and the learner's stereo head.

Camera frames have OpenCV's axes: x to the right, y down, z forward.

References
----------
Hartley and Zisserman, Multiple View Geometry in Computer Vision, 2nd ed. 2004, chapters 6 and 7.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..geometry.arrays import Floats
from ..geometry.distortion import RadialDistortion
from ..geometry.rigid import look_rotation, rigid_transform, rotation_about_axis

WORLD = np.eye(4)


@dataclass(frozen=True)
class Lens:
    """Intrinsic parameters of a camera whose images may be corrected for radial distortion."""

    focal: tuple[float, float]  # focal lengths fx, fy [px]
    centre: tuple[float, float]  # principal point [px]
    distortion: RadialDistortion = RadialDistortion()  # of the lens
    correction: RadialDistortion = RadialDistortion()  # removed from the images, as calibrated

    @cached_property
    def is_distorted(self) -> bool:
        """Whether the corrected images differ from those of a pinhole camera."""
        return self.distortion != self.correction

    @property
    def aspect(self) -> float:
        """fy/fx, 1 for square pixels."""
        return self.focal[1] / self.focal[0]

    def stretch(self, squared: Floats) -> Floats:
        """Return the factor by which a pinhole image moves outwards, given its radius squared [focal lengths²]."""
        factor = self.distortion.factor(squared)
        return factor * self.correction.inverse_factor(squared * factor * factor) if self.correction.bends else factor

    def direction(self, image: Floats) -> Floats:
        """Return where the ray of a pixel meets the plane at depth 1: (..., 2) px -> (..., 2)."""
        on_plane = (image - self.centre) / self.focal
        if not self.is_distorted:
            return on_plane
        squared = (on_plane * on_plane).sum(-1)
        factor = self.correction.factor(squared)
        return on_plane * (factor * self.distortion.inverse_factor(squared * factor * factor))[..., None]

    def covers(self, image: Floats) -> bool:
        """Return whether every pixel, (..., 2) px, has a ray: beyond its rim a distorted image would fold back."""
        radius = np.hypot(*((image - self.centre) / self.focal).reshape(-1, 2).T)
        return bool((radius < min(self.distortion.max_distorted_radius, self.correction.max_radius)).all())


@dataclass(frozen=True)
class Camera:
    """A camera with a lens."""

    width: int  # px
    height: int  # px
    lens: Lens
    T_world_camera: Floats  # (4, 4), m

    def project(self, points: Floats, T_world_points: Floats = WORLD) -> tuple[Floats, NDArray[np.bool_]]:
        """Project many points, components first. points: (3, ...) points in a frame [m]; T_world_points: (4, 4) that
        frame. Returns (2, ...), image points [px], and whether they are in front of the camera and inside the image."""
        R_camera_world = self.T_world_camera[:3, :3].T
        rotation = R_camera_world @ T_world_points[:3, :3]
        offset = R_camera_world @ (T_world_points[:3, 3] - self.T_world_camera[:3, 3])
        in_camera = rotation @ points.reshape(3, -1)
        in_camera += offset[:, None]
        image, depth = in_camera[:2], in_camera[2]
        visible = depth > 0
        lens = self.lens
        with np.errstate(divide="ignore", invalid="ignore"):
            image *= np.divide(lens.focal[0], depth, out=depth)
            if lens.is_distorted:
                image *= lens.stretch((image * image).sum(0) / lens.focal[0] ** 2)
        if lens.aspect != 1:
            image[1] *= lens.aspect
        for coordinate, centre, size in zip(image, lens.centre, (self.width, self.height)):
            coordinate += centre
            visible &= coordinate >= 0
            visible &= coordinate <= size
        return image.reshape((2,) + points.shape[1:]), visible.reshape(points.shape[1:])

    def ray(self, image: ArrayLike) -> Floats:
        """Return the rays of pixels in the world, with depth 1: (..., 2) px -> (..., 3)."""
        image = np.asarray(image, float)
        if not self.lens.is_distorted:
            along, straight = self._linear_ray
            return image @ along + straight
        R_world_camera = self.T_world_camera[:3, :3]
        return self.lens.direction(image) @ R_world_camera[:, :2].T + R_world_camera[:, 2]

    @cached_property
    def _linear_ray(self) -> tuple[Floats, Floats]:
        """Derivative of a ray by x and y, (2, 3), and the ray at (0, 0), (3,), without distortion."""
        R_world_camera, (focal, centre) = self.T_world_camera[:3, :3], np.array([self.lens.focal, self.lens.centre])
        along = R_world_camera[:, :2].T / focal[:, None]
        return along, R_world_camera[:, 2] - centre @ along


class Cameras:
    """Several cameras that project the same few points, in fewer numpy calls than `Camera.project`."""

    def __init__(self, cameras: Sequence[Camera]):
        self.cameras: tuple[Camera, ...] = tuple(cameras)
        frames = np.array([camera.T_world_camera for camera in cameras])
        self._rotations = frames[:, :3, :3]
        self._offsets = -frames[:, None, :3, 3] @ self._rotations
        self._from_world = np.concatenate([self._rotations, self._offsets], 1)[:, None]  # (cameras, 1, 4, 3)
        lenses = [camera.lens for camera in cameras]
        self._focal = np.array([[lens.focal[0]] for lens in lenses])
        self._centres = np.array([[lens.centre] for lens in lenses])
        self._aspects = np.array([lens.aspect for lens in lenses]) if any(lens.aspect != 1 for lens in lenses) else None
        self._distorted = any(lens.is_distorted for lens in lenses)
        self._sizes = np.array([[(camera.width, camera.height)] for camera in cameras])

    def images(self, points: Floats, nearest: float | None = None) -> tuple[Floats, Floats]:
        """Project points in the world, (N, 3) m, to images (cameras, N, 2) px with depths (cameras, N) m.

        Points are moved back to the depth `nearest` [m], so that those behind a camera can be drawn.
        """
        in_camera = points @ self._rotations + self._offsets
        depth = in_camera[..., 2]
        if nearest is not None:
            depth = np.maximum(depth, nearest)
        with np.errstate(divide="ignore", invalid="ignore"):
            return self._projected(in_camera, depth), depth

    def images_on(self, T_world_links: Floats, points: Floats, nearest: float) -> Floats:
        """Project homogeneous points (k, N, 4) m in frames (k, 4, 4) to images (cameras, k, N, 2) px, as `images`."""
        T_links_cameras = np.swapaxes(T_world_links, 1, 2) @ self._from_world
        in_camera = (points @ T_links_cameras).reshape(len(self.cameras), -1, 3)
        images = self._projected(in_camera, np.maximum(in_camera[..., 2], nearest))
        return images.reshape(len(self.cameras), *points.shape[:2], 2)

    def _projected(self, in_camera: Floats, depth: Floats) -> Floats:
        """Images (cameras, N, 2) px of points (cameras, N, 3) m, with the depths (cameras, N) m instead of theirs."""
        images = in_camera[..., :2] * (self._focal / depth)[..., None]
        if self._distorted:
            squared = (images * images).sum(-1) / self._focal**2
            with np.errstate(divide="ignore", invalid="ignore"):
                images *= np.stack([camera.lens.stretch(r) for camera, r in zip(self.cameras, squared)])[..., None]
        if self._aspects is not None:
            images[..., 1] *= self._aspects[:, None]
        return images + self._centres

    def project(self, points: Floats) -> tuple[Floats, NDArray[np.bool_]]:
        """Project points in the world, (N, 3) m, to images (cameras, N, 2) px, with visibility (cameras, N)."""
        images, depth = self.images(points)
        return images, (depth > 0) & ((images >= 0) & (images <= self._sizes)).all(-1)


@dataclass(frozen=True)
class StereoHead:
    """Two cameras on a rigid head, which turns to look: the paper's [l], [r] and [L], [R]."""

    position: tuple[float, float, float]  # midpoint of the centres of projection [m]
    baseline_m: float
    width: int  # px
    height: int  # px
    left: Lens
    right: Lens
    verged: bool = False  # each camera looks at the gaze point itself
    toe_in: float = 0.0  # otherwise, rotation of each camera inwards about the head's vertical [rad]; 0: parallel axes

    def gaze(self, target: ArrayLike) -> tuple[Camera, Camera]:
        """Return the left and the right camera when the head is turned towards `target`, (3,) m."""
        target, position = np.asarray(target, float), np.asarray(self.position, float)
        ahead = look_rotation(target - position)
        cameras = []
        for side, lens in ((-0.5, self.left), (0.5, self.right)):
            eye = position + side * self.baseline_m * ahead[:, 0]
            rotation = look_rotation(target - eye) if self.verged else ahead
            if self.toe_in:
                rotation = rotation @ rotation_about_axis([0, 1, 0], -2 * side * self.toe_in)
            cameras.append(Camera(self.width, self.height, lens, rigid_transform(rotation, eye)))
        return cameras[0], cameras[1]


def triangulate(left: Camera, right: Camera, points: Floats) -> Floats:
    """Triangulate points by the midpoint method: (..., 4) px [left, right] -> (..., 3) m, NaN for parallel rays.

    For viewers only: no estimator may know a camera.
    """
    a, b = left.ray(points[..., :2]), right.ray(points[..., 2:])
    o_a, o_b = left.T_world_camera[:3, 3], right.T_world_camera[:3, 3]
    base = o_b - o_a
    aa, ab, bb = (np.einsum("...i,...i->...", one, other) for one, other in ((a, a), (a, b), (b, b)))
    along_a, along_b = a @ base, b @ base
    with np.errstate(divide="ignore", invalid="ignore"):
        half = 0.5 / (aa * bb - ab * ab)
        s, t = half * (bb * along_a - ab * along_b), half * (ab * along_a - aa * along_b)
    return s[..., None] * a + t[..., None] * b + 0.5 * (o_a + o_b)
