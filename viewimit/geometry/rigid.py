"""Rotations and rigid transforms.

`T_a_b` maps points of frame b to frame a. Cameras follow OpenCV: they look along +z, with x to the right and y down.
"""

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray


def rotation_about_axis(axis: ArrayLike, angle: ArrayLike) -> NDArray[np.float64]:
    """Rotation by an angle about an axis, by Rodrigues' formula.

    axis: (3,), of any length; angle: (...) rad → (3, 3, ...): the matrix axes come first, so that a grid of angles
    stays contiguous in memory.
    """
    x, y, z = np.asarray(axis, float).tolist()
    K, K_squared = _skew(x, y, z)
    angle, identity = np.asarray(angle, float), np.eye(3)
    if angle.ndim:
        shape = (3, 3) + (1,) * angle.ndim
        return _rodrigues(K.reshape(shape), K_squared.reshape(shape), identity.reshape(shape), angle)
    return _rodrigues(K, K_squared, identity, angle)


def _rodrigues(
    K: NDArray[np.float64], K_squared: NDArray[np.float64], identity: NDArray[np.float64], angle: NDArray[np.float64]
) -> NDArray[np.float64]:
    return identity + np.sin(angle) * K + (1 - np.cos(angle)) * K_squared


@lru_cache(maxsize=256)  # a robot has the same few axes at every posture
def _skew(x: float, y: float, z: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """[a]× and [a]×² of the normalised axis."""
    x, y, z = np.array([x, y, z]) / np.linalg.norm([x, y, z])
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return K, K @ K


def rotation_from_rpy(rpy: ArrayLike) -> NDArray[np.float64]:
    """Rotation of URDF's roll, pitch and yaw [rad] about fixed axes, Rz(yaw) Ry(pitch) Rx(roll): (3, 3)."""
    roll, pitch, yaw = np.asarray(rpy, float)
    return (
        rotation_about_axis([0, 0, 1], yaw)
        @ rotation_about_axis([0, 1, 0], pitch)
        @ rotation_about_axis([1, 0, 0], roll)
    )


def rigid_transform(rotation: ArrayLike, translation: ArrayLike = (0, 0, 0)) -> NDArray[np.float64]:
    """Homogeneous transform (4, 4) of a rotation (3, 3) and a translation (3,) m."""
    T = np.eye(4)
    T[:3, :3] = rotation
    T[:3, 3] = translation
    return T


def look_rotation(direction: ArrayLike) -> NDArray[np.float64]:
    """R_world_camera, (3, 3), of a camera that looks along `direction` with its image upright.

    Raises ValueError if the direction is zero or vertical.
    """
    forward = np.asarray(direction, float)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    if np.linalg.norm(right) < 1e-9 * max(float(np.linalg.norm(forward)), 1e-300):
        raise ValueError(f"cannot look along {direction!r}: it is zero or parallel to up, the z axis")
    right /= np.linalg.norm(right)
    forward = forward / np.linalg.norm(forward)
    return np.stack([right, np.cross(forward, right), forward], axis=1)
