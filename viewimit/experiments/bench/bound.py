"""The Cramér-Rao bound: how exactly the joints can be told at best from noisy images.

What is not known of the two bodies and places is one projective map of space: the demonstrator's points are H times the
own ones, H (4, 4), so that its images depend on θ and H. Either the own images are granted at every posture, without
noise; or they are as noisy, and all that tells of the own body is what was seen of it at the postures visited: then
where its points and joints are, by what each joint's angles are multiplied, and the projective frame A that
uncalibrated eyes leave open, are not known either. The fundamental matrix of the head is granted. It needs the truth,
so it is for benchmarks.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...simulation.camera import Cameras
from ...simulation.world import World

STEP = 1e-5  # rad, m
SINGULAR = 1e-10  # of the largest singular value: what moves nothing, as scales and where the two bodies stand
PROJECTIVE = 16  # numbers of a projective map of space
UNTOLD = 1e-6  # of what a joint moves images by: what the unknown leaves of it, if nothing tells it


def bound(
    world: World,
    theta: NDArray,
    noise_px: float,
    visited: Sequence[NDArray] | None = None,
    seen: NDArray | None = None,
) -> NDArray:
    """theta: (m,) rad, of the demonstrator; noise_px: of image coordinates; visited: (m,) rad each, postures that the
    own body is known by, None if its images are granted; seen: (N, 2) bool, which images of the demonstrator there are,
    None for all → standard deviations (m,) rad, inf of joints that nothing tells."""
    J, unknown = _demo_images(world, theta)
    if visited is not None:
        own = np.vstack([_own_images(world, posture) for posture in visited])
        J, unknown = np.vstack([J, np.zeros((len(own), J.shape[1]))]), np.vstack([unknown, own])
    if seen is not None:
        known = np.concatenate([np.repeat(seen, 2), np.ones(len(J) - 2 * seen.size, bool)])
        J, unknown = J[known], unknown[known]
    if visited is None:
        unknown = unknown[:, :PROJECTIVE]
    size = np.linalg.norm(unknown, axis=0)
    U, sigma, _ = np.linalg.svd(unknown / np.where(size > 0, size, 1.0), full_matrices=False)
    U = U[:, sigma > SINGULAR * sigma.max(initial=0.0)]
    left = J - U @ (U.T @ J)
    told, directions = np.linalg.eigh(left.T @ left)
    lost = told <= (UNTOLD * np.linalg.norm(J, axis=0).max()) ** 2
    variances = (directions[:, ~lost] ** 2 / told[~lost]).sum(1)
    return noise_px * np.where((np.abs(directions[:, lost]) > UNTOLD).any(1), np.inf, np.sqrt(variances))


def _demo_images(world: World, theta: NDArray) -> tuple[NDArray, NDArray]:
    """(4 N, m) px/rad by the joints, and by H, by the frame, which moves none of them, and by the body."""
    demo, own = (world.points_world(theta, T) for T in (world.T_world_demo, world.T_world_own))
    H = _similarity(own, demo)[:, :3]
    motions = [_projective_motions(demo), np.zeros((PROJECTIVE, *demo.shape)), _body_motions(world, theta) @ H.T]
    by_image = _image_derivatives(world.demo_pair, demo)
    return _moved(by_image, _joint_motions(world, theta) @ H.T), _moved(by_image, np.concatenate(motions))


def _own_images(world: World, theta: NDArray) -> NDArray:
    """(4 N, 32 + P), as the second of `_demo_images`, of the own ones at a posture: H moves none of them."""
    own = world.points_world(theta, world.T_world_own)
    motions = [np.zeros((PROJECTIVE, *own.shape)), _projective_motions(own), _body_motions(world, theta)]
    return _moved(_image_derivatives(world.own_pair, own), np.concatenate(motions))


def _joint_motions(world: World, theta: NDArray) -> NDArray:
    """(m, N, 3) m/rad of the own points."""
    at = lambda step: world.points_world(theta + step, world.T_world_own)
    return np.array([(at(step) - at(-step)) / (2 * STEP) for step in STEP * np.eye(len(theta))])


def _body_motions(world: World, theta: NDArray) -> NDArray:
    """(P, N, 3) of the own points: with where each point is on its link, with where and how each moving link is on its
    joint, and with each joint's factor."""
    points, frames = world.points_world(theta, world.T_world_own), world.link_frames(theta, world.T_world_own)
    count, link = len(points), world.body.link
    of_points = np.zeros((count, 3, count, 3))
    of_points[range(count), :, range(count)] = frames[link, :3, :3].swapaxes(1, 2)
    of_joints = [angle * motion for angle, motion in zip(theta, _joint_motions(world, theta))]
    for joint in world.scene.moving:
        carried, axes = (link > joint)[:, None], frames[joint + 1, :3, :3].T
        arms = points - frames[joint + 1, :3, 3]
        of_joints += [carried * np.cross(axis, arms) for axis in axes] + [carried * axis for axis in axes]
    return np.concatenate([of_points.reshape(-1, count, 3), of_joints])


def _projective_motions(points: NDArray) -> NDArray:
    """(16, N, 3) of points (N, 3) m, by each number of a (4, 4) that maps them, about 1."""
    h = np.concatenate([points, np.ones((len(points), 1))], 1).T
    affine = h[:, None, :, None] * np.eye(3)[:, None]
    return np.concatenate([affine.reshape(-1, len(points), 3), h[:, :, None] * points])


def _image_derivatives(pair: Cameras, points: NDArray) -> NDArray:
    """(N, 4, 3) px/m, by points (N, 3) m."""
    at = lambda step: np.concatenate(list(pair.images(points + step)[0]), 1)
    return np.stack([(at(step) - at(-step)) / (2 * STEP) for step in STEP * np.eye(3)], -1)


def _moved(by_image: NDArray, motions: NDArray) -> NDArray:
    """(4 N, P) of images with these derivatives, (N, 4, 3), as motions (P, N, 3) move their points."""
    return np.einsum("nij,pnj->nip", by_image, motions).reshape(-1, len(motions))


def _similarity(a: NDArray, b: NDArray) -> NDArray:
    """(3, 4) of b = s R a + t, for points (N, 3) m of bodies that are alike (Umeyama 1991, without noise)."""
    mean_a, mean_b = a.mean(0), b.mean(0)
    U, sigma, Vt = np.linalg.svd((b - mean_b).T @ (a - mean_a))
    R = U @ np.diag([1, 1, np.sign(np.linalg.det(U @ Vt))]) @ Vt
    s = np.linalg.norm(b - mean_b) / np.linalg.norm(a - mean_a)
    return np.column_stack([s * R, mean_b - s * R @ mean_a])
