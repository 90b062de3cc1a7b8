"""What stands for links that nobody drew: rods between joints, and a foot under the first."""

import numpy as np
import trimesh
from numpy.typing import NDArray

SLENDER = 0.035  # of an arm's length: the radius of its rods
SHORT = 0.05  # of an arm's length: what is nearer than that has no rod to it
STUB = 0.12  # of an arm's length: a rod that leads nowhere


def rod(end: NDArray, length: float) -> trimesh.Trimesh | None:
    """From the origin to `end` (3,) m, of an arm of that length; None where it would be too short to be seen."""
    distance = float(np.linalg.norm(end))
    if distance < SHORT * length:
        return None
    mesh = trimesh.creation.cylinder(SLENDER * length, distance, sections=12)
    mesh.apply_translation([0, 0, distance / 2])
    mesh.apply_transform(trimesh.geometry.align_vectors([0, 0, 1], end / distance))
    return mesh


def stub(axis: NDArray, length: float) -> trimesh.Trimesh:
    """Of a last link: a bar across its joint's axis, so that it is seen to turn."""
    axis = axis / np.linalg.norm(axis)
    aside = np.cross(axis, [1, 0, 0] if abs(axis[0]) < 0.9 else [0, 1, 0])
    mesh = trimesh.creation.box((STUB * length, SLENDER * length, 2 * SLENDER * length))
    mesh.apply_translation([STUB * length / 2, 0, 0])
    turn = np.eye(4)
    turn[:3, 0] = aside / np.linalg.norm(aside)
    turn[:3, 2] = axis
    turn[:3, 1] = np.cross(turn[:3, 2], turn[:3, 0])
    mesh.apply_transform(turn)
    return mesh


def foot(top: NDArray, length: float) -> trimesh.Trimesh:
    """A block whose top is at (3,) m, where an arm of that length begins."""
    mesh = trimesh.creation.box((0.25 * length, 0.18 * length, 0.12 * length))
    mesh.apply_translation(top - [0, 0, 0.06 * length])
    return mesh
