"""The Cramér-Rao bound: how exactly the joints can be told at best from noisy images of the demonstrator.

What is granted: the fundamental matrix of the head, and the own images at every posture, both without noise. What is
not known of the two bodies and places is one projective map of space: the demonstrator's points are H times the own
ones, H (4, 4), so that its images depend on θ and H. It needs the truth, so it is for benchmarks.
"""

import numpy as np
from numpy.typing import NDArray

from ...simulation.world import World

STEP = 1e-5  # rad, m
SINGULAR = 1e-9


def bound(world: World, theta: NDArray, noise_px: float) -> NDArray:
    """theta: (m,) rad, of the demonstrator; noise_px: of its image coordinates → standard deviations (m,) rad."""
    demo, own = (world.points_world(theta, T) for T in (world.T_world_demo, world.T_world_own))
    H = _similarity(own, demo)
    by_joint = [_points_motion(world, theta, step) @ H[:, :3].T for step in STEP * np.eye(len(theta))]
    h = np.concatenate([own, np.ones((len(own), 1))], 1)
    by_H = [coordinate[:, None] * row for coordinate in h.T for row in np.eye(3)]
    by_H += [coordinate[:, None] * demo for coordinate in h.T]  # H's last row moves points towards the origin
    J, J_H = (np.stack([_image_motion(world, demo, motion) for motion in motions], 1) for motions in (by_joint, by_H))
    U, sigma, _ = np.linalg.svd(J_H / np.linalg.norm(J_H, axis=0), full_matrices=False)
    U = U[:, sigma > SINGULAR * sigma[0]]  # one direction, H's scale, moves nothing
    told = J - U @ (U.T @ J)
    return noise_px * np.sqrt(np.diag(np.linalg.pinv(told.T @ told)))


def _points_motion(world: World, theta: NDArray, step: NDArray) -> NDArray:
    """(N, 3) m/rad of the own points along a step, (m,) rad, of length STEP."""
    ahead, behind = (world.points_world(theta + sign * step, world.T_world_own) for sign in (1, -1))
    return (ahead - behind) / (2 * STEP)


def _similarity(a: NDArray, b: NDArray) -> NDArray:
    """(3, 4) of b = s R a + t, for points (N, 3) m of bodies that are alike (Umeyama 1991, without noise)."""
    mean_a, mean_b = a.mean(0), b.mean(0)
    U, sigma, Vt = np.linalg.svd((b - mean_b).T @ (a - mean_a))
    R = U @ np.diag([1, 1, np.sign(np.linalg.det(U @ Vt))]) @ Vt
    s = np.linalg.norm(b - mean_b) / np.linalg.norm(a - mean_a)
    return np.column_stack([s * R, mean_b - s * R @ mean_a])


def _image_motion(world: World, points: NDArray, motion: NDArray) -> NDArray:
    """(4 N,) px: how the images in [l], [r] of points (N, 3) m move with a motion (N, 3) m."""
    short = STEP / max(float(np.abs(motion).max()), 1e-300)
    ahead, behind = (world.demo_pair.images(points + sign * short * motion)[0] for sign in (1, -1))
    return ((ahead - behind) / (2 * short)).ravel()
