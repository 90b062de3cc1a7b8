"""The Cramér-Rao bound: the smallest standard error of the joints that an unbiased estimator can have.

There are two bounds for bodies that are alike. The demonstrator's points are H times the learner's, with H (4, 4).

Bound by E   H is any projective map of space, 16 unknowns. E leaves as many open: this is the bound of any method by E.
Bound with one head   H is a similarity, 7 unknowns: one head sees both bodies, and they have one shape. It is smaller.
    The likelihood servo knows this.

Either the learner's own images are granted at every posture without noise. Or they are as noisy, and the learner knows
its body from the postures visited only. Then these are unknown too: the points and joint axes, a factor for each
joint's angle, and the projective frame A that uncalibrated cameras leave open. The fundamental matrix of the head is
granted.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...geometry.kinematics.two_bodies import fit_similarity
from ...simulation.camera import Camera, Cameras
from ...simulation.world import World

FD_STEP = 1e-5  # rad, m
MIN_SINGULAR_VALUE = 1e-10  # relative to the largest: parameters below it move no image, such as a scale
PROJECTIVE, SIMILARITY = 16, 7  # parameters of a projective map of space, and of a similarity
MIN_IMAGE_MOTION = 1e-6  # relative to the largest: a direction that moves images by less is unobservable


def bound(
    world: World,
    theta: NDArray[np.float64],
    noise_px: float,
    visited: Sequence[NDArray[np.float64]] | None = None,
    seen: NDArray[np.bool_] | None = None,
    one_head: bool = False,
    another_body: bool = False,
    earlier: Sequence[NDArray[np.float64]] = (),
) -> NDArray[np.float64]:
    """Compute the bound at the demonstrator's posture theta, (m,) rad: standard errors, inf for unobservable joints.

    noise_px: standard deviation of a coordinate; visited: postures at which the learner has seen its own body, (m,) rad
    each, None: its images are granted; seen: (N, 2), which points are in which image of the demonstrator, None: all.
    one_head: whether it is the bound with one head, else that by E; another_body: whether its joints may be attached
    elsewhere, the same in each posture, seen by one head, which needs `visited`; earlier: other postures of the
    demonstrator that were seen, unknown as the first, with all points visible.
    """
    one_head = one_head or another_body
    J, unknown = _demo_images(world, theta, one_head, another_body)
    if seen is not None:
        J, unknown = J[np.repeat(seen, 2)], unknown[np.repeat(seen, 2)]
    angles = [J]
    for posture in earlier:
        further, by_others = _demo_images(world, posture, one_head, another_body)
        angles, unknown = [*angles, further], np.vstack([unknown, by_others])
    if visited is not None:
        own = np.vstack([_own_images(world, posture, one_head, another_body) for posture in visited])
        unknown = np.vstack([unknown, own])
    else:
        unknown = unknown[:, : SIMILARITY if one_head else PROJECTIVE]
    by_angles = _block_diagonal(angles, len(unknown))
    J, unknown = by_angles[:, : J.shape[1]], np.hstack([by_angles[:, J.shape[1] :], unknown])
    size = np.linalg.norm(unknown, axis=0)
    U, sigma, _ = np.linalg.svd(unknown / np.where(size > 0, size, 1.0), full_matrices=False)
    U = U[:, sigma > MIN_SINGULAR_VALUE * sigma.max(initial=0.0)]
    projected = J - U @ (U.T @ J)
    information, directions = np.linalg.eigh(projected.T @ projected)
    lost = information <= (MIN_IMAGE_MOTION * np.linalg.norm(J, axis=0).max()) ** 2
    variances = (directions[:, ~lost] ** 2 / information[~lost]).sum(1)
    return noise_px * np.where((np.abs(directions[:, lost]) > MIN_IMAGE_MOTION).any(1), np.inf, np.sqrt(variances))


def _block_diagonal(blocks: Sequence[NDArray], rows: int) -> NDArray:
    """Place blocks of m columns along the diagonal, with rows of zeros below up to this number: each posture's images
    depend on its own angles only."""
    found, row = np.zeros((rows, sum(block.shape[1] for block in blocks))), 0
    for k, block in enumerate(blocks):
        found[row : row + len(block), k * block.shape[1] : (k + 1) * block.shape[1]] = block
        row += len(block)
    return found


def _demo_images(world: World, theta: NDArray, one_head: bool, another_body: bool) -> tuple[NDArray, NDArray]:
    """Derivatives of the demonstrator's images by the joints, (4 N, m) px/rad, and by H, frame and body, (4 N, 32 + P).

    The frame moves none of them. With one head H is a similarity, 7 instead of 16 unknowns, and the frame is of the
    head, so it moves both bodies' images. In another body each joint is shifted, too: 3 m more.
    """
    demo, own = (world.points_world(theta, T) for T in (world.T_world_demo, world.T_world_own))
    H = fit_similarity(own, demo)[:3, :3]
    if one_head:
        first, frame = _similarity_motions(demo, world.T_world_demo[:3, 3]), _head_motions(world.demo_cameras[0], demo)
        if another_body:
            first = np.concatenate([first, *(shift @ H.T for shift in _joint_shifts(world, theta, of_parent=True))])
    else:
        first, frame = _projective_motions(demo), np.zeros((PROJECTIVE, *demo.shape))
    by_image = _image_derivatives(world.demo_pair, demo)
    motions = np.concatenate([first, frame, _body_motions(world, theta) @ H.T])
    return _image_motions(by_image, _joint_motions(world, theta) @ H.T), _image_motions(by_image, motions)


def _own_images(world: World, theta: NDArray, one_head: bool, another_body: bool) -> NDArray:
    """Derivatives of the own images at a posture by H, frame and body, (4 N, 32 + P). H moves none of them."""
    own = world.points_world(theta, world.T_world_own)
    frame = _head_motions(world.own_cameras[0], own) if one_head else _projective_motions(own)
    unknowns = (SIMILARITY if one_head else PROJECTIVE) + (3 * len(theta) if another_body else 0)
    first = np.zeros((unknowns, *own.shape))
    motions = np.concatenate([first, frame, _body_motions(world, theta)])
    return _image_motions(_image_derivatives(world.own_pair, own), motions)


def _joint_motions(world: World, theta: NDArray) -> NDArray:
    """Derivatives of the own points by the joints, (m, N, 3) m/rad."""
    at = lambda step: world.points_world(theta + step, world.T_world_own)
    return np.array([(at(step) - at(-step)) / (2 * FD_STEP) for step in FD_STEP * np.eye(len(theta))])


def _body_motions(world: World, theta: NDArray) -> NDArray:
    """Derivatives of the own points by the body, (P, N, 3).

    They are by the points on their links, by the pose of each moving link on its joint, and by each joint's factor.
    """
    points, frames = world.points_world(theta, world.T_world_own), world.link_frames(theta, world.T_world_own)
    count, link = len(points), world.body.link
    of_points = np.zeros((count, 3, count, 3))
    of_points[range(count), :, range(count)] = frames[link, :3, :3].swapaxes(1, 2)
    of_joints = [angle * motion for angle, motion in zip(theta, _joint_motions(world, theta))]
    for joint, shifts in zip(world.scene.moving, _joint_shifts(world, theta)):
        moved, axes = (link > joint)[:, None], frames[joint + 1, :3, :3].T
        arms = points - frames[joint + 1, :3, 3]
        of_joints += [moved * np.cross(axis, arms) for axis in axes] + list(shifts)
    return np.concatenate([of_points.reshape(-1, count, 3), of_joints])


def _joint_shifts(world: World, theta: NDArray, of_parent: bool = False) -> list[NDArray]:
    """Derivatives of the own points by a shift of each joint, (3, N, 3) each.

    The shift is along three axes that turn with the joint's own link, or with its parent if the joint is attached
    elsewhere there.
    """
    frames, link = world.link_frames(theta, world.T_world_own), world.body.link
    axes = frames[:-1] if of_parent else frames[1:]
    return [(link > joint)[:, None] * axes[joint, :3, :3].T[:, None] for joint in world.scene.moving]


def _similarity_motions(points: NDArray, centre: NDArray) -> NDArray:
    """Derivatives of points (N, 3) m by a rotation about a centre, a translation and the scale, (7, N, 3)."""
    arms = points - centre
    turns = [np.cross(axis, arms) for axis in np.eye(3)]
    return np.array([*turns, *(np.broadcast_to(axis, arms.shape) for axis in np.eye(3)), arms])


def _head_motions(camera: Camera, points: NDArray) -> NDArray:
    """As `_projective_motions`, in the frame of a camera, which turns with the head."""
    R, centre = camera.T_world_camera[:3, :3], camera.T_world_camera[:3, 3]
    return _projective_motions((points - centre) @ R) @ R.T


def _projective_motions(points: NDArray) -> NDArray:
    """Derivatives of points (N, 3) m by the entries of a (4, 4) map about the identity, (16, N, 3)."""
    h = np.concatenate([points, np.ones((len(points), 1))], 1).T
    affine = h[:, None, :, None] * np.eye(3)[:, None]
    return np.concatenate([affine.reshape(-1, len(points), 3), h[:, :, None] * points])


def _image_derivatives(pair: Cameras, points: NDArray) -> NDArray:
    """Derivatives of images by points (N, 3) m, (N, 4, 3) px/m."""
    at = lambda step: np.concatenate(list(pair.images(points + step)[0]), 1)
    return np.stack([(at(step) - at(-step)) / (2 * FD_STEP) for step in FD_STEP * np.eye(3)], -1)


def _image_motions(by_image: NDArray, motions: NDArray) -> NDArray:
    """Chain rule: image derivatives (N, 4, 3) and motions of the points (P, N, 3) → (4 N, P)."""
    return np.einsum("nij,pnj->nip", by_image, motions).reshape(-1, len(motions))
