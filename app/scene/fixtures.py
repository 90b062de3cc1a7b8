"""The furniture of the 3-D scene: light, floor, pedestals, the head, its frusta with their image plates, names."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from viser import ClientHandle, ImageHandle, MeshHandle, SceneApi

from viewimit.drawing.theme import rgb
from viewimit.geometry.rigid import rotation_about_axis
from viewimit.simulation.camera import Camera
from viewimit.simulation.link_meshes import link_meshes
from viewimit.simulation.world import World
from viewimit.views import VIEWS

from .. import viser_private
from . import meshes
from .lettering import add_text
from .nodes import Nodes
from .rotations import quaternion
from .view import looking

PLATE = 0.17  # m from the camera to its image plate
BEHIND = 0.002  # m, a picture's distance from its plate
LABEL_OFFSET = np.array([-0.16, -0.31, 0.05])  # m from a base's foot to its name
LINE, HALF_NAME = 0.1, 0.25  # m: the height of a line of text, half the length of a base's name
SUNK = 0.05  # m, of a base's shape under its origin: less is how it is mounted
VIEW_ROLES = ("demonstrator", "demonstrator", "learner", "learner")


@dataclass(frozen=True)
class Look:
    """What of the 3-D scene differs between light and dark: intensities, and colours 0 … 255."""

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


def add_light(scene: SceneApi, look: Look) -> None:
    """A page's own shadows that of the server, which is there before anything is to be lit: else all is drawn once
    without it, by programs of its own."""
    scene.add_light_hemisphere(
        "/light/sky", sky_color=(245, 244, 255), ground_color=(178, 177, 187), intensity=look.sky, position=(0, 0, 1)
    )
    scene.add_light_directional("/light/sun", intensity=look.sun, cast_shadow=True, position=(-2.0, -3.0, 5.0))


def add_floor(scene: SceneApi, look: Look, size: float = 1.0) -> None:
    """size: of the scene, as of all that stands in it."""
    scene.add_grid(
        "/floor",
        width=12 * size,
        height=12 * size,
        cell_size=0.25 * size,
        section_size=1.0 * size,
        cell_color=look.cells,
        section_color=look.sections,
        shadow_opacity=0.10,
        fade_distance=9.0 * size,
    )


class Fixtures:
    """What stands still in one page, in the colours of one scheme."""

    def __init__(self, client: ClientHandle, nodes: Nodes, world: World, dark: bool):
        self._client, self._nodes, self._world = client, nodes, world
        self._dark, self._look, self._size = dark, LOOKS[dark], world.scene.size
        self._plates: dict[str, MeshHandle] = {}
        self._pictures: dict[str, ImageHandle] = {}  # on the plates
        self._shown: dict[str, bytes | None] = {}  # what they show
        self._cameras = (*world.demo_cameras, *world.own_cameras)
        self._add_pedestal("learner", world.T_world_own)
        self._add_pedestal("demonstrator", world.T_world_demo)
        self._add_head()
        for name, camera, role in zip(VIEWS, self._cameras, VIEW_ROLES):
            self._add_frustum(name, camera, role)
            self._add_picture(name, camera)

    def show_pictures(self, pictures: Mapping[str, bytes]) -> None:
        """JPEGs by view on the image plates; only those that are new are sent."""
        for view in VIEWS:
            picture = pictures.get(view)
            if picture is not self._shown.get(view):
                self._shown[view] = picture
                self._plates[view].visible = picture is None
                self._pictures[view].visible = picture is not None
                if picture is not None:
                    viser_private.push_jpeg(self._pictures[view], picture)

    def landmarks(self) -> NDArray:
        """(k, 3) m: what the default view must hold of it."""
        feet = [T[:3, 3] * [1, 1, 0] for T in (self._world.T_world_own, self._world.T_world_demo)]
        head = np.array(self._world.scene.head.position) * [1, 1, 0]
        plates = [on_plate(camera, corners(camera), self._size) for camera in self._cameras]
        aside = self._size * looking()[:, 0]
        names = [foot + self._size * LABEL_OFFSET + side * aside for foot in feet for side in (-HALF_NAME, HALF_NAME)]
        return np.concatenate([*plates, [head], feet, names])

    def _add_pedestal(self, arm: str, T_world_base: NDArray) -> None:
        x, y, height = T_world_base[:3, 3] + [0, 0, self._below(arm)]
        size = self._size
        vertices, faces = meshes.pedestal(max(height / size, 0.03))
        scene = self._client.scene
        self._nodes.keep(
            scene.add_mesh_simple(
                f"/stage/{arm}_pedestal",
                size * vertices,
                faces,
                color=self._look.pedestal,
                position=(x, y, height),
            )
        )
        self._add_text(f"/stage/{arm}_label", arm, arm, (x, y, 0) + size * LABEL_OFFSET)

    def _below(self, arm: str) -> float:
        """m from a base's origin down to the lowest of what is drawn of it, as of a body that stands on legs; what is
        drawn of a base that is mounted begins there."""
        shape = link_meshes(self._world.scene.robot)[0]
        down = self._world.T_world_own[2, :3] if arm == "learner" else self._world.T_world_demo[2, :3]
        lowest = float((shape.vertices @ down).min())
        return lowest if lowest < -SUNK * self._size else 0.0

    def _add_head(self) -> None:
        """The head between its two gazes: a stand, a bar of the baseline's length, a camera at each end."""
        centre = np.array(self._world.scene.head.position)
        size = self._size
        below = centre - [0, 0, 0.045 * size]
        scene = self._client.scene
        forward = sum(camera.T_world_camera[:3, 2] for camera in self._cameras) * [1, 1, 0]
        turn = rotation_about_axis([0, 0, 1], np.arctan2(forward[1], forward[0]))
        half = self._world.scene.head.baseline / 2 / size
        parts = [("stand", meshes.stand(below[2] / size), below)]
        parts.append(("bar", meshes.box((0.04, 2 * half + 0.06, 0.025)), below))
        for side in (-1, 1):
            place = centre + size * (turn @ [-0.035, side * half, 0])
            parts.append((f"camera{side}", meshes.box((0.07, 0.09, 0.065)), place))
        for name, (vertices, faces), position in parts:
            self._nodes.keep(
                scene.add_mesh_simple(
                    f"/stage/{name}",
                    size * vertices,
                    faces,
                    color=self._look.lens if name.startswith("camera") else self._look.metal,
                    position=position,
                    wxyz=quaternion(turn),
                )
            )

    def _add_frustum(self, name: str, camera: Camera, role: str) -> None:
        plate = on_plate(camera, corners(camera), self._size)
        eye = camera.T_world_camera[:3, 3]
        edges = [(plate[i], plate[(i + 1) % 4]) for i in range(4)] + [(eye, corner) for corner in plate]
        scene = self._client.scene
        self._nodes.keep(
            scene.add_line_segments(
                f"/stage/frustum_{name}",
                np.array(edges, np.float32),
                rgb(role, self._dark),
                thickness=1.6,
                thickness_units="screen",
            )
        )
        self._plates[name] = scene.add_mesh_simple(
            f"/stage/plate_{name}",
            *meshes.sheet(plate),
            color=self._look.plate,
            opacity=0.55,
            cast_shadow=False,
            receive_shadow=False,
        )
        self._nodes.keep(self._plates[name])
        corner = plate[0] if name == "l" else plate[1]  # where no other frustum is
        self._add_text(f"/stage/name_{name}", name, role, corner + 0.25 * (corner - eye))

    def _add_text(self, node: str, text: str, role: str, position: NDArray) -> None:
        self._nodes.keep(add_text(self._client.scene, node, text, role, self._dark, position, LINE * self._size))

    def _add_picture(self, view: str, camera: Camera) -> None:
        """As large as the plate and just behind it, so that what is drawn on the plate stays in sight; hidden."""
        T, scale = camera.T_world_camera, self._size * PLATE / np.array(camera.lens.focal)
        self._pictures[view] = self._client.scene.add_image(
            f"/stage/picture_{view}",
            np.zeros((1, 1, 3), np.uint8),
            camera.width * scale[0],
            camera.height * scale[1],
            format="jpeg",
            cast_shadow=False,
            receive_shadow=False,
            wxyz=quaternion(T[:3, :3]),
            position=on_plate(camera, corners(camera), self._size).mean(0) + self._size * BEHIND * T[:3, 2],
            visible=False,
        )
        self._nodes.keep(self._pictures[view])


def on_plate(camera: Camera, image: NDArray, size: float = 1.0) -> NDArray:
    """image: (k, 2) px → (k, 3) m on the plate in front of the camera, where their rays meet it. size: the scene's."""
    return camera.T_world_camera[:3, 3] + size * PLATE * camera.ray(image)


def corners(camera: Camera) -> NDArray:
    """(4, 2) px, clockwise from the top left."""
    return np.array([[0, 0], [camera.width, 0], [camera.width, camera.height], [0, camera.height]], float)
