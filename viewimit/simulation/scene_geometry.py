"""Geometry of the 3-D scene beside the arms, as plain arrays, and its default view.

It has pedestals, the stereo head, the cameras' frusta with their image plates, the floor, and names.
"""

from collections.abc import Iterator
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..estimation.views import VIEWS
from ..geometry.arrays import Floats
from ..geometry.rigid import look_rotation, rotation_about_axis
from .appearance import extreme_vertices
from .camera import Camera
from .robot import link_meshes
from .world import World

PLATE = 0.17  # m from the camera to its image plate
LABEL_OFFSET = np.array([-0.16, -0.31, 0.05])  # m from a base's foot to its name
LINE, HALF_NAME = 0.1, 0.25  # m: height of a line of text, half the length of a base's name
MAX_STEPS = 8  # in which a name is moved
MIN_LEGS = 0.05  # m: a base whose shape reaches lower under its origin stands on legs; else it is mounted
VIEW_ROLES = ("demonstrator", "demonstrator", "learner", "learner")
CELL = 0.5  # m between lines of the floor
FOV = np.radians(36.0)
MARGIN = 0.93  # of the half angle that the default view fills
BELOW = 0.24  # of the canvas's height, from the bottom: what status and curves cover
AZIMUTH, ELEVATION = np.radians((-134.0, 27.0))  # from behind left: no image plate is seen edge-on
POINT_SIZE = {"learner": 0.021, "demonstrator": 0.027}  # m across: spheres, octahedra
OCTAHEDRON_VERTICES = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=np.float32)
OCTAHEDRON_FACES = np.array(
    [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]], dtype=np.uint32
)

BOX_CORNERS = np.array(list(product((-0.5, 0.5), repeat=3)))
BOX_SIDES = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
BOX_FACES = BOX_SIDES[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)


Mesh = tuple[NDArray[np.floating], NDArray[np.integer]]  # vertices (V, 3) m, faces (F, 3)


class Solid(NamedTuple):
    """A body with a mesh in its own frame."""

    name: str
    colour: str  # a field of `Look`
    vertices: NDArray[np.floating]  # (V, 3) m
    faces: NDArray[np.integer]  # (F, 3)
    position: Floats  # (3,) m, of the frame in the world
    turn: Floats  # (3, 3), of the frame in the world


class Label(NamedTuple):
    """A word in the scene."""

    name: str
    text: str
    role: str  # of the arm whose colour it has
    position: Floats  # (3,) m, of its middle


class Look(NamedTuple):
    """Light intensities and colours, 0 … 255, of a colour scheme."""

    sky: float
    sun: float
    cells: tuple[int, int, int]
    sections: tuple[int, int, int]
    pedestal: tuple[int, int, int]
    metal: tuple[int, int, int]
    lens: tuple[int, int, int]
    plate: tuple[int, int, int]


LOOKS = {
    False: Look(
        3.0, 2.3, (236, 238, 241), (214, 218, 224), (176, 180, 188), (120, 128, 140), (44, 50, 60), (245, 246, 248)
    ),
    True: Look(2.7, 1.7, (34, 35, 37), (52, 54, 58), (86, 89, 95), (112, 118, 128), (30, 33, 38), (58, 60, 64)),
}


def cameras_of(world: World) -> tuple[Camera, ...]:
    """Return the cameras in the order of VIEWS."""
    return (*world.demo_cameras, *world.own_cameras)


def bases_of(world: World) -> dict[str, Floats]:
    """Return T_world_base, (4, 4), by arm."""
    return {"learner": world.T_world_own, "demonstrator": world.T_world_demo}


def solids(world: World) -> Iterator[Solid]:
    """Yield pedestals and the parts of the head."""
    for arm, T_world_base in bases_of(world).items():
        yield _pedestal(world, arm, T_world_base)
    yield from _head(world)


def labels(world: World) -> Iterator[Label]:
    """Yield the names of the arms and of the images."""
    for arm, T_world_base in bases_of(world).items():
        yield Label(f"{arm}_label", arm, arm, name_at(world, T_world_base))
    for view, camera, role in zip(VIEWS, cameras_of(world), VIEW_ROLES):
        plate, eye = on_plate(camera, corners(camera), world.scene.size), camera.T_world_camera[:3, 3]
        corner = plate[0] if view == "l" else plate[1]  # where no other frustum is
        yield Label(f"name_{view}", view, role, corner + 0.25 * (corner - eye))


def floor_lines(world: World, cells: int) -> Floats:
    """Return points along each line of the floor, (n, 2 cells + 1, 3) m, up to `cells` cells from the middle."""
    cell = CELL * world.scene.size
    middle = np.round(landmarks(world)[:, :2].mean(0) / cell) * cell
    across = np.arange(1 - cells, cells)
    along = np.sqrt(cells**2 - across**2)[:, None] * np.linspace(-1, 1, 2 * cells + 1)
    places = np.stack([along, np.broadcast_to(across[:, None], along.shape)], -1)
    plane = middle + cell * np.concatenate([places, places[..., ::-1]])
    return np.concatenate([plane, np.zeros((*plane.shape[:2], 1))], -1)


def frustum(camera: Camera, size: float) -> Floats:
    """Return the edges of a camera's image plate and of its frustum, (8, 2, 3) m. size: the scene's."""
    plate, eye = on_plate(camera, corners(camera), size), camera.T_world_camera[:3, 3]
    return np.array([(plate[i], plate[(i + 1) % 4]) for i in range(4)] + [(eye, corner) for corner in plate])


def landmarks(world: World) -> Floats:
    """Return points that the default view must show, (k, 3) m, without those of the arms."""
    bases = bases_of(world).values()
    feet = [T[:3, 3] * [1, 1, 0] for T in bases]
    head, size = np.array(world.scene.head.position) * [1, 1, 0], world.scene.size
    plates = [on_plate(camera, corners(camera), size) for camera in cameras_of(world)]
    sideways = size * default_view()[:, 0]
    names = [name_at(world, T) + side * sideways for T in bases for side in (-HALF_NAME, HALF_NAME)]
    return np.concatenate([*plates, [head], feet, names])


def arm_landmarks(world: World, theta: Floats, theta_demo: Floats) -> Floats:
    """Return points of the arms that the default view must show, (k, 3) m, also at the ends of their ranges.

    theta, theta_demo: postures, (m,) rad.
    """
    postures = theta, theta_demo, world.scene.lower, world.scene.upper
    outline = {link: extreme_vertices(mesh.vertices) for link, mesh in link_meshes(world.scene.robot).items()}
    points: list[Floats] = []
    for T_world_base in bases_of(world).values():
        for posture in postures:
            T = world.link_frames(posture, T_world_base)
            points += [V @ T[link, :3, :3].T + T[link, :3, 3] for link, V in outline.items()]
    return np.concatenate(points)


def name_at(world: World, T_world_base: Floats) -> Floats:
    """Return a place for an arm's name, (3,) m, where its base does not hide it in the default view."""
    base = link_meshes(world.scene.robot)[0].vertices @ T_world_base[:3, :3].T + T_world_base[:3, 3]
    size = world.scene.size
    return unhidden(T_world_base[:3, 3] * [1, 1, 0] + size * LABEL_OFFSET, base, size)


def unhidden(place: Floats, body: Floats, size: float) -> Floats:
    """Move a place on the floor, (3,) m, towards the default view until a body does not hide a name there.

    body: points, (k, 3) m; size: the scene's.
    """
    right, _, forward = default_view().T
    nearer = -forward * [1, 1, 0]
    shadow = np.linalg.norm(nearer) / -forward[2]  # m on the floor behind a metre of height
    nearer /= np.linalg.norm(nearer)
    for _ in range(MAX_STEPS):
        sideways, along = (body - place) @ right, (body - place) @ nearer
        hides = (np.abs(sideways) < HALF_NAME * size) & (along > 0) & (along - shadow * body[:, 2] < LINE * size)
        if not hides.any():
            break
        place = place + (along[hides].max() + LINE * size / 2) * nearer
    return place


def on_plate(camera: Camera, image: Floats, size: float = 1.0) -> Floats:
    """Project image points, (k, 2) px, on the plate in front of the camera, (k, 3) m. size: the scene's."""
    return camera.T_world_camera[:3, 3] + size * PLATE * camera.ray(image)


def corners(camera: Camera) -> Floats:
    """Return the corners of the image, (4, 2) px, clockwise from the top left."""
    return np.array([[0, 0], [camera.width, 0], [camera.width, camera.height], [0, camera.height]], float)


def _pedestal(world: World, arm: str, T_world_base: Floats) -> Solid:
    size = world.scene.size
    below = float((link_meshes(world.scene.robot)[0].vertices @ T_world_base[2, :3]).min())  # its lowest vertex
    x, y, height = T_world_base[:3, 3] + [0, 0, below if below < -MIN_LEGS * size else 0]
    vertices, faces = pedestal(max(height / size, 0.03))
    return Solid(f"{arm}_pedestal", "pedestal", size * vertices, faces, np.array([x, y, height]), np.eye(3))


def _head(world: World) -> Iterator[Solid]:
    """Yield the head, turned between its two gazes: a stand, a bar of the baseline's length, a camera at each end."""
    centre, size = np.array(world.scene.head.position), world.scene.size
    below = centre - [0, 0, 0.045 * size]
    forward = sum(camera.T_world_camera[:3, 2] for camera in cameras_of(world)) * [1, 1, 0]
    turn = rotation_about_axis([0, 0, 1], np.arctan2(forward[1], forward[0]))
    half = world.scene.head.baseline / 2 / size
    eyes = [(f"camera{side}", centre + size * (turn @ [-0.035, side * half, 0])) for side in (-1, 1)]
    for name, colour, (vertices, faces), place in (
        ("stand", "metal", stand(below[2] / size), below),
        ("bar", "metal", box((0.04, 2 * half + 0.06, 0.025)), below),
        *((name, "lens", box((0.07, 0.09, 0.065)), place) for name, place in eyes),
    ):
        yield Solid(name, colour, size * vertices, faces, place, turn)


# Shapes. All are closed and their faces turn outwards: a renderer then draws one side only, in half the time, and casts
# shadows from behind, so that no shape shadows itself.


def octahedron(size: float) -> Mesh:
    """Return vertices and faces that share no vertices, so that it shades as eight facets. size: m across."""
    vertices = OCTAHEDRON_VERTICES[OCTAHEDRON_FACES].reshape(-1, 3) * (size / 2)
    return vertices, np.arange(24, dtype=np.uint32).reshape(8, 3)


def turned(profile: list[tuple[float, float]], sides: int = 32) -> Mesh:
    """Return a solid of revolution about z with sharp edges. profile: (radius, z) m from the bottom up."""
    angles = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    circle = np.stack([np.cos(angles), np.sin(angles), np.ones(sides)], -1)
    rings = np.repeat(np.array(profile), 2, 0)[1:-1]  # lower and upper edge of each band
    vertices = circle * rings[:, None, [0, 0, 1]]
    i, j = np.arange(sides), (np.arange(sides) + 1) % sides
    band = np.concatenate([np.column_stack([i, j, sides + i]), np.column_stack([j, sides + j, sides + i])])
    faces = 2 * sides * np.arange(len(profile) - 1)[:, None, None] + band
    return vertices.reshape(-1, 3).astype(np.float32), faces.reshape(-1, 3).astype(np.uint32)


def pedestal(height: float) -> Mesh:
    """Return a column on a plate; its top is the origin."""
    return turned([(0, -height), (0.2, -height), (0.2, 0.03 - height), (0.11, 0.03 - height), (0.11, 0.0), (0, 0.0)])


def stand(height: float) -> Mesh:
    """Return a thin post on a plate; its top is the origin."""
    return turned([(0, -height), (0.16, -height), (0.16, 0.02 - height), (0.022, 0.02 - height), (0.022, 0), (0, 0)])


def sheet(corners: Floats) -> Mesh:
    """Return a quadrilateral, (4, 3) m, that is visible from both sides."""
    faces = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32)
    return np.concatenate([corners, corners]).astype(np.float32), np.concatenate([faces, faces[:, ::-1] + 4])


def box(size: tuple[float, float, float]) -> Mesh:
    """Return an axis-aligned box about the origin with flat faces."""
    vertices = (BOX_CORNERS[BOX_FACES].reshape(-1, 3) * size).astype(np.float32)
    return vertices, np.arange(len(vertices), dtype=np.uint32).reshape(-1, 3)


# The default view


def default_view() -> Floats:
    """Return R_world_camera, (3, 3), of the default view: right, down, forward in columns."""
    level = np.cos(ELEVATION)
    return look_rotation([-level * np.cos(AZIMUTH), -level * np.sin(AZIMUTH), -np.sin(ELEVATION)])


def fit_view(points: Floats, aspect: float, below: float) -> tuple[Floats, Floats]:
    """Return position and target, m, of a camera with the default direction and FOV that just shows points, (k, 3) m.

    below: share of the height that stays free at the bottom. Each side of the frame is a plane through the
    eye, with a slope per depth; along its normal the points give one bound, and opposite bounds meet at the eye.
    """
    right, down, forward = default_view().T
    up, backward = -down, -forward
    tan = np.tan(FOV / 2)
    x, y, z = points @ right, points @ up, points @ backward
    low_slopes = tan * aspect * MARGIN, tan * (1 - 2 * below) * MARGIN
    high_slopes = tan * aspect * MARGIN, tan * MARGIN
    bounds = []
    for along, low_slope, high_slope in zip((x, y), low_slopes, high_slopes):
        bounds.append((np.max(along + high_slope * z), high_slope, np.min(along - low_slope * z), low_slope))
    distance = max((high - low) / (high_slope + low_slope) for high, high_slope, low, low_slope in bounds)
    # where the other direction decides the distance, centre in the room that is left
    across, upwards = (
        (high - high_slope * distance + low + low_slope * distance) / 2 for high, high_slope, low, low_slope in bounds
    )
    position = across * right + upwards * up + distance * backward
    depth = distance - np.mean(z)
    return position, position - depth * backward
