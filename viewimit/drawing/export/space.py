"""The 3-D scene of a session as numbers that a small renderer in a browser draws: shapes once, a pose a moment."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...loop.session import Session
from ...loop.snapshot import Snapshot
from ...simulation import scene_geometry as geometry
from ...simulation.camera import triangulate
from ...simulation.robot import link_meshes
from ...simulation.world import World

STEPS = 65_535  # of a coordinate between the ends of its mesh
TENTHS_OF_MM, MICRORAD = 4, 6  # digits of m and of rad that are kept


class Shapes:
    """Meshes in one array of bytes: 16 bits a coordinate, 16 or 32 an index."""

    def __init__(self):
        self._parts: list[bytes] = []
        self._length = 0

    def add(self, vertices: NDArray, faces: NDArray) -> dict[str, Any]:
        """(V, 3) m, (F, 3) → where they are, and how to read them."""
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
        return b"".join(self._parts)

    def _put(self, data: bytes) -> int:
        start = self._length
        padded = data + b"\0" * (-len(data) % 4)
        self._parts.append(padded)
        self._length += len(padded)
        return start


def describe_space(session: Session, motions: Sequence[int]) -> tuple[dict[str, Any], bytes]:
    """What stands still and what is seen at each of these motions, and the bytes of its meshes."""
    world, shapes, history = session.world, Shapes(), session.history
    size = world.scene.size
    moments = [history[k] for k in motions]
    cameras = geometry.cameras_of(world)
    standing: dict[str, Any] = {
        "size": size,
        "joints": [{"T": _columns(joint.T_parent_joint), "axis": _unit(joint.axis)} for joint in world.robot.joints],
        "links": [
            {"link": link, **shapes.add(np.asarray(mesh.vertices), np.asarray(mesh.faces))}
            for link, mesh in sorted(link_meshes(world.scene.robot).items())
        ],
        "bases": {arm: _columns(T) for arm, T in geometry.bases_of(world).items()},
        "solids": [
            {
                "colour": solid.colour,
                "T": _columns(np.block([[solid.turn, solid.position[:, None]], [np.zeros((1, 3)), np.ones((1, 1))]])),
                **shapes.add(solid.vertices, solid.faces),
            }
            for solid in geometry.solids(world)
        ],
        "labels": [
            {"text": label.text, "role": label.role, "at": _plain(label.position)} for label in geometry.labels(world)
        ],
        "frusta": [
            {
                "role": role,
                "eye": _plain(camera.T_world_camera[:3, 3]),
                "edges": _plain(geometry.frustum(camera, size)),
                "plate": _plain(geometry.on_plate(camera, geometry.corners(camera), size)),
            }
            for camera, role in zip(cameras, geometry.VIEW_ROLES)
        ],
        "points": {"link": world.body.link.tolist(), "local": _plain(world.body.local), **geometry.POINT_SIZE},
        "looks": {"light": geometry.LOOKS[False]._asdict(), "dark": geometry.LOOKS[True]._asdict()},
        "view": {"fov": float(geometry.FOV), "margin": geometry.MARGIN, **_direction()},
        "landmarks": _plain(_landmarks(world, moments)),
    }
    standing["moments"] = [_at(world, moment) for moment in moments]
    return standing, shapes.packed


def _landmarks(world: World, moments: Sequence[Snapshot]) -> NDArray:
    first, last = moments[0], moments[-1]
    arms = [geometry.arm_landmarks(world, each.theta, each.theta_demo) for each in (first, last)]
    return np.concatenate([geometry.landmarks(world), *arms])


def _at(world: World, moment: Snapshot) -> dict[str, Any]:
    """What moves, at one moment. Points that are not seen, or not recovered, are null."""
    views, size = moment.views, world.scene.size
    images = np.concatenate([views.demo, views.own], -1).reshape(-1, 4, 2).swapaxes(0, 1)
    plates = [geometry.on_plate(camera, image, size) for camera, image in zip(geometry.cameras_of(world), images)]
    recovered = triangulate(*world.own_cameras, moment.recovered)
    return {
        "learner": _angles(world, moment.theta),
        "demonstrator": _angles(world, moment.theta_demo),
        "plates": [_where(plate, seen) for plate, seen in zip(plates, views.visible.T)],
        "recovered": _where(recovered, moment.usable & np.isfinite(recovered).all(-1)),
    }


def _where(points: NDArray, seen: NDArray) -> list:
    return [point if one else None for point, one in zip(_plain(points), seen.tolist())]


def _angles(world: World, theta: NDArray) -> list[float]:
    return np.array(world.joint_angles(theta), float).round(MICRORAD).tolist()


def _plain(values: NDArray) -> list:
    return np.nan_to_num(np.asarray(values, float)).round(TENTHS_OF_MM).tolist()


def _unit(axis: NDArray) -> list[float]:
    return (axis / np.linalg.norm(axis)).tolist()


def _columns(T: NDArray) -> list[float]:
    """(4, 4), column by column, as WebGL has it."""
    return np.asarray(T, float).T.ravel().round(7).tolist()


def _direction() -> dict[str, float]:
    return {"azimuth": float(geometry.AZIMUTH), "elevation": float(geometry.ELEVATION)}
