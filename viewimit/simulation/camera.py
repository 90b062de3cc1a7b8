"""Cameras and the learner's stereo head."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..geometry.distortion import Radial
from ..geometry.rigid import look_rotation, rigid_transform, rotation_about_axis

WORLD = np.eye(4)


@dataclass(frozen=True)
class Lens:
    """focal: (fx, fy), centre: px; distortion: of the lens; undone: the one that its images are rid of, which is the
    lens's own as far as its owner knows it."""

    focal: tuple[float, float]
    centre: tuple[float, float]
    distortion: Radial = Radial()
    undone: Radial = Radial()

    @cached_property
    def is_distorted(self) -> bool:
        """Whether images are not those of a pinhole."""
        return self.distortion != self.undone

    @property
    def aspect(self) -> float:
        """fy/fx, 1 for square pixels."""
        return self.focal[1] / self.focal[0]

    def stretch(self, squared: NDArray) -> NDArray:
        """How many times as far from the centre an image is as a pinhole's. squared: r², of that, in focal lengths."""
        factor = self.distortion.stretch(squared)
        return factor * self.undone.undone(squared * factor * factor) if self.undone.bends else factor

    def direction(self, image: NDArray) -> NDArray:
        """image: (..., 2) px → (..., 2), where its ray meets the plane one focal length ahead."""
        on_plane = (image - self.centre) / self.focal
        if not self.is_distorted:
            return on_plane
        squared = (on_plane * on_plane).sum(-1)
        factor = self.undone.stretch(squared)
        return on_plane * (factor * self.distortion.undone(squared * factor * factor))[..., None]

    def shows(self, image: NDArray) -> bool:
        """Whether what is seen in all of image, (..., 2) px, can be told."""
        seen = np.hypot(*((image - self.centre) / self.focal).reshape(-1, 2).T)
        return bool((seen < min(self.distortion.rim, self.undone.reach)).all())


def undistort_points(points: NDArray, focal: tuple[float, float], centre: tuple[float, float], by: Radial) -> NDArray:
    """(..., 2) px of a lens with that distortion → px of a pinhole."""
    return Lens(focal, centre, by).direction(points) * focal + centre


@dataclass(frozen=True)
class Camera:
    """A camera behind a lens. width, height: px; T_world_camera: (4, 4), metres, OpenCV axes."""

    width: int
    height: int
    lens: Lens
    T_world_camera: NDArray

    def project(self, points: NDArray, T_world_points: NDArray = WORLD) -> tuple[NDArray, NDArray]:
        """points: (3, ...) m in a frame → image (2, ...) px and visible (...): in front and inside the image."""
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

    def ray(self, image: ArrayLike) -> NDArray:
        """image: (..., 2) px → directions (..., 3) in the world, 1 long along the optical axis."""
        image = np.asarray(image, float)
        if not self.lens.is_distorted:
            along, straight = self._linear_ray
            return image @ along + straight
        R_world_camera = self.T_world_camera[:3, :3]
        return self.lens.direction(image) @ R_world_camera[:, :2].T + R_world_camera[:, 2]

    @cached_property
    def _linear_ray(self) -> tuple[NDArray, NDArray]:
        """Of a lens that bends nothing: how a ray turns with x and y, (2, 3) a px, and where it points at 0, (3,)."""
        R_world_camera, (focal, centre) = self.T_world_camera[:3, :3], np.array([self.lens.focal, self.lens.centre])
        along = R_world_camera[:, :2].T / focal[:, None]
        return along, R_world_camera[:, 2] - centre @ along


class Cameras:
    """Several cameras that take a few points at once: as Camera.project does for many, in fewer steps."""

    def __init__(self, cameras: Sequence[Camera]):
        self.cameras = tuple(cameras)
        frames = np.array([camera.T_world_camera for camera in cameras])
        self._rotations = frames[:, :3, :3]
        self._offsets = -frames[:, None, :3, 3] @ self._rotations
        self._from_world = np.concatenate([self._rotations, self._offsets], 1)[:, None]  # (cameras, 1, 4, 3)
        lenses = [camera.lens for camera in cameras]
        self._focal = np.array([[lens.focal[0]] for lens in lenses])
        self._centres = np.array([[lens.centre] for lens in lenses])
        self._aspects = np.array([lens.aspect for lens in lenses]) if any(lens.aspect != 1 for lens in lenses) else None
        self._bends = any(lens.is_distorted for lens in lenses)
        self._sizes = np.array([[(camera.width, camera.height)] for camera in cameras])

    def images(self, points: NDArray, nearest: float | None = None) -> tuple[NDArray, NDArray]:
        """points: (N, 3) m in the world → images (cameras, N, 2) px, depths (cameras, N) m.

        nearest: depth to which nearer points are set back, so that what stands behind a camera is drawn somewhere.
        """
        in_camera = points @ self._rotations + self._offsets
        depth = in_camera[..., 2]
        if nearest is not None:
            depth = np.maximum(depth, nearest)
        with np.errstate(divide="ignore", invalid="ignore"):
            return self._projected(in_camera, depth), depth

    def images_on(self, T_world_links: NDArray, points: NDArray, nearest: float) -> NDArray:
        """T_world_links: (k, 4, 4); points: (k, N, 4) m in these frames, the last coordinate 1 → (cameras, k, N, 2) px.
        nearest: as in `images`."""
        T_links_cameras = np.swapaxes(T_world_links, 1, 2) @ self._from_world
        in_camera = (points @ T_links_cameras).reshape(len(self.cameras), -1, 3)
        images = self._projected(in_camera, np.maximum(in_camera[..., 2], nearest))
        return images.reshape(len(self.cameras), *points.shape[:2], 2)

    def _projected(self, in_camera: NDArray, depth: NDArray) -> NDArray:
        """in_camera: (cameras, N, 3) m; depth: (cameras, N) m in place of theirs → (cameras, N, 2) px."""
        images = in_camera[..., :2] * (self._focal / depth)[..., None]
        if self._bends:
            squared = (images * images).sum(-1) / self._focal**2
            with np.errstate(divide="ignore", invalid="ignore"):
                images *= np.stack([camera.lens.stretch(r) for camera, r in zip(self.cameras, squared)])[..., None]
        if self._aspects is not None:
            images[..., 1] *= self._aspects[:, None]
        return images + self._centres

    def project(self, points: NDArray) -> tuple[NDArray, NDArray]:
        """points: (N, 3) m in the world → images (cameras, N, 2) px, visible (cameras, N): in front and inside."""
        images, depth = self.images(points)
        return images, (depth > 0) & ((images >= 0) & (images <= self._sizes)).all(-1)


@dataclass(frozen=True)
class StereoHead:
    """Two cameras on one rigid head that turns to look: the paper's [l],[r] and [L],[R].

    position: midpoint of the two centres of projection, m. `verged` cameras each look at the gaze point itself;
    otherwise each is turned inwards by `toe_in`, rad, about the head's vertical: with 0 the optical axes are parallel.
    """

    position: tuple[float, float, float]
    baseline_m: float
    width: int
    height: int
    left: Lens
    right: Lens
    verged: bool = False
    toe_in: float = 0.0

    def gaze(self, target: ArrayLike) -> tuple[Camera, Camera]:
        """Left and right camera of the head turned towards `target` (3,) m."""
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


def triangulate(left: Camera, right: Camera, points: NDArray) -> NDArray:
    """Midpoint of the two rays nearest to each other. points: (..., 4) px [left, right] → (..., 3) m.

    For the viewer of the scene only: no estimator may know a camera. NaN where the rays are parallel.
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
