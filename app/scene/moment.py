"""What in the 3-D scene shows a moment: points on the image plates, rays, residuals, recovered and chosen points."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from viser import ClientHandle, SceneApi, SceneNodeHandle

from viewimit.drawing.theme import faint, rgb
from viewimit.loop.snapshot import Snapshot
from viewimit.simulation.camera import Camera
from viewimit.simulation.robot import BodyPoints
from viewimit.simulation.scene_geometry import VIEW_ROLES, octahedron, on_plate
from viewimit.simulation.world import World

from ..model.choices import View
from ..model.displayed import Displayed
from ..viser_private import push_array
from .arms import ALWAYS_SEEN, link_name
from .nodes import Nodes, in_px, linear

Colours = NDArray | tuple[int, int, int]  # (n, 2, 3) of each end, or one for all
FAR_AWAY = np.array([0, 0, -50.0])  # m, where nobody looks


class Moment:
    """Of one page in one world, in the colours of one scheme; nothing of it is seen before the first `draw`."""

    def __init__(self, client: ClientHandle, nodes: Nodes, world: World, dark: bool):
        self._cameras = (*world.demo_cameras, *world.own_cameras)
        self._size = world.scene.size
        self._demo: tuple[NDArray, list[NDArray]] | None = None  # its points and where they are on the plates
        self._shown: dict[str, bool] = {}
        self._moved: dict[str, list[float]] = {}  # by node: where it is, m
        self._add_nodes(client.scene, nodes, len(world.body), dark)

    def _add_nodes(self, scene: SceneApi, nodes: Nodes, count: int, dark: bool) -> None:
        """Add lines, points and shapes for `count` body points, out of sight."""
        colour, size = partial(rgb, dark=dark), self._size
        add_lines = partial(_add_lines, scene, nodes)
        self._rays = add_lines("rays", 4 * count, of_views(partial(faint, dark=dark), count), 1)
        self._chosen_rays = add_lines("chosen_rays", 4, of_views(colour, 1), 1.6)
        self._residuals = add_lines("residuals", 1, colour("residual"), 3)
        dots, colours = np.zeros((4 * count, 3)), np.repeat([colour(role) for role in VIEW_ROLES], count, axis=0)
        add_dots = partial(scene.add_point_cloud, point_shape="circle", point_shading="flat", precision="float32")
        self._dots = nodes.keep(add_dots("/now/dots", dots, colours, point_size=0.009 * size))
        placed = np.tile([1.0, 0, 0, 0], (count, 1)), np.zeros((count, 3))
        diamonds = scene.add_batched_meshes_simple(
            "/now/recovered", *octahedron(0.02 * size), *placed,
            batched_colors=linear(colour("recovered")), cast_shadow=False, lod="off",
        )  # fmt: skip
        self._recovered = nodes.keep(diamonds)
        ring = partial(scene.add_icosphere, radius=0.017 * size, color=colour("chosen"), cast_shadow=False)
        self._rings = [nodes.keep(ring(f"/now/chosen_{arm}", visible=False)) for arm in ALWAYS_SEEN]

    def draw(self, displayed: Displayed, own: NDArray, demo: NDArray) -> None:
        """own, demo: (N, 3) m, the points on both arms."""
        on_plates, seen = self.on_plates(displayed.scene_snapshot)
        self._draw_rays(on_plates, seen, demo, own, displayed.view)
        self._draw_residuals(displayed, own)
        self._draw_chosen(own, demo, displayed.view.chosen)

    def on_plates(self, snapshot: Snapshot) -> tuple[NDArray, NDArray]:
        """All points as each camera sees them: (4, N, 3) m on its plate, and (4, N) whether it does."""
        views = snapshot.views
        if self._demo is None or self._demo[0] is not views.demo:  # the demonstrator mostly rests
            self._demo = views.demo, self._pair_on_plates(views.demo, self._cameras[:2])
        plates = self._demo[1] + self._pair_on_plates(views.own, self._cameras[2:])
        return np.array(plates), views.visible.T

    def _pair_on_plates(self, points: NDArray, pair: tuple[Camera, ...]) -> list[NDArray]:
        """points: (N, 4) px in the left and the right camera → (N, 3) m each."""
        images = points.reshape(-1, 2, 2).swapaxes(0, 1)
        return [on_plate(camera, image, self._size) for camera, image in zip(pair, images)]

    def _draw_rays(self, plates: NDArray, seen: NDArray, demo: NDArray, own: NDArray, view: View) -> None:
        chosen, targets = view.chosen, np.stack([demo, demo, own, own])
        push_array(self._dots, "points", np.where(seen[..., None], plates, FAR_AWAY).reshape(-1, 3))
        self._show(self._rays, view.rays)
        if view.rays:
            push_array(self._rays, "points", segments(plates, targets, seen))
        in_sight = chosen is not None and bool(seen[:, chosen].any())
        self._show(self._chosen_rays, in_sight)
        if in_sight:
            eyes = np.array([camera.T_world_camera[:3, 3] for camera in self._cameras])
            push_array(self._chosen_rays, "points", segments(eyes, targets[:, chosen], seen[:, chosen]))

    def _draw_residuals(self, displayed: Displayed, own: NDArray) -> None:
        view, usable = displayed.view, displayed.scene_snapshot.usable
        shown = view.residuals and view.truth and displayed.scene_snapshot.transfer is not None and bool(usable.any())
        for node in (self._residuals, self._recovered):
            self._show(node, shown)
        if shown:
            positions = displayed.recovered_world
            if not usable.all():
                positions, own = np.where(usable[:, None], positions, -50.0), own[usable]
            push_array(self._recovered, "batched_positions", positions)
            push_array(self._residuals, "points", np.stack([positions[usable], own], axis=-2))

    def _draw_chosen(self, own: NDArray, demo: NDArray, chosen: int | None) -> None:
        for ring, points in zip(self._rings, (own, demo)):
            self._show(ring, chosen is not None)
            if chosen is not None:
                self._move(ring, points[chosen].tolist())

    def _move(self, node, position: list[float]) -> None:
        """To (3,) m."""
        if self._moved.get(node.name) != position:
            self._moved[node.name] = position
            node.position = position[0], position[1], position[2]

    def _show(self, node, visible: bool) -> None:
        """Or hide it. viser's setter looks up types, which takes longer than most drawings."""
        if self._shown.get(node.name) != visible:
            self._shown[node.name] = node.visible = visible


def _add_lines(scene: SceneApi, nodes: Nodes, name: str, count: int, colours: Colours, thickness: float) -> Any:
    """Add `count` line segments of a thickness in px."""
    points = np.zeros((count, 2, 3), np.float32)
    return nodes.keep(scene.add_line_segments(f"/now/{name}", points, colours, **in_px(thickness)))


def of_views(shade: Callable[[str], tuple[int, int, int]], count: int) -> NDArray:
    """(4 count, 2, 3): colours of `count` segments from each view."""
    return np.repeat([linear(shade(role)) for role in VIEW_ROLES], 2 * count, axis=0).reshape(-1, 2, 3)


def segments(starts: NDArray, ends: NDArray, seen: NDArray) -> NDArray:
    """(…, 3) m twice → (n, 2, 3), those that are not seen out of sight."""
    return np.where(seen[..., None, None], np.stack([starts, ends], axis=-2), FAR_AWAY).reshape(-1, 2, 3)


RADIUS, SIDES = 0.024, 24  # m, in a scene of size 1; of a circle


class ProposedPoint:
    """Of one page in one world; dark on the arms, which are pale in every scheme."""

    def __init__(self, client: ClientHandle, nodes: Nodes, world: World):
        self._client, self._keep, self._world, self._colour = client, nodes.keep, world, rgb("ink")
        self._point: BodyPoints | None = None
        self._shown: list[SceneNodeHandle] = []

    def show(self, point: BodyPoints | None) -> None:
        """A single one, or none."""
        if point is self._point:
            return
        self._point = point
        for node in self._shown:
            node.visible = False
        self._shown = [] if point is None else [self._added(arm, point) for arm in ALWAYS_SEEN]

    def _added(self, arm: str, point: BodyPoints) -> SceneNodeHandle:
        scene = self._world.scene
        node, add = f"{link_name(scene, arm, int(point.link[0]))}/proposed", self._client.scene.add_line_segments
        lines = _circles(RADIUS * scene.size)
        return self._keep(add(node, lines, self._colour, position=point.local[0], **in_px(2)))


def _circles(radius: float) -> NDArray:
    """(3 SIDES, 2, 3) m: three great circles of a sphere, which so is hollow."""
    angles = 2 * np.pi * np.arange(SIDES + 1) / SIDES
    circle = radius * np.stack([np.cos(angles), np.sin(angles), np.zeros(SIDES + 1)], -1)
    sides = np.stack([circle[:-1], circle[1:]], 1)
    return np.concatenate([np.roll(sides, axis, -1) for axis in range(3)]).astype(np.float32)
