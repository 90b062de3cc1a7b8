"""What stands in a 3-D scene, as JSON and packed meshes for the renderer in app/lab/view/space.js."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from viewimit.simulation import scene_geometry as geometry
from viewimit.simulation.robot import link_meshes
from viewimit.simulation.scene_geometry import Mesh
from viewimit.simulation.world import World

STEPS = 65_535  # of a coordinate over the extent of its mesh
TENTHS_OF_MM = 4  # decimals of m
DIRECTIONS = 400  # for finding the outermost points


class Shapes:
    """Meshes packed into bytes: 16 bits per coordinate, 16 or 32 per index."""

    def __init__(self):
        self._parts: list[bytes] = []
        self._length = 0

    def add(self, vertices: NDArray[np.floating], faces: NDArray[np.integer]) -> dict[str, Any]:
        """Add a mesh, (V, 3) m and (F, 3). → its offsets and how to decode it."""
        low, high = vertices.min(0), vertices.max(0)
        span = np.maximum(high - low, 1e-9)
        steps = np.rint((vertices - low) / span * STEPS).astype("<u2")
        wide = len(vertices) > STEPS
        return {
            "low": _plain(low),
            "step": (span / STEPS).tolist(),
            "vertices": [self._put(steps.tobytes()), len(vertices)],
            "faces": [self._put(np.asarray(faces, "<u4" if wide else "<u2").tobytes()), int(np.size(faces))],
            "wide": wide,
        }

    @property
    def packed(self) -> bytes:
        """All meshes."""
        return b"".join(self._parts)

    def _put(self, data: bytes) -> int:
        start = self._length
        padded = data + b"\0" * (-len(data) % 4)
        self._parts.append(padded)
        self._length += len(padded)
        return start


def describe_robot(robot: str, shapes: Shapes, most_faces: int | None = None) -> dict[str, Any]:
    """Describe what all scenes of a robot share. most_faces: of each link, None for all."""
    links = []
    for link, mesh in sorted(link_meshes(robot).items()):
        shape: Mesh = np.asarray(mesh.vertices, float), np.asarray(mesh.faces)
        if most_faces is not None and len(shape[1]) > most_faces:
            shape = thinned(*shape, most_faces)
        links.append({"link": link, **shapes.add(*shape)})
    direction = {"azimuth": float(geometry.AZIMUTH), "elevation": float(geometry.ELEVATION)}
    return {
        "links": links,
        "looks": {"light": geometry.LOOKS[False]._asdict(), "dark": geometry.LOOKS[True]._asdict()},
        "view": {"fov": float(geometry.FOV), "margin": geometry.MARGIN, **direction},
    }


def describe_stage(world: World, shapes: Shapes, postures: Sequence[NDArray[np.float64]]) -> dict[str, Any]:
    """Describe the static parts of a scene. postures: (m,) rad each, which the first view must show."""
    size = world.scene.size
    placed = lambda solid: {"T": rows_of(np.block([solid.turn, solid.position[:, None]])), "colour": solid.colour}
    named = lambda label: {"text": label.text, "role": label.role, "at": _plain(label.position)}
    return {
        "size": size,
        "solids": [placed(one) | shapes.add(one.vertices, one.faces) for one in geometry.solids(world)],
        "labels": list(map(named, geometry.labels(world))),
        "frusta": [
            {
                "role": role,
                "eye": _plain(camera.T_world_camera[:3, 3]),
                "edges": _plain(geometry.frustum(camera, size)),
                "plate": _plain(geometry.on_plate(camera, geometry.corners(camera), size)),
            }
            for camera, role in zip(geometry.cameras_of(world), geometry.VIEW_ROLES)
        ],
        "points": {arm: across * size for arm, across in geometry.POINT_SIZE.items()},
        "landmarks": _plain(outermost(_landmarks(world, postures))),
    }


def thinned(vertices: NDArray[np.floating], faces: NDArray[np.integer], most_faces: int) -> Mesh:
    """Simplify a mesh: vertices, (V, 3) m, in one cell of a grid become their mean (Rossignac & Borrel 1993)."""
    low, span = vertices.min(0), float(np.ptp(vertices, axis=0).max()) or 1.0
    cells = 256
    while len(faces) > most_faces and cells > 4:
        cells = int(cells * 0.8)
        keys = np.floor((vertices - low) / span * cells).astype(int)
        _, of_cell, count = np.unique(keys, axis=0, return_inverse=True, return_counts=True)
        merged = np.zeros((len(count), 3))
        np.add.at(merged, of_cell.ravel(), vertices)
        vertices, faces = merged / count[:, None], of_cell.ravel()[faces]
        faces = faces[(faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])]
    return vertices, faces


def outermost(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Keep points, (k, 3) m, that are farthest in some direction: a view of these shows all."""
    directions = np.random.default_rng(0).normal(size=(DIRECTIONS, 3))
    return points[np.unique((points @ directions.T).argmax(0))]


def rows_of(T: NDArray[np.float64]) -> list[float]:
    """Return the first three rows of a transform as one list."""
    return np.asarray(T, float)[:3].ravel().round(7).tolist()


def _landmarks(world: World, postures: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    pairs = zip(postures[::2], postures[1::2])
    arms = [geometry.arm_landmarks(world, own, demo) for own, demo in pairs]
    return np.concatenate([geometry.landmarks(world), *arms])


def _plain(values: NDArray[np.float64]) -> list:
    return np.nan_to_num(np.asarray(values, float)).round(TENTHS_OF_MM).tolist()
