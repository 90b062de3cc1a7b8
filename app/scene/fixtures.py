"""The fixtures of the 3-D scene: light, floor, pedestals, the head, its frusta with their image plates, names."""

from collections.abc import Mapping

import numpy as np
from viser import ClientHandle, ImageHandle, MeshHandle, SceneApi

from viewimit.drawing.theme import rgb
from viewimit.estimation.views import VIEWS
from viewimit.simulation import scene_geometry as geometry
from viewimit.simulation.camera import Camera
from viewimit.simulation.world import World

from .. import viser_private
from .nodes import NO_SHADOWS, Nodes, add_text, in_px, linear, quaternion

BEHIND = 0.002  # m, a picture's distance from its plate
CELLS, PIECE = 10, 5  # of the floor on either side, and points of its lines from one to the next that are drawn
PAPER = {False: np.full(3, 255.0), True: np.full(3, 20.0)}  # what viser draws the scene on


def add_light(scene: SceneApi, look: geometry.Look, shadows: bool = False) -> None:
    """A page's own shadows that of the server, which is there before anything is to be lit: else all is drawn once
    without it. shadows: whether the sun casts any, which takes twice as long where software renders."""
    scene.add_light_hemisphere(
        "/light/sky", sky_color=(245, 244, 255), ground_color=(178, 177, 187), intensity=look.sky, position=(0, 0, 1)
    )
    scene.add_light_directional("/light/sun", intensity=look.sun, cast_shadow=shadows, position=(-2.0, -3.0, 5.0))


def add_floor(scene: SceneApi, world: World, dark: bool, shadows: bool) -> None:
    """Lines that fade into the page, and what shadows fall on: viser's grid, which works out every pixel of the floor,
    a quarter of a frame with shadows where a browser renders in software."""
    lines, size = geometry.floor_lines(world, CELLS), world.scene.size
    distance = np.linalg.norm(lines - lines.mean((0, 1)), axis=-1, keepdims=True) / (CELLS * geometry.CELL * size)
    strength = np.clip(1 - distance**2, 0, 1)
    colours = strength * geometry.LOOKS[dark].sections + (1 - strength) * PAPER[dark]
    pieces = lambda of: np.stack([of[:, :-1:PIECE], of[:, PIECE::PIECE]], -2).reshape(-1, 2, 3)
    scene.add_line_segments("/floor", pieces(lines).astype(np.float32), linear(pieces(colours)), **in_px(1.0))
    scene.add_grid(  # without lines: what shadows fall on
        "/floor/shadows", 12 * size, 12 * size, visible=shadows, shadow_opacity=0.10,
        cell_thickness=0.0, section_thickness=0.0, fade_distance=9.0 * size,
    )  # fmt: skip


class Fixtures:
    """What stands still in one page, in the colours of one scheme."""

    def __init__(self, client: ClientHandle, nodes: Nodes, world: World, dark: bool):
        self._client, self._nodes, self._world = client, nodes, world
        self._dark, self._look, self._size = dark, geometry.LOOKS[dark], world.scene.size
        self._plates: dict[str, MeshHandle] = {}
        self._pictures: dict[str, ImageHandle] = {}  # on the plates
        self._shown: dict[str, bytes | None] = {}  # what they show
        for solid in geometry.solids(world):
            add, colour, turn = client.scene.add_mesh_simple, getattr(self._look, solid.colour), quaternion(solid.turn)
            name, place = f"/stage/{solid.name}", solid.position
            nodes.keep(add(name, solid.vertices, solid.faces, color=colour, position=place, wxyz=turn))
        for label in geometry.labels(world):
            node, line = f"/stage/{label.name}", geometry.LINE * self._size
            nodes.keep(add_text(client.scene, node, label.text, label.role, dark, label.position, line))
        for name, camera, role in zip(VIEWS, geometry.cameras_of(world), geometry.VIEW_ROLES):
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

    def _add_frustum(self, name: str, camera: Camera, role: str) -> None:
        sheet = geometry.sheet(geometry.on_plate(camera, geometry.corners(camera), self._size))
        lines = geometry.frustum(camera, self._size).astype(np.float32)
        scene, keep = self._client.scene, self._nodes.keep
        keep(scene.add_line_segments(f"/stage/frustum_{name}", lines, rgb(role, self._dark), **in_px(1.6)))
        node = scene.add_mesh_simple(f"/stage/plate_{name}", *sheet, color=self._look.plate, opacity=0.55, **NO_SHADOWS)
        self._plates[name] = keep(node)

    def _add_picture(self, view: str, camera: Camera) -> None:
        """As large as the plate and just behind it, so that drawings on the plate stay in sight; hidden."""
        T, scale = camera.T_world_camera, self._size * geometry.PLATE / np.array(camera.lens.focal)
        plate = geometry.on_plate(camera, geometry.corners(camera), self._size)
        middle = plate.mean(0) + self._size * BEHIND * T[:3, 2]
        picture = self._client.scene.add_image(
            f"/stage/picture_{view}", np.zeros((1, 1, 3), np.uint8), camera.width * scale[0], camera.height * scale[1],
            format="jpeg", wxyz=quaternion(T[:3, :3]), position=middle, visible=False, **NO_SHADOWS,
        )  # fmt: skip
        self._pictures[view] = self._nodes.keep(picture)
