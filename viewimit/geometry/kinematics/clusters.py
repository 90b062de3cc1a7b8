"""Clusters of body points that the same joints move.

A pair of visits between which a single joint was turned shows which points this joint moves: those whose images differ
by more than noise. Points that the same joints move form a cluster, as all points of a link do. Clusters need one
product of joint motions each, however many points they have.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ..rectification import MIN_DENOMINATOR

MIN_MOTION_PX = 0.01  # smallest motion of an image point that counts without noise
MOTION_SIGMA = 5.0  # standard deviations of a difference of images beyond which a point has moved
REST_FRACTION = 0.5  # of that bound: below it a point has rested; between them noise may have hidden a motion
MIN_TURN_RAD = np.radians(1.0)  # of the joint that was turned
STILL_RAD = 1e-9  # turn up to which a joint has rested


@dataclass(frozen=True)
class Observations:
    """Images of a body at K visited postures."""

    displacement: NDArray[np.float64]  # (K, m) rad
    images: NDArray[np.float64]  # (K, N, 4) px in [L, R]
    visible_in_both: NDArray[np.bool_]  # (K, N)

    def restrict(self, points: NDArray[np.bool_]) -> "Observations":
        """Keep the images of some points, (N,) bool."""
        return Observations(self.displacement, self.images, self.visible_in_both & points)

    def select_visits(self, visits: NDArray[np.bool_]) -> "Observations":
        """Keep some visits, (K,) bool."""
        return Observations(self.displacement[visits], self.images[visits], self.visible_in_both[visits])

    @property
    def n_points(self) -> int:
        """Number of points that were seen in both images at some visit."""
        return int(np.count_nonzero(self.visible_in_both.any(0)))


@dataclass(frozen=True)
class LinkClusters:
    """Points that the same joints move, cluster by cluster."""

    joints: tuple[tuple[int, ...], ...]  # of each cluster, from the base outwards
    points: tuple[NDArray[np.int_], ...]  # of each cluster, indices

    @staticmethod
    def from_table(moved_by: NDArray[np.bool_]) -> "LinkClusters":
        """Cluster points by the joints that move them, (N, m) bool. A joint that moves more points is further in."""
        return _clusters(moved_by.tobytes(), moved_by.shape)

    def project(
        self, motions: NDArray[np.float64], points: NDArray[np.float64], projection: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Move and project the points.

        motions: (..., B, m, 4, 4), of each joint; points: (..., N, 3); projection: (c + 1, 4), or (..., 1, c + 1, 4)
        → (..., B, N, c).
        """
        moved = np.empty((*motions.shape[:-3], points.shape[-2], projection.shape[-2]))
        homogeneous = np.concatenate([points, np.ones((*points.shape[:-1], 1))], -1)[..., None, :, :]
        for members, transform in zip(self.points, chain_transforms(motions, self.joints, projection)):
            moved[..., members, :] = homogeneous[..., members, :] @ transform.swapaxes(-1, -2)
        return moved[..., :-1] / np.maximum(moved[..., -1:], MIN_DENOMINATOR)


@lru_cache(maxsize=64)  # each step of an adjustment asks for the same clusters
def _clusters(moved_by: bytes, shape: tuple[int, int]) -> LinkClusters:
    table = np.frombuffer(moved_by, bool).reshape(shape)
    order = np.argsort(-table.sum(0), kind="stable")
    patterns, index = np.unique(table, axis=0, return_inverse=True)
    joints = tuple(tuple(int(j) for j in order if pattern[j]) for pattern in patterns)
    return LinkClusters(joints, tuple(np.flatnonzero(index.ravel() == k) for k in range(len(patterns))))


def chain_transforms(
    motions: NDArray[np.float64], chains: tuple[tuple[int, ...], ...], projection: NDArray[np.float64]
) -> list[NDArray[np.float64]]:
    """Multiply the motions along each chain of joints, the projection first.

    motions: (..., B, m, 4, 4); projection: (c, 4) → for each chain (..., B, c, 4), for an empty one the projection.
    """
    products: dict[tuple[int, ...], NDArray[np.float64]] = {(): projection}
    for joints in chains:
        for k in range(1, len(joints) + 1):
            if joints[:k] not in products:
                products[joints[:k]] = products[joints[: k - 1]] @ motions[..., joints[k - 1], :, :]
    return [products[joints] for joints in chains]


def single_joint_pairs(displacement: NDArray[np.float64]) -> list[tuple[int, int, int]]:
    """(k, l, joint): pairs of visits between which one joint was turned, and no other."""
    k, l = np.triu_indices(len(displacement), 1)
    turned = np.abs(displacement[k] - displacement[l])
    alone = ((turned > STILL_RAD).sum(1) == 1) & (turned.max(1) > MIN_TURN_RAD)
    return list(zip(k[alone].tolist(), l[alone].tolist(), turned[alone].argmax(1).tolist()))
