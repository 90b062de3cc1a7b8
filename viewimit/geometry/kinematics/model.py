"""A frame of projective space in which stereo images of a body are its points.

Images [x_L y_L x_R y_R] of cameras with parallel axes, and rectified ones of any, lie in a hyperplane of their 4-space:
three coordinates of it are, with a 1, homogeneous coordinates of the point in space, up to a projective map.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..rectification import Rectification
from .clusters import Groups, Seen, carried

LEAST_SPREAD = 1e-6  # px: of images in a plane


@dataclass(frozen=True)
class StereoFrame:
    """mean: (4,) px; axes: (3, 4) px, along which the images were spread, by how much; off: px, rms from the
    hyperplane."""

    mean: NDArray
    axes: NDArray
    off: float

    @classmethod
    def of(cls, images: NDArray) -> "StereoFrame":
        """(M, 4) px"""
        mean = images.mean(0)
        _, spread, axes = np.linalg.svd(images - mean, full_matrices=False)
        spread = np.maximum(spread / np.sqrt(len(images)), LEAST_SPREAD)
        return cls(mean, spread[:3, None] * axes[:3], float(spread[3]))

    @property
    def spread(self) -> NDArray:
        """(3,) px, of one unit of each coordinate."""
        return np.linalg.norm(self.axes, axis=1)

    def coordinates(self, images: NDArray) -> NDArray:
        """(..., 4) px → (..., 3)"""
        return (images - self.mean) @ (self.axes.T / self.spread**2)

    @property
    def projection(self) -> NDArray:
        """(5, 4): homogeneous coordinates → homogeneous images."""
        return np.vstack([np.column_stack([self.axes.T, self.mean]), [0, 0, 0, 1]])


# Screw motions as matrices of projective space: exp(θG), G = A⁻¹SA of a twist S, in any projective frame A.

LEAST_RATE = 1e-8  # of a joint that slides: its G² is 0


def twist_matrices(twists: NDArray) -> NDArray:
    """(..., 6), angular velocity ω and velocity v → (..., 4, 4): [[ω]× v; 0 0]."""
    S = np.zeros((*twists.shape[:-1], 4, 4))
    x, y, z = np.moveaxis(twists[..., :3], -1, 0)
    S[..., 0, 1], S[..., 0, 2], S[..., 1, 2] = -z, y, -x
    S[..., 1, 0], S[..., 2, 0], S[..., 2, 1] = z, -y, x
    S[..., :3, 3] = twists[..., 3:]
    return S


def powers(G: NDArray, rate: NDArray) -> NDArray:
    """I, G, G²/w² and G³/w³, of which every exponential is a sum. G: (..., 4, 4); rate: (...), w → (..., 4, 4, 4)."""
    w = np.maximum(rate, LEAST_RATE)[..., None, None]
    squared = G @ G / w**2
    return np.stack([np.broadcast_to(np.eye(4), G.shape), G, squared, squared @ G / w], -3)


def exponentials(powers: NDArray, rate: NDArray, angle: NDArray) -> NDArray:
    """exp(θG) = I + θG + (1 - cos wθ) G²/w² + (wθ - sin wθ) G³/w³ (Murray, Li & Sastry 1994, Ch. 2), as G⁴ = -w²G².

    powers: (..., m, 4, 4, 4); rate: (..., m), w = |ω|; angle: (B, m) → (..., B, m, 4, 4).
    """
    turn = np.maximum(rate, LEAST_RATE)[..., None, :] * angle
    terms = np.empty((*turn.shape, 4))
    terms[..., 0], terms[..., 1], terms[..., 2], terms[..., 3] = 1.0, angle, 1 - np.cos(turn), turn - np.sin(turn)
    motions = terms.swapaxes(-2, -3) @ powers.reshape(*powers.shape[:-2], 16)  # (..., m, B, 16)
    return motions.swapaxes(-2, -3).reshape(*turn.shape, 4, 4)


# The images of a body as its joints turn it: products of exponentials (Brockett 1984) in a projective frame.
# A stereo head that stands still sees a joint's motion as one of projective space, conjugate to a screw (Ruf & Horaud
# 1999, "Visual servoing of robot manipulators, Part I"). All joints share the frame: eight numbers
# tell it up to a similarity, six each joint's twist, and no camera, link or length is known.

FRAME = 8  # parameters: logarithms of two scales, three shears, the plane at infinity
MOST_SCALE = 20.0  # of these logarithms: however wild a step is, the frame has an inverse


@dataclass(frozen=True)
class ProjectiveKinematics:
    """parameters: (P,) of frame and twists; shape: (N, 3), the points in the stereo frame at the reference, (m,) rad,
    NaN of points that nothing tells; moved: (N, m) bool, by which joints; rectification: of the images, None if they
    need none. Several at once have (..., P) parameters and (..., N, 3) points."""

    parameters: NDArray
    shape: NDArray
    moved: NDArray
    reference: NDArray
    frame: StereoFrame
    rectification: Rectification | None = None

    @classmethod
    def unmoved(
        cls, points: int, joints: int, reference: NDArray, frame: StereoFrame, rectification: Rectification | None
    ) -> "ProjectiveKinematics":
        """Joints that turn nothing, in an affine frame, of points that nothing tells."""
        parameters, shape = np.zeros(FRAME + 6 * joints), np.full((points, 3), np.nan)
        return cls(parameters, shape, np.zeros((points, joints), bool), reference, frame, rectification)

    @property
    def unknown(self) -> NDArray:
        """(N,) bool: points that nothing tells."""
        return np.isnan(self.shape[..., 0])

    def predict(self, displacement: NDArray) -> NDArray:
        """(..., m) rad → images (..., N, 4) px; of several at once (D, ..., N, 4)."""
        flat = displacement.reshape(-1, displacement.shape[-1])
        images = self.groups.project(self._motions(flat), self.shape, self.frame.projection)
        images = images.reshape(*images.shape[:-3], *displacement.shape[:-1], *images.shape[-2:])
        return images if self.rectification is None else self.rectification.restore(images)

    def coordinates(self, displacement: NDArray) -> NDArray:
        """(K, m) rad → (..., K, N, 3), in the stereo frame."""
        return self.groups.project(self._motions(displacement), self.shape, np.eye(4))

    def with_points(self, points: NDArray, seen: Seen, coordinates: NDArray) -> "ProjectiveKinematics":
        """With these points, (N,) bool, where they were seen first. coordinates: (K, N, 3), of what was seen."""
        points = points & seen.whole.any(0)
        if not points.any():
            return self
        shape, motions = self.shape.copy(), self._motions(seen.displacement)
        for group, chain in zip(self.groups.points, carried(motions, self.groups.joints, np.eye(4))):
            these = group[points[group]]
            first = seen.whole[:, these].argmax(0)
            back = np.linalg.inv(chain if chain.ndim == 2 else chain[first])
            space = (back @ np.append(coordinates[first, these], np.ones((len(these), 1)), 1)[..., None])[..., 0]
            shape[these] = space[:, :3] / space[:, 3:]
        return replace(self, shape=shape)

    @property
    def groups(self) -> Groups:
        return Groups.of(self.moved)

    def _motions(self, displacement: NDArray) -> NDArray:
        """(B, m) rad → (..., B, m, 4, 4), of projective space."""
        return exponentials(*self._generators, displacement - self.reference)

    @cached_property
    def _generators(self) -> tuple[NDArray, NDArray]:
        """The `powers` of each joint's generator, (..., m, 4, 4, 4), and its rate |ω|, (..., m)."""
        twists = self.parameters[..., FRAME:].reshape(*self.parameters.shape[:-1], -1, 6)
        A, rate = self._upgrade[..., None, :, :], np.sqrt((twists[..., :3] ** 2).sum(-1))
        return powers(np.linalg.inv(A) @ twist_matrices(twists) @ A, rate), rate

    @property
    def _upgrade(self) -> NDArray:
        """(..., 4, 4): from the projective frame to a metric one."""
        parameters = self.parameters
        A = np.zeros((*parameters.shape[:-1], 4, 4))
        A[..., [0, 1], [0, 1]] = np.exp(np.clip(parameters[..., :2], -MOST_SCALE, MOST_SCALE))
        A[..., 0, 1], A[..., 0, 2], A[..., 1, 2] = np.moveaxis(parameters[..., 2:5], -1, 0)
        A[..., 2, 2] = A[..., 3, 3] = 1.0
        A[..., 3, :3] = parameters[..., 5:FRAME]
        return A
