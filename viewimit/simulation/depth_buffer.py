"""A depth buffer in numpy: which triangle or ball is nearest at each sample of a picture, and its colour.

A pixel has `samples` samples per axis. Sample (i, j) lies at ((j + 0.5) / samples, (i + 0.5) / samples) px. Each holds
one 64-bit integer, the inverse depth above the colour. The bits of positive floats order as their values do, so
`numpy.maximum.at` keeps the nearest of all surfaces that cover a sample, with its colour. Other renderers need OpenGL,
which a machine without a display lacks, or wheels that most Pythons do not have.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..geometry.arrays import Floats
from .camera import Camera

NEAR_M = 0.05  # triangles and balls that reach nearer to a camera are left out
EDGE = 1e-9  # samples beyond an edge that still count, so that no gap is left between neighbours
AMBIENT, DIFFUSE = 0.55, 0.4  # shares of a colour that are seen everywhere, and towards the light
TOWARDS_LIGHT = np.array([-1.5, 0.5, 3.0]) / np.sqrt(11.5)  # in the world

CUBE = np.array([(x, y, z) for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])  # around a unit ball

Ints = NDArray[np.int_]


@dataclass(frozen=True, eq=False)
class Triangles:
    """Grey triangles in the world."""

    vertices: Floats  # (V, 3) m
    faces: Ints  # (F, 3) indices of vertices
    normals: Floats  # (V, 3) unit vectors outwards
    grey: Floats  # (V,) 0 … 1


class DepthBuffer:
    """The nearest surfaces seen by a camera."""

    def __init__(self, camera: Camera, samples: int):
        self._camera, self._samples = camera, samples
        self._shape = samples * camera.height, samples * camera.width
        self._nearest = np.zeros(self._shape[0] * self._shape[1], np.uint64)

    @property
    def inverse_depth(self) -> NDArray[np.float32]:
        """(height, width) of the samples [1/m], 0 where there is nothing."""
        return (self._nearest >> np.uint64(32)).astype(np.uint32).view(np.float32).reshape(self._shape)

    @property
    def colours(self) -> NDArray[np.uint32]:
        """(height, width) packed colours of the samples: red, green, blue from the lowest byte on."""
        return self._nearest.astype(np.uint32).reshape(self._shape)

    def add_triangles(self, triangles: Triangles) -> None:
        """Draw the triangles that face the camera, row by row, shaded between their corners (Gouraud)."""
        x, y, depth = self._project(triangles.vertices)
        shade = triangles.grey * illumination(triangles.normals)
        faces = triangles.faces[(depth >= NEAR_M)[triangles.faces].all(1)].T
        x, y, nearness, shade = (of_vertex[faces] for of_vertex in (x, y, 1 / depth, shade))  # (3, F)
        dx, dy = np.roll(x, -1, 0) - x, np.roll(y, -1, 0) - y
        twice_area = dx[0] * dy[1] - dy[0] * dx[1]  # negative if the corners run counter-clockwise, as y points down
        top, rows = _whole_numbers(y.min(0), y.max(0), self._shape[0])
        rows[~(twice_area < 0)] = 0
        face = np.repeat(np.arange(len(rows)), rows)
        row = top[face] + _counted(rows)
        # an edge function, slope · column + level, is positive inside
        slope, across, offset = dy, -dx, y * dx - x * dy
        with np.errstate(divide="ignore", invalid="ignore"):
            crossing = -(across[:, face] * row + offset[:, face]) / (edge_slope := slope[:, face])
        first = np.where(edge_slope > 0, crossing, -np.inf).max(0)
        last = np.where(edge_slope < 0, crossing, np.inf).min(0)
        left, columns = _whole_numbers(first - EDGE, last + EDGE, self._shape[1])
        span = np.repeat(np.arange(len(columns)), columns)
        column, face, row = left[span] + _counted(columns), face[span], row[span]
        nearness, shade = (
            _interpolated(values / -twice_area, (slope, across, offset), face, column, row)
            for values in (nearness, shade)
        )
        self._keep_nearest(row, column, nearness, np.stack([shade] * 3, -1))

    def add_balls(self, centres: Floats, colours: Floats, radius: float) -> None:
        """Draw balls exactly: the ray of each sample is intersected with the spheres whose images are near it.

        centres: (B, 3) m in the world; colours: (B, 3) RGB, 0 … 1.
        """
        corners = centres[None] + radius * CUBE[:, None]  # (8, B, 3)
        x, y, depth = (np.reshape(part, corners.shape[:2]) for part in self._project(corners.reshape(-1, 3)))
        ball, row, column = self._samples_in_boxes(np.where(depth >= NEAR_M, x, np.nan), y)
        ray = self._camera.ray((np.stack([column, row], -1) + 0.5) / self._samples)
        centre = (centres - self._camera.T_world_camera[:3, 3])[ball]
        along, square = (ray * centre).sum(-1), (ray * ray).sum(-1)
        discriminant = along**2 - square * ((centre**2).sum(-1) - radius**2)
        hit = np.flatnonzero(discriminant >= 0)
        depth = (along[hit] - np.sqrt(discriminant[hit])) / square[hit]  # a ray has depth 1
        normals = (depth[:, None] * ray[hit] - centre[hit]) / radius
        seen = colours[ball[hit]] * illumination(normals)[:, None]
        self._keep_nearest(row[hit], column[hit], 1 / depth, seen)

    def _project(self, points: Floats) -> tuple[Floats, Floats, Floats]:
        """Samples x, y, whole numbers at their centres, and depths [m]: (N, 3) m -> (N,) each."""
        T_world_camera = self._camera.T_world_camera
        (x, y), _ = self._camera.project(points.T)
        depth = (points - T_world_camera[:3, 3]) @ T_world_camera[:3, 2]
        return self._samples * x - 0.5, self._samples * y - 0.5, depth

    def _samples_in_boxes(self, x: Floats, y: Floats) -> tuple[Ints, Ints, Ints]:
        """Owner, row and column of each sample in the bounding box of each of B shapes of k corners, (k, B)."""
        top, rows = _whole_numbers(y.min(0), y.max(0), self._shape[0])
        left, columns = _whole_numbers(x.min(0), x.max(0), self._shape[1])
        owner = np.repeat(np.arange(len(rows)), rows * columns)
        row, column = np.divmod(_counted(rows * columns), columns[owner])
        return owner, row + top[owner], column + left[owner]

    def _keep_nearest(self, row: Ints, column: Ints, nearness: Floats, colours: Floats) -> None:
        """nearness: (n,) inverse depths [1/m]; colours: (n, 3) 0 … 1."""
        red, green, blue = np.moveaxis((255 * colours + 0.5).astype(np.uint64), -1, 0)
        keys = nearness.astype(np.float32).view(np.uint32).astype(np.uint64) << np.uint64(32)
        keys |= red | green << np.uint64(8) | blue << np.uint64(16)
        np.maximum.at(self._nearest, row * self._shape[1] + column, keys)


def illumination(normals: Floats) -> Floats:
    """Share of a colour that is seen of a surface: (..., 3) unit vectors in the world -> (...)."""
    return AMBIENT + DIFFUSE * np.maximum(normals @ TOWARDS_LIGHT, 0.0)


def _whole_numbers(low: Floats, high: Floats, size: int) -> tuple[Ints, Ints]:
    """First whole number of low … high within 0 … size - 1, and how many there are; none where one is NaN."""
    first = np.ceil(np.fmax(low, 0))
    count = np.floor(np.fmin(high, size - 1)) - first + 1
    count = np.where(np.isnan(low) | np.isnan(high), 0, np.maximum(count, 0))
    return np.where(count > 0, first, 0).astype(int), count.astype(int)


def _counted(counts: Ints) -> Ints:
    """0 … count - 1 of each, one after the other."""
    return np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)


def _interpolated(values: Floats, edges: tuple[Floats, ...], face: Ints, column: Ints, row: Ints) -> Floats:
    """Interpolate values at the corners, (3, F), at n samples of faces: (n,). Each edge is opposite to a corner."""
    slope, across, offset = ((edge * np.roll(values, 1, 0)).sum(0) for edge in edges)
    return slope[face] * column + across[face] * row + offset[face]
