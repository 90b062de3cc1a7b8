"""Which joints move each point: what the order of the joints implies at first, then what is likeliest for all images.

A chain is the set of joints that move a point. With the joints' motions given, each point takes the chain, and the
position, that leave the least squares in all its images. Motions and chains are improved in turn, as in k-means.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .adjustment import BundleAdjustment
from .clusters import MIN_MOTION_PX, MOTION_SIGMA, REST_FRACTION, Observations, chain_transforms, single_joint_pairs
from .maximum_likelihood import contradictions
from .model import ProjectiveKinematics

Array = NDArray[np.float64]
Chains = NDArray[np.bool_]  # (N, m) or (Q, m)
POINT_STEPS = 3  # Gauss-Newton steps of a point
DAMPING = 1e-9  # of these, relative to the trace


def first_chains(observations: Observations, noise_px: float) -> tuple[Chains, NDArray[np.bool_]] | None:
    """Find which joints move each point from pairs of visits between which one joint turned.

    Parameters
    ----------
    observations : Observations
        Images of K visits.
    noise_px : float
        Standard deviation of an image coordinate.

    Returns
    -------
    tuple or None
        Which joints move a point, (N, m) bool, and for which points that is known, (N,) bool. None if some joint moves
        none of these.

    Notes
    -----
    Where a joint moves points that another one does not, and never the reverse, it is further in: it moves all points
    that the other one moves. This is asked again until nothing follows.
    """
    visible, m = observations.visible_in_both, observations.displacement.shape[1]
    farthest = np.full((visible.shape[1], m), -1.0)  # px, -1 if never observed
    for k, l, joint in single_joint_pairs(observations.displacement):
        px = np.abs(observations.images[k] - observations.images[l]).max(-1)
        farthest[:, joint] = np.maximum(farthest[:, joint], np.where(visible[k] & visible[l], px, -1.0))
    least = max(MIN_MOTION_PX, MOTION_SIGMA * np.sqrt(2) * noise_px)
    moved, rested = farthest > least, (farthest >= 0) & (farthest < REST_FRACTION * least)
    for _ in range(m):
        beyond = moved.T.astype(int) @ rested
        inner = (beyond > 0) & (beyond.T == 0)
        moved, rested = moved | (~rested & (moved @ inner.T)), rested | (~moved & (rested @ inner))
    known = (moved | rested).all(1)
    return (moved, known) if moved[known].any(0).all() else None


def with_likely_chains(
    kinematics: ProjectiveKinematics, problem: BundleAdjustment, doubtful: NDArray[np.bool_]
) -> ProjectiveKinematics:
    """Give each doubtful point the chain and the position that explain its images best.

    Parameters
    ----------
    kinematics : ProjectiveKinematics
        Gives the motions of the joints.
    problem : BundleAdjustment
        Has the images.
    doubtful : (N,) array of bool
        Points that may take another chain.

    Returns
    -------
    ProjectiveKinematics
        The same object if no point changes, or if a joint would move no point any more.
    """
    known = kinematics.moved_by[~kinematics.unknown]
    if not doubtful.any() or not len(known):
        return kinematics
    chains, index = np.array(list(_candidates(known))), np.flatnonzero(doubtful)
    cost, positions = _PointFit.of(kinematics, problem, chains, index).solve()
    moved_by, points, best = kinematics.moved_by.copy(), kinematics.points.copy(), cost.argmin(0)
    for k, point in enumerate(index):
        now = np.flatnonzero((chains == moved_by[point]).all(1) & ~kinematics.unknown[point])
        if not len(now) or cost[best[k], k] < cost[now[0], k] - problem.noise_floor_px**2:
            moved_by[point], points[point] = chains[best[k]], positions[best[k], k]
    if not moved_by[~np.isnan(points[:, 0])].any(0).all():
        return kinematics
    same = (moved_by == kinematics.moved_by).all() and (np.isnan(points) == np.isnan(kinematics.points)).all()
    return kinematics if same else replace(kinematics, moved_by=moved_by, points=points)


def _candidates(known: Chains) -> Iterator[NDArray[np.bool_]]:
    """Yield the chains of known points, and those with one joint more or less that no other chain contradicts."""
    m = known.shape[1]
    used = {row.tobytes() for row in known}
    for chain in np.unique([*known, *(known[:, None] ^ np.eye(m, dtype=bool)).reshape(-1, m)], axis=0):
        if chain.tobytes() in used or not contradictions(np.vstack([known, chain])):
            yield chain


@dataclass(frozen=True)
class _PointFit:
    """n points, each fitted with each of Q chains."""

    transforms: Array  # (Q, 1, K, 4, 4): where a point at the reference is at each visit
    observed: Array  # (n, K, 3): coordinates of its images
    weight: Array  # (n, K, 3) px: of a coordinate, 0 where the point was not seen
    first: NDArray[np.int_]  # (n,): the first visit that shows the point

    @classmethod
    def of(
        cls, kinematics: ProjectiveKinematics, problem: BundleAdjustment, chains: Chains, index: NDArray[np.int_]
    ) -> "_PointFit":
        order = np.argsort(-kinematics.moved_by.sum(0), kind="stable")
        motions = kinematics.motions(problem.observations.displacement)
        joints = tuple(tuple(int(j) for j in order if chain[j]) for chain in chains)
        transforms = chain_transforms(motions, joints, np.eye(4))
        T = np.stack([np.broadcast_to(one, (len(motions), 4, 4)) for one in transforms])[:, None]
        visible = problem.observations.visible_in_both[:, index].T
        enlarged = problem.magnification[:, index].swapaxes(0, 1)
        weight = visible[..., None] * kinematics.frame.unit_px / enlarged
        return cls(T, problem.coordinates[:, index].swapaxes(0, 1), weight, visible.argmax(1))

    def solve(self) -> tuple[Array, Array]:
        """Return the squared residuals, (Q, n) px², and the points at the reference, (Q, n, 3)."""
        T, n = self.transforms, np.arange(len(self.first))
        start = np.concatenate([self.observed[n, self.first], np.ones((len(n), 1))], 1)
        X = np.linalg.solve(T[:, 0, self.first], start[..., None])[..., 0]
        X = X[..., :3] / X[..., 3:]
        for _ in range(POINT_STEPS):
            r, p, w = self._residuals(X)
            J = self.weight[..., None] * (T[..., :3, :3] - p[..., None] * T[..., 3:, :3]) / w[..., None]
            J, e = J.reshape(*J.shape[:2], -1, 3), r.reshape(*r.shape[:2], -1, 1)
            H = J.swapaxes(-1, -2) @ J
            least = DAMPING * np.trace(H, axis1=-1, axis2=-2)[..., None, None] + np.finfo(float).tiny
            X = X - np.linalg.solve(H + least * np.eye(3), J.swapaxes(-1, -2) @ e)[..., 0]
        cost = (self._residuals(X)[0] ** 2).sum((-1, -2))
        return np.nan_to_num(cost, nan=np.inf), X

    def _residuals(self, X: Array) -> tuple[Array, Array, Array]:
        """Residuals (Q, n, K, 3) px of points (Q, n, 3), where they are (Q, n, K, 3), and their depths (…, 1)."""
        h = (self.transforms[..., :3] @ X[:, :, None, :, None])[..., 0] + self.transforms[..., 3]
        p = h[..., :3] / h[..., 3:]
        return self.weight * (p - self.observed), p, h[..., 3:]
