"""Images of a body as a function of its joint displacements: a product of exponentials in a projective frame.

Images [x_L y_L x_R y_R] of parallel or rectified cameras lie in a hyperplane of their 4-space. Three coordinates of it
are, with a 1, homogeneous coordinates of the point in space, up to a projective map (`StereoFrame`).

A stereo head that stands still sees a joint's motion as a motion of projective space, conjugate to a screw (Ruf and
Horaud 1999). With G_j = A⁻¹ S_j A, the twist S_j of joint j in the frame A, the point X is seen at

    y(θ) = π(C exp(θ_1 G_1) ... exp(θ_m G_m) X)

over the joints that move it, from the base outwards (Brockett 1984). All joints share A: eight parameters determine it
up to a similarity, and six more each twist. No camera, link or length is known.

References
----------
Ruf and Horaud, "Visual servoing of robot manipulators, part I: projective kinematics", IJRR 18(11), 1999.
Brockett, "Robotic manipulators and the product of exponentials formula", 1984.
Murray, Li and Sastry, A Mathematical Introduction to Robotic Manipulation, 1994, chapter 2.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..rectification import Rectification, cross_matrices
from .clusters import LinkClusters, Observations, chain_transforms

MIN_SCALE_PX = 1e-6  # of images in a plane
MIN_RATE = 1e-8  # of a prismatic joint, whose G² is 0
N_FRAME = 8  # frame parameters: logarithms of two scales, three shears, the plane at infinity
PLANE = slice(5, N_FRAME)  # of them, the plane at infinity
MAX_LOG_SCALE = 20.0  # keeps the frame invertible after any step


@dataclass(frozen=True)
class StereoFrame:
    """Coordinates of projective space in which stereo images are points."""

    mean: NDArray[np.float64]  # (4,) px
    axes: NDArray[np.float64]  # (3, 4) px, principal directions of the images, as long as their standard deviations
    rms_off_plane_px: float  # distance of the images from the hyperplane of the axes

    @classmethod
    def fit(cls, images: NDArray[np.float64]) -> "StereoFrame":
        """Fit the frame to images, (M, 4) px."""
        mean = images.mean(0)
        _, scale, axes = np.linalg.svd(images - mean, full_matrices=False)
        scale = np.maximum(scale / np.sqrt(len(images)), MIN_SCALE_PX)
        return cls(mean, scale[:3, None] * axes[:3], float(scale[3]))

    @cached_property
    def unit_px(self) -> NDArray[np.float64]:
        """(3,) px: length of one unit of each coordinate in the images."""
        return np.linalg.norm(self.axes, axis=1)

    def coordinates(self, images: NDArray[np.float64]) -> NDArray[np.float64]:
        """Coordinates (..., 3) of images (..., 4) px."""
        return (images - self.mean) @ (self.axes.T / self.unit_px**2)

    @property
    def projection(self) -> NDArray[np.float64]:
        """(5, 4): maps homogeneous coordinates to homogeneous images."""
        return np.vstack([np.column_stack([self.axes.T, self.mean]), [0, 0, 0, 1]])


def twist_matrices(twists: NDArray[np.float64]) -> NDArray[np.float64]:
    """Angular velocity ω and velocity v, (..., 6) → [[ω]× v; 0 0], (..., 4, 4)."""
    S = np.zeros((*twists.shape[:-1], 4, 4))
    S[..., :3, :3], S[..., :3, 3] = cross_matrices(twists[..., :3]), twists[..., 3:]
    return S


def generator_powers(G: NDArray[np.float64], rate: NDArray[np.float64]) -> NDArray[np.float64]:
    """I, G, G²/w² and G³/w³, of which `exponentials` are sums. G: (..., 4, 4); rate: w, (...) → (..., 4, 4, 4)."""
    w = np.maximum(rate, MIN_RATE)[..., None, None]
    powers = np.empty((*G.shape[:-2], 4, 4, 4))
    powers[..., 0, :, :], powers[..., 1, :, :], powers[..., 2, :, :] = np.eye(4), G, G @ G / w**2
    powers[..., 3, :, :] = powers[..., 2, :, :] @ G / w
    return powers


def exponentials(
    powers: NDArray[np.float64], rate: NDArray[np.float64], angle: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Evaluate exp(θG) = I + θG + (1 - cos wθ) G²/w² + (wθ - sin wθ) G³/w³, as G⁴ = -w²G².

    powers: (..., m, 4, 4, 4), of `generator_powers`; rate: w = |ω|, (..., m); angle: (B, m) rad → (..., B, m, 4, 4).
    """
    turn = np.maximum(rate, MIN_RATE)[..., None, :] * angle
    terms = np.empty((*turn.shape, 4))
    terms[..., 0], terms[..., 1], terms[..., 2], terms[..., 3] = 1.0, angle, 1 - np.cos(turn), turn - np.sin(turn)
    motions = terms.swapaxes(-2, -3) @ powers.reshape(*powers.shape[:-2], 16)  # (..., m, B, 16)
    return motions.swapaxes(-2, -3).reshape(*turn.shape, 4, 4)


@dataclass(frozen=True)
class ProjectiveKinematics:
    """Kinematics of a body in projective space. Several at once have leading axes in parameters and points."""

    parameters: NDArray[np.float64]  # (..., N_FRAME + 6 m): of the frame A, then ω and v of each joint
    points: NDArray[np.float64]  # (..., N, 3): in the stereo frame at the reference, NaN of unknown points
    moved_by: NDArray[np.bool_]  # (N, m): which joints move a point
    reference: NDArray[np.float64]  # (m,) rad
    frame: StereoFrame
    rectification: Rectification | None = None  # of the images, None if they need none

    @classmethod
    def initial(
        cls,
        n_points: int,
        reference: NDArray[np.float64],
        frame: StereoFrame,
        rectification: Rectification | None,
    ) -> "ProjectiveKinematics":
        """Joints that turn nothing, in an affine frame, and unknown points."""
        parameters, points = np.zeros(N_FRAME + 6 * len(reference)), np.full((n_points, 3), np.nan)
        return cls(parameters, points, np.zeros((n_points, len(reference)), bool), reference, frame, rectification)

    @property
    def unknown(self) -> NDArray[np.bool_]:
        """(N,): points whose position, or whose joints, the images do not determine."""
        return np.isnan(self.points[..., 0])

    def predict(self, displacement: NDArray[np.float64]) -> NDArray[np.float64]:
        """Images (..., N, 4) px at displacements (..., m) rad; of D kinematics at once (D, ..., N, 4)."""
        flat = displacement.reshape(-1, displacement.shape[-1])
        images = self.clusters.project(self.motions(flat), self.points, self.frame.projection)
        images = images.reshape(*images.shape[:-3], *displacement.shape[:-1], *images.shape[-2:])
        return images if self.rectification is None else self.rectification.restore(images)

    def coordinates(self, displacement: NDArray[np.float64]) -> NDArray[np.float64]:
        """Coordinates (..., K, N, 3) in the stereo frame at displacements (K, m) rad, or (..., K, m) rad."""
        return self.clusters.project(self.motions(displacement), self.points, np.eye(4))

    def coordinates_of(self, images: NDArray[np.float64]) -> NDArray[np.float64]:
        """Coordinates (..., 3) in the stereo frame of images (..., 4) px."""
        return self.frame.coordinates(images if self.rectification is None else self.rectification.apply(images))

    def magnification(self, images: NDArray[np.float64]) -> NDArray[np.float64]:
        """By how much larger noise is in the coordinates of images (..., 4) px than in the images, (..., 1)."""
        if self.rectification is None:
            return np.ones((*images.shape[:-1], 1))
        return np.sqrt((self.rectification.magnification(images) ** 2).mean(-1, keepdims=True))

    def affine_coordinates(self, images: NDArray[np.float64]) -> NDArray[np.float64]:
        """Reconstruct points from stereo images of any body in front of the head, up to an affine map.

        The joints' motions determine the plane at infinity of the stereo frame. The head is rigid, so it is the same
        for every body that it sees. images: (..., 4) px → (..., 3).
        """
        images = images if self.rectification is None else self.rectification.apply(images)
        coordinates = self.frame.coordinates(images)
        return coordinates / (1 + coordinates @ self.parameters[PLANE])[..., None]

    def with_points(
        self, points: NDArray[np.bool_], observations: Observations, coordinates: NDArray[np.float64]
    ) -> "ProjectiveKinematics":
        """Place some points, (N,) bool, where their first image shows them. coordinates: (K, N, 3), of the images."""
        points = points & observations.visible_in_both.any(0)
        if not points.any():
            return self
        placed, motions = self.points.copy(), self.motions(observations.displacement)
        for members, transform in zip(self.clusters.points, chain_transforms(motions, self.clusters.joints, np.eye(4))):
            these = members[points[members]]
            first = observations.visible_in_both[:, these].argmax(0)
            back = np.linalg.inv(transform if transform.ndim == 2 else transform[first])
            space = (back @ np.append(coordinates[first, these], np.ones((len(these), 1)), 1)[..., None])[..., 0]
            placed[these] = space[:, :3] / space[:, 3:]
        return replace(self, points=placed)

    @property
    def clusters(self) -> LinkClusters:
        return LinkClusters.from_table(self.moved_by)

    def motions(self, displacement: NDArray[np.float64]) -> NDArray[np.float64]:
        """Motions of projective space, (..., B, m, 4, 4), at displacements (B, m) rad, or (..., B, m) rad."""
        return exponentials(*self._generators, displacement - self.reference)

    @cached_property
    def _generators(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """`generator_powers` of each joint, (..., m, 4, 4, 4), and its rate |ω|, (..., m)."""
        twists = self.parameters[..., N_FRAME:].reshape(*self.parameters.shape[:-1], -1, 6)
        A, back = self.metric_upgrade[..., None, :, :], self.metric_downgrade[..., None, :, :]
        rate = np.sqrt((twists[..., :3] ** 2).sum(-1))
        return generator_powers(back @ twist_matrices(twists) @ A, rate), rate

    @property
    def rates(self) -> NDArray[np.float64]:
        """By how many rad each joint turns for a unit of its displacement, (..., m): 1 if that is in rad."""
        return self._generators[1]

    @cached_property
    def metric_upgrade(self) -> NDArray[np.float64]:
        """A, (..., 4, 4): from the projective frame to a metric one."""
        return frame_matrices(self.parameters[..., :N_FRAME])

    @cached_property
    def metric_downgrade(self) -> NDArray[np.float64]:
        """A⁻¹, (..., 4, 4): from the metric frame to the projective one."""
        return np.asarray(np.linalg.inv(self.metric_upgrade), np.float64)


def frame_matrices(frame: NDArray[np.float64]) -> NDArray[np.float64]:
    """A, (..., 4, 4), of the frame parameters (..., N_FRAME)."""
    A = np.zeros((*frame.shape[:-1], 4, 4))
    scales = np.exp(np.clip(frame[..., :2], -MAX_LOG_SCALE, MAX_LOG_SCALE))
    A[..., 0, 0], A[..., 1, 1] = scales[..., 0], scales[..., 1]
    A[..., 0, 1], A[..., 0, 2], A[..., 1, 2] = frame[..., 2], frame[..., 3], frame[..., 4]
    A[..., 2, 2] = A[..., 3, 3] = 1.0
    A[..., 3, :3] = frame[..., PLANE]
    return A
