"""One adjustment of the images of two bodies of the same build: the own visits, and the demonstrator's images.

One stereo head sees both bodies, so both share the frame A that turns projective coordinates into metric ones
(`model`). In metric coordinates the demonstrator is the own body in another posture, moved by a similarity T: seven
unknowns, where a map between images has fifteen. With the generators G_j of the joints its points are seen at

    y(θ) = π(C A⁻¹ T A · exp(θ_1 G_1) ... exp(θ_m G_m) X).

The gauge: A is upper triangular with two unit elements, which leaves no similarity free. T has no such freedom either,
as its scale is the demonstrator's size.

Unknown are A (8), twists (6 a joint), points (3 each), T (7) and the demonstrator's angles, m for each of its postures.
All images have independent noise of one standard deviation, so the cost over its square is χ² with as many degrees of
freedom as there are coordinates more than unknowns. The own images determine the body; the demonstrator's, in
Q postures, add 3 N Q - 7 - m Q degrees of freedom.

References
----------
Triggs, McLauchlan, Hartley and Fitzgibbon, "Bundle adjustment: a modern synthesis", 2000.
Hartley and Zisserman, Multiple View Geometry, 2nd ed. 2003, sections 4.1 (DLT) and 19.2 (metric upgrade).
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..rectification import MIN_DENOMINATOR, cross_matrices
from .adjustment import BundleAdjustment
from .bundle import Residuals, jacobian, levenberg_marquardt, normal_equations
from .clusters import Observations
from .model import MAX_LOG_SCALE, MIN_RATE, N_FRAME, ProjectiveKinematics, frame_matrices, twist_matrices

Array = NDArray[np.float64]
N_SIMILARITY = 7  # rotation vector, translation, logarithm of the scale
MIN_METRIC = 1e-6  # smallest eigenvalue of a metric, relative to the largest
LEFT_OPEN = 1e-12  # eigenvalue of the information, relative to the largest, that rounding leaves where there is none
MOST_STEPS = 200  # a nearly flat body leaves a narrow valley
FTOL = 1e-5  # share of the cost: what angles still gain is far below their standard deviation


@dataclass(frozen=True)
class Difference:
    """What the demonstrator differs in from the own body and head: unknowns besides T and its angles.

    A joint whose attachment is shifted changes the link before it, in length and direction. Points that sit elsewhere
    are free. Another head has another frame. `spread` keeps shifts and points near those of the own body.
    """

    shifted: bool = False  # whether all joints are attached elsewhere: 3 metric coordinates each
    points: tuple[int, ...] = ()  # that sit elsewhere: 3 coordinates each
    other_head: bool = False  # N_FRAME parameters
    spread: float = np.inf  # standard deviation of each coordinate that differs, in the body's rms extent

    def sizes(self, joints: int) -> tuple[int, int, int]:
        """Numbers of unknowns."""
        return 3 * joints * self.shifted, 3 * len(self.points), N_FRAME * self.other_head


SAME = Difference()


@dataclass(frozen=True)
class BodyPair:
    """A body and a demonstrator of the same build, seen by the same head. Several at once as `ProjectiveKinematics`."""

    parameters: Array  # (..., P): of the kinematics; then T, the demonstrator's angles, and what else it differs in
    points: Array  # (..., N, 3): in the stereo frame at the reference, NaN of unknown points
    kinematics: ProjectiveKinematics  # whose parameters and points these replace
    placement: Array  # (4, 4): the similarity about which T is parametrised; its determinant is negative for a mirror
    n_postures: int  # of the demonstrator
    difference: Difference = SAME

    @classmethod
    def at_postures(cls, kinematics: ProjectiveKinematics, placement: Array, postures: Array) -> "BodyPair":
        """Place the demonstrator by a similarity, (4, 4), in postures, displacements (Q, m) rad."""
        parameters = np.concatenate([kinematics.parameters, np.zeros(N_SIMILARITY), postures.ravel()])
        return cls(parameters, kinematics.points, kinematics, placement, len(postures))

    @cached_property
    def body(self) -> ProjectiveKinematics:
        """The own body."""
        n = self.kinematics.parameters.shape[-1]
        return replace(self.kinematics, parameters=self.parameters[..., :n], points=self.points)

    @property
    def angle_slice(self) -> slice:
        """Of the demonstrator's angles, among the parameters."""
        begin = self.kinematics.parameters.shape[-1] + N_SIMILARITY
        return slice(begin, begin + self.n_postures * self.n_joints)

    @property
    def angles(self) -> Array:
        """(..., Q, m) rad: displacements of the demonstrator."""
        angles = self.parameters[..., self.angle_slice]
        return angles.reshape(*angles.shape[:-1], self.n_postures, self.n_joints)

    def in_postures(self, postures: Array) -> "BodyPair":
        """The same body and place with the demonstrator in other postures, (..., Q, m) rad."""
        at, lead = self.angle_slice, postures.shape[:-2]
        every = lambda values: np.broadcast_to(values, (*lead, *values.shape))
        before, after = self.parameters[: at.start], self.parameters[at.stop :]
        parameters = np.concatenate([every(before), postures.reshape(*lead, -1), every(after)], -1)
        return replace(self, parameters=parameters, points=every(self.points), n_postures=postures.shape[-2])

    def unwound(self, postures: Array) -> "BodyPair":
        """Turn the demonstrator's joints by whole turns to the angles nearest to its postures, (Q, m) rad.

        A turn is 2π over the joint's rate |ω|, which is estimated and near 1. It moves points by the pitch at most
        of the joint's screw, which noise makes.
        """
        rate = np.linalg.norm(self.parameters[N_FRAME : len(self.kinematics.parameters)].reshape(-1, 6)[:, :3], axis=1)
        turns = np.round((self.angles - postures) * rate / (2 * np.pi))
        if not turns.any():
            return self
        return self.in_postures(self.angles - turns * (2 * np.pi / np.maximum(rate, MIN_RATE)))

    def with_difference(self, difference: Difference) -> "BodyPair":
        """Let a demonstrator of the same body and head differ; begin with no difference."""
        added = np.zeros(sum(difference.sizes(self.n_joints)))
        if difference.other_head:
            added[-N_FRAME:] = self.parameters[:N_FRAME]
        return replace(self, parameters=np.concatenate([self.parameters, added]), difference=difference)

    @property
    def n_joints(self) -> int:
        return len(self.kinematics.reference)

    @property
    def extent(self) -> float:
        """Rms distance of the own points from their mean, per coordinate, in metric coordinates."""
        known = self.points[~np.isnan(self.points[:, 0])]
        return float(metric_points(self.body.metric_upgrade, known).std(0).mean())

    @property
    def _differing(self) -> tuple[Array, Array, Array]:
        """Shifts of the joints (..., m, 3) or none, of the points (..., n, 3), and the demonstrator's frame or none."""
        sizes = self.difference.sizes(self.n_joints)
        at = self.parameters.shape[-1] - sum(sizes)
        lead, free = self.parameters.shape[:-1], self.parameters[..., at:]
        shifts, points, frame = np.split(free, [sizes[0], sizes[0] + sizes[1]], -1)
        return shifts.reshape(*lead, sizes[0] // 3, 3), points.reshape(*lead, sizes[1] // 3, 3), frame

    @property
    def shifts(self) -> Array:
        """(..., m, 3): where each joint is attached, relative to the own body; (..., 0, 3) if that is not free."""
        return self._differing[0]

    def demonstrator(self) -> Array:
        """Coordinates (..., Q, N, 3) of the demonstrator in the stereo frame."""
        body, A = self.body, self.body.metric_upgrade
        shifts, offsets, frame = self._differing
        back = body.metric_downgrade
        map_ = (np.linalg.inv(frame_matrices(frame)) if self.difference.other_head else back) @ self._similarity @ A
        motions, points = body.motions(self.angles), self.points
        if self.difference.shifted:
            E = np.zeros((*shifts.shape[:-1], 4, 4))
            E[...] = np.eye(4)
            E[..., :3, 3] = shifts
            motions = (back[..., None, :, :] @ E @ A[..., None, :, :])[..., None, :, :, :] @ motions
        if self.difference.points:
            metric = metric_points(A, np.broadcast_to(points, (*A.shape[:-2], *points.shape[-2:])))
            metric[..., list(self.difference.points), :] += offsets
            points = metric_points(back, metric)
        return body.clusters.project(motions, points, map_[..., None, :, :])

    @property
    def _similarity(self) -> Array:
        """T, (..., 4, 4)."""
        begin = self.kinematics.parameters.shape[-1]
        s = self.parameters[..., begin : begin + N_SIMILARITY]
        change = np.zeros((*s.shape[:-1], 4, 4))
        scale = np.exp(np.clip(s[..., 6, None, None], -MAX_LOG_SCALE, MAX_LOG_SCALE))
        change[..., :3, :3] = scale * rotations(s[..., :3])
        change[..., :3, 3], change[..., 3, 3] = s[..., 3:6], 1.0
        return change @ self.placement


@dataclass(frozen=True)
class PairAdjustment:
    """Least-squares problem of fitting a pair of bodies to the images of both."""

    own: BundleAdjustment  # of the own visits
    images: Array  # (Q, N, 4) px: of the demonstrator in [l, r], rectified, 0 where not visible
    coordinates: Array  # (Q, N, 3): of them in the kinematics' frame
    visible: NDArray[np.bool_]  # (Q, N, 2): which of its points are visible in each image
    magnification: Array  # (Q, N, 2): of their noise by the rectification
    weight: float = 1.0  # of their residuals: noise of the own images over the noise of these

    @classmethod
    def of(
        cls,
        kinematics: ProjectiveKinematics,
        observations: Observations,
        demo: Array,
        noise_px: float,
        weight: float = 1.0,
    ) -> "PairAdjustment":
        """Set it up. demo: (Q, N, 4) px in [l, r], NaN where hidden; observations: of the own body, as demo in px."""
        own = BundleAdjustment.of(kinematics, observations, noise_px).restricted_to_known(kinematics)
        visible = np.isfinite(demo[..., ::2]) & ~kinematics.unknown[:, None]
        images, by = np.nan_to_num(demo), kinematics.rectification
        enlarged = np.ones(visible.shape) if by is None else by.magnification(images)
        images = images if by is None else by.apply(images)
        return cls(own, images, kinematics.frame.coordinates(images), visible, enlarged, weight)

    @cached_property
    def visible_in_both(self) -> NDArray[np.bool_]:
        """(Q, N)."""
        return np.asarray(self.visible.all(-1))

    @property
    def degrees_of_freedom(self) -> int:
        """Number that the demonstrator's images add."""
        angles = self.visible.shape[0] * self.own.observations.displacement.shape[1]
        coordinates = 2 * int(np.count_nonzero(self.visible)) - int(np.count_nonzero(self.visible_in_both))
        return coordinates - N_SIMILARITY - angles

    def residuals(self, pair: BodyPair) -> Array:
        """Predicted minus observed coordinates, (..., K + Q, N, 3) px, of own and demonstrator's images.

        The demonstrator's are multiplied by `weight`, so that all have the noise of the own images. A point of it that
        one image alone shows has the two coordinates of that image.
        """
        frame, coordinates = pair.kinematics.frame, pair.demonstrator()
        difference = (coordinates - self.coordinates) * (frame.unit_px / self._of_both)
        theirs = np.where(self.visible_in_both[..., None], difference, 0.0)
        if self._any_alone:
            theirs = theirs + self._partial_residuals(coordinates @ frame.axes + frame.mean)
        return np.concatenate([self.own.residuals(pair.body), self.weight * theirs], -3)

    @cached_property
    def _any_alone(self) -> bool:
        """Whether there is a point that one image alone shows."""
        return bool((self.visible.any(-1) != self.visible_in_both).any())

    @cached_property
    def _of_both(self) -> Array:
        """Magnification of a point that both images show, (Q, N, 1)."""
        return np.sqrt((self.magnification**2).mean(-1, keepdims=True))

    def _partial_residuals(self, images: Array) -> Array:
        """Predicted minus observed x and y, and 0, of points that one image alone shows, of (..., Q, N, 4) px."""
        alone = self.visible & ~self.visible_in_both[..., None]
        enlarged = np.repeat(self.magnification, 2, -1)
        difference = np.where(np.repeat(alone, 2, -1), (images - self.images) / enlarged, 0.0)
        return np.concatenate([difference[..., :2] + difference[..., 2:], np.zeros_like(difference[..., :1])], -1)

    def starts(self, kinematics: ProjectiveKinematics, postures: Array, mirror: bool = False) -> list[BodyPair]:
        """Return pairs with the demonstrator in postures, (Q, m) rad, the best first.

        Noise leaves open the frame (`with_shared_metric`) and the homography between the bodies. So there are two
        frames, and in each up to two similarities: of metric points, and the nearest to the homography. They reflect
        if the demonstrator is taken for a mirror image: one head cannot mirror a body.
        """
        own, demo = kinematics.coordinates(postures), kinematics.frame.coordinates(self.images)
        own, demo = own[self.visible_in_both], demo[self.visible_in_both]
        H = fit_homography(own, demo)
        pairs = []
        for body in (kinematics, with_shared_metric(kinematics, H)):
            A = body.metric_upgrade
            metric = fit_similarity(metric_points(A, own), metric_points(A, demo), mirror)
            pairs += [
                BodyPair.at_postures(body, placement, postures)
                for placement in (metric, nearest_similarity(H, A))
                if (np.linalg.det(placement) < 0) == mirror
            ]
        return sorted(pairs, key=lambda pair: float((self.residuals(pair) ** 2).sum()))

    def prior_weights(self, pair: BodyPair) -> Array:
        """(P,) px²: as of `BundleAdjustment`, and the same for what the demonstrator differs in, or by its spread."""
        weights, spread = self.own.prior_weights(len(pair.parameters)), pair.difference.spread
        begin = len(weights) - sum(pair.difference.sizes(pair.n_joints))
        weights[begin:] = weights[0] if np.isinf(spread) else (self.own.noise_px / (spread * pair.extent)) ** 2
        return weights

    def solve(self, initial: BodyPair, max_iter: int = MOST_STEPS) -> BodyPair:
        """Minimise the residuals from this pair, in at most `max_iter` steps."""
        return levenberg_marquardt(initial, self.residuals, self.prior_weights(initial), FTOL, max_iter)

    def angle_std(self, pair: BodyPair) -> Array:
        """(Q, m) rad: standard deviations of the demonstrator's angles for noise of 1 px."""
        return np.sqrt(replace(pair, parameters=np.diag(self.covariance(pair))).angles)

    def covariance(self, pair: BodyPair) -> Array:
        """(P, P): of the parameters for noise of 1 px. What the images leave open has a very large variance."""
        return covariance_of(pair, self.residuals, self.prior_weights(pair))


def covariance_of(model: Any, residuals_of: Residuals, prior: Array) -> Array:
    """(P, P): of the parameters of a model, as of `levenberg_marquardt`, for noise of 1 px."""
    P = len(model.parameters)
    A, B, C = normal_equations(jacobian(model, residuals_of, residuals_of(model)), P)
    known = np.linalg.pinv(C, hermitian=True)
    schur = A + np.diag(prior) - np.tensordot(B @ known, B, ([0, 2], [0, 2]))
    size = np.sqrt(np.maximum(np.diag(schur), 0.0))  # rounding may leave less than 0 of what nothing determines
    scale = np.where(size > 0, size, 1.0)
    values, vectors = np.linalg.eigh(schur / np.outer(scale, scale))
    vectors = vectors / scale[:, None]
    return vectors / np.maximum(values, LEFT_OPEN * values[-1]) @ vectors.T


def rotations(vectors: Array) -> Array:
    """Rotation matrices (..., 3, 3) of rotation vectors (..., 3) rad, by Rodrigues' formula."""
    angle = np.maximum(np.sqrt((vectors**2).sum(-1)), np.finfo(float).tiny)[..., None, None]
    K = cross_matrices(vectors)
    return np.eye(3) + np.sinc(angle / np.pi) * K + 0.5 * np.sinc(angle / (2 * np.pi)) ** 2 * (K @ K)


def fit_homography(source: Array, target: Array) -> Array:
    """Fit H, (..., 4, 4), with target ~ H [source; 1], by the direct linear transformation. (..., N, 3) each."""
    h = np.concatenate([source, np.ones((*source.shape[:-1], 1))], -1)
    rows = np.zeros((*h.shape[:-1], 3, 16))
    for k in range(3):
        rows[..., k, 4 * k : 4 * k + 4] = h
        rows[..., k, 12:] = -target[..., k : k + 1] * h
    rows = rows.reshape(*h.shape[:-2], -1, 16)
    return np.linalg.eigh(rows.swapaxes(-1, -2) @ rows)[1][..., 0].reshape(*h.shape[:-2], 4, 4)


def reverses_orientation(H: Array) -> NDArray[np.bool_]:
    """Whether maps of space, (..., 4, 4), mirror it. Where H gives a point the depth w, its Jacobian is det H / w⁴."""
    return np.asarray(np.linalg.det(H) < 0)


def with_shared_metric(kinematics: ProjectiveKinematics, H: Array) -> ProjectiveKinematics:
    """Return the same kinematics in the frame whose metric the map between both bodies preserves, too.

    Parallel joint axes leave the scale along them open, and noise more. In coordinates that are affine by the plane at
    infinity, a metric g (3, 3) is preserved by a joint with the linear generator L if Lᵀg + gL = 0, and by the linear
    part M of H up to scale, MᵀgM = |M|^(2/3) g. Both are linear in g.
    """
    A = kinematics.metric_upgrade
    P = np.eye(4)
    P[3, :3] = A[3, :3]
    M = P @ H @ np.linalg.inv(P)
    M = (M / M[3, 3])[:3, :3]
    M = M / np.cbrt(abs(np.linalg.det(M)))
    twists = kinematics.parameters[N_FRAME:].reshape(-1, 6)
    rates = np.linalg.norm(twists[:, :3], axis=1)
    turning = rates > MIN_RATE
    U = A[:3, :3]
    spins = twist_matrices(twists[turning])[:, :3, :3] / rates[turning, None, None]
    L = np.linalg.inv(U) @ spins @ U
    symmetric = np.zeros((6, 3, 3))
    for k, (i, j) in enumerate(zip(*np.triu_indices(3))):
        symmetric[k, i, j] = symmetric[k, j, i] = 1.0
    kept = [L_j.T @ symmetric + symmetric @ L_j for L_j in L] + [M.T @ symmetric @ M - symmetric]
    rows = np.concatenate([change.reshape(6, 9).T for change in kept])
    g = np.tensordot(np.linalg.svd(rows)[2][-1], symmetric, 1)
    values, vectors = np.linalg.eigh(g * np.sign(np.trace(g)))
    if values[0] <= MIN_METRIC * values[-1]:
        return kinematics
    U = np.linalg.qr(np.sqrt(values)[:, None] * vectors.T)[1]
    U = U * np.sign(np.diag(U))[:, None] / abs(U[2, 2])
    frame = np.concatenate([np.log(np.diag(U)[:2]), U[[0, 0, 1], [1, 2, 2]], A[3, :3]])
    found = replace(kinematics, parameters=np.concatenate([frame, kinematics.parameters[N_FRAME:]]))
    change = found.metric_upgrade @ np.linalg.inv(A)
    screws = change @ twist_matrices(twists) @ np.linalg.inv(change)
    spin = (screws - screws.swapaxes(-1, -2)) / 2
    twists = np.column_stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0], screws[:, :3, 3]])
    return replace(kinematics, parameters=np.concatenate([frame, twists.ravel()]))


def fit_similarity(source: Array, target: Array, mirror: bool = False) -> Array:
    """Fit the similarity S, (4, 4), from (N, 3) to (N, 3), by least squares (Umeyama 1991). mirror: it reflects."""
    means = source.mean(0), target.mean(0)
    x, y = source - means[0], target - means[1]
    P, s, Qt = np.linalg.svd(y.T @ x)
    signs = np.array([1.0, 1.0, np.sign(np.linalg.det(P @ Qt)) * (-1.0 if mirror else 1.0)])
    S = np.eye(4)
    S[:3, :3] = (s @ signs / max(float((x**2).sum()), np.finfo(float).tiny)) * (P * signs) @ Qt
    S[:3, 3] = means[1] - S[:3, :3] @ means[0]
    return S


def metric_points(A: NDArray[Any], coordinates: Array) -> Array:
    """Map coordinates (..., N, 3) in the stereo frame to metric ones by A, (..., 4, 4)."""
    h = np.concatenate([coordinates, np.ones((*coordinates.shape[:-1], 1))], -1) @ A.swapaxes(-1, -2)
    return h[..., :3] / np.maximum(h[..., 3:], MIN_DENOMINATOR)


def nearest_similarity(H: Array, A: Array) -> Array:
    """Return the similarity S, (4, 4), of H ~ A_d⁻¹ S A, where the demonstrator may have any frame A_d."""
    B = A @ np.linalg.inv(H)  # ~ S⁻¹ A_d
    B = B / B[3, 3]
    plane, offset = B[3, :3], B[:3, 3]
    Q, R = np.linalg.qr(B[:3, :3] - np.outer(offset, plane))
    Q, scale = Q * np.sign(np.diag(R)), abs(R[2, 2])
    S = np.eye(4)
    S[:3, :3], S[:3, 3] = Q.T / scale, -Q.T @ offset / scale
    return S
