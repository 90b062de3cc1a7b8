"""What is known of a body's images: where they were seen, by displacement."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ..rectification import NEAREST


@dataclass(frozen=True)
class Seen:
    """Of K visits: displacement (K, m) rad; images (K, N, 4) px; whole (K, N) bool, of points seen in both images."""

    displacement: NDArray
    images: NDArray
    whole: NDArray

    def only(self, points: NDArray) -> "Seen":
        """Of these points, (N,) bool, alone."""
        return Seen(self.displacement, self.images, self.whole & points)

    def at(self, visits: NDArray) -> "Seen":
        """Of some of the visits, (K,) bool or indices."""
        return Seen(self.displacement[visits], self.images[visits], self.whole[visits])

    @property
    def points(self) -> int:
        """How many were seen at all."""
        return int(np.count_nonzero(self.whole.any(0)))


# Which joints move which points: told by pairs of images between which a single joint was turned.

LEAST_PX = 0.01  # of motion, without noise
SURELY, DOUBTFUL = 5.0, 0.5  # standard deviations; share of these, from which noise may have hidden a motion
LEAST_TURN = np.radians(1.0)
STILL = 1e-9  # rad


@dataclass(frozen=True)
class Groups:
    """Points that the same joints move. joints: of each group, from the base on; points: of each, indices."""

    joints: tuple[tuple[int, ...], ...]
    points: tuple[NDArray, ...]

    @staticmethod
    def of(moved: NDArray) -> "Groups":
        """moved: (N, m) bool, which joints move a point. What moves more points is nearer to the base."""
        return _groups(moved.tobytes(), moved.shape)

    def project(self, motions: NDArray, shape: NDArray, project: NDArray) -> NDArray:
        """shape: (..., N, 3); motions: (..., B, m, 4, 4); project: (c + 1, 4) → (..., B, N, c)"""
        found = np.empty((*motions.shape[:-3], shape.shape[-2], len(project) - 1))
        space = np.concatenate([shape, np.ones((*shape.shape[:-1], 1))], -1)[..., None, :, :]
        for points, chain in zip(self.points, carried(motions, self.joints, project)):
            of = space[..., points, :] @ chain.swapaxes(-1, -2)
            found[..., points, :] = of[..., :-1] / np.maximum(of[..., -1:], NEAREST)
        return found


@lru_cache(maxsize=64)  # every step of an adjustment asks for the same ones
def _groups(moved: bytes, shape: tuple[int, int]) -> Groups:
    table = np.frombuffer(moved, bool).reshape(shape)
    order = np.argsort(-table.sum(0), kind="stable")
    patterns, of = np.unique(table, axis=0, return_inverse=True)
    joints = tuple(tuple(int(j) for j in order if pattern[j]) for pattern in patterns)
    return Groups(joints, tuple(np.flatnonzero(of.ravel() == k) for k in range(len(patterns))))


def carried(motions: NDArray, groups: tuple[tuple[int, ...], ...], project: NDArray) -> list[NDArray]:
    """project (c, 4) after the motions (..., B, m, 4, 4) of each group's joints, the first of them outermost: for each
    group (..., B, c, 4), of a group that no joint moves (c, 4)."""
    done: dict[tuple[int, ...], NDArray] = {(): project}
    for joints in groups:
        for k in range(1, len(joints) + 1):
            if joints[:k] not in done:
                done[joints[:k]] = done[joints[: k - 1]] @ motions[..., joints[k - 1], :, :]
    return [done[joints] for joints in groups]


def moved_points(seen: Seen, noise_px: float) -> tuple[NDArray, NDArray] | None:
    """(N, m) bool, which joints move each point, and (N,) bool, of which points that is told. noise_px: of an image
    coordinate, standard deviation.

    Of a joint that was not turned alone while a point was seen others may tell: what the outer one moves the inner one
    does. None if the images do not tell of each joint which points it moves.
    """
    farthest = np.full((seen.whole.shape[1], seen.displacement.shape[1]), -1.0)  # px, that a joint moved a point
    for k, l, joint in _turned_alone(seen.displacement):
        far = np.where(seen.whole[k] & seen.whole[l], np.abs(seen.images[k] - seen.images[l]).max(-1), -1.0)
        farthest[:, joint] = np.maximum(farthest[:, joint], far)
    least = max(LEAST_PX, SURELY * np.sqrt(2) * noise_px)
    moved = farthest > least
    asked = moved | ((farthest >= 0) & (farthest < DOUBTFUL * least))
    told = asked.all(1)
    if not moved[told].any(0).all():
        return None
    inner = _inner(moved[told])
    by_outer, by_inner = (moved & asked) @ inner.T, (~moved & asked) @ inner
    return moved | (~asked & by_outer), (asked | by_outer | by_inner).all(1)


def _inner(moved: NDArray) -> NDArray:
    """(m, m) bool: whether a joint moves all that another one moves, and more. moved: (n, m) bool, by which joints a
    point is moved."""
    beyond = moved.T.astype(int) @ ~moved  # how many points one moves that the other does not
    return (beyond > 0) & (beyond.T == 0)


def _turned_alone(displacement: NDArray) -> list[tuple[int, int, int]]:
    """Pairs of visits k, l between which one joint was turned, and no other: k, l, joint."""
    k, l = np.triu_indices(len(displacement), 1)
    turned = np.abs(displacement[k] - displacement[l])
    alone = ((turned > STILL).sum(1) == 1) & (turned.max(1) > LEAST_TURN)
    return list(zip(k[alone].tolist(), l[alone].tolist(), turned[alone].argmax(1).tolist()))
