"""Rotations as viser takes them: unit quaternions (w, x, y, z)."""

from collections.abc import Sequence
from math import cos, sin

import numpy as np
from numpy.typing import NDArray


def quaternion(rotation: NDArray) -> tuple[float, float, float, float]:
    """R (3, 3) → (w, x, y, z), by the largest of its four squares (Shepperd 1978)."""
    m = rotation
    squares = np.array(
        [
            1 + m[0, 0] + m[1, 1] + m[2, 2],
            1 + m[0, 0] - m[1, 1] - m[2, 2],
            1 - m[0, 0] + m[1, 1] - m[2, 2],
            1 - m[0, 0] - m[1, 1] + m[2, 2],
        ]
    )
    k = int(np.argmax(squares))
    products = np.array(
        [
            [squares[0], m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]],
            [m[2, 1] - m[1, 2], squares[1], m[1, 0] + m[0, 1], m[0, 2] + m[2, 0]],
            [m[0, 2] - m[2, 0], m[1, 0] + m[0, 1], squares[2], m[2, 1] + m[1, 2]],
            [m[1, 0] - m[0, 1], m[0, 2] + m[2, 0], m[2, 1] + m[1, 2], squares[3]],
        ]
    )
    w, x, y, z = products[k] / (2 * np.sqrt(squares[k]))
    return float(w), float(x), float(y), float(z)


def joint_quaternion(
    T_parent_joint_wxyz: Sequence[float], axis: Sequence[float], angle: float
) -> tuple[float, float, float, float]:
    """Orientation of a joint's frame at `angle` rad: that of angle 0 times the turn about its axis, (3,)."""
    a, b, c, d = T_parent_joint_wxyz
    s, w = sin(angle / 2), cos(angle / 2)
    x, y, z = s * axis[0], s * axis[1], s * axis[2]
    return (
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    )
