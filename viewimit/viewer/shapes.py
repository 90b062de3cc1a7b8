"""Shapes of the 3-D scene: pedestals, the head, image plates, markers of the points.

All are closed, and their faces turn outwards: what is seen from one side only is drawn in half the time, and casts its
shadow from behind, so that it does not lie on itself.
"""

from itertools import product

import numpy as np
from numpy.typing import NDArray

OCTAHEDRON_VERTICES = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=np.float32)
OCTAHEDRON_FACES = np.array(
    [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]], dtype=np.uint32
)

BOX_CORNERS = np.array(list(product((-0.5, 0.5), repeat=3)))
BOX_SIDES = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
BOX_FACES = BOX_SIDES[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)


def octahedron(size: float) -> tuple[NDArray, NDArray]:
    """Vertices and faces with vertices split, so that it shades as eight facets. size: m across."""
    vertices = OCTAHEDRON_VERTICES[OCTAHEDRON_FACES].reshape(-1, 3) * (size / 2)
    return vertices, np.arange(24, dtype=np.uint32).reshape(8, 3)


def turned(profile: list[tuple[float, float]], sides: int = 32) -> tuple[NDArray, NDArray]:
    """A solid of revolution about z. profile: (radius, z) m from the bottom up; edges stay sharp."""
    angles = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    circle = np.stack([np.cos(angles), np.sin(angles)], -1)
    vertices: list[NDArray] = []
    faces: list[NDArray] = []
    for (r0, z0), (r1, z1) in zip(profile, profile[1:]):
        first = sum(len(ring) for ring in vertices)
        for r, z in ((r0, z0), (r1, z1)):
            vertices.append(np.column_stack([circle * r, np.full(sides, z)]))
        i, j = np.arange(sides), (np.arange(sides) + 1) % sides
        lower, upper = first + i, first + sides + i
        faces.append(np.column_stack([lower, first + j, upper]))
        faces.append(np.column_stack([first + j, first + sides + j, upper]))
    return np.concatenate(vertices).astype(np.float32), np.concatenate(faces).astype(np.uint32)


def pedestal(height: float) -> tuple[NDArray, NDArray]:
    """A column on a plate; its top is the origin."""
    return turned([(0, -height), (0.2, -height), (0.2, 0.03 - height), (0.11, 0.03 - height), (0.11, 0.0), (0, 0.0)])


def stand(height: float) -> tuple[NDArray, NDArray]:
    """A thin post on a plate; its top is the origin."""
    return turned([(0, -height), (0.16, -height), (0.16, 0.02 - height), (0.022, 0.02 - height), (0.022, 0), (0, 0)])


def sheet(corners: NDArray) -> tuple[NDArray, NDArray]:
    """A quadrilateral, (4, 3) m, that is seen from both sides."""
    faces = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32)
    return np.concatenate([corners, corners]).astype(np.float32), np.concatenate([faces, faces[:, ::-1] + 4])


def box(size: tuple[float, float, float]) -> tuple[NDArray, NDArray]:
    """An axis-aligned box about the origin, its faces flat."""
    vertices = (BOX_CORNERS[BOX_FACES].reshape(-1, 3) * size).astype(np.float32)
    return vertices, np.arange(len(vertices), dtype=np.uint32).reshape(-1, 3)
