"""The 3-D scene of one page: arms, head, frusta, body points, residuals, rays. Truth, for the viewer only."""

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray
from viser import ClientHandle, SceneClickEvent, ViserServer

from viewimit.drawing.theme import faint, rgb
from viewimit.simulation.world import World
from viewimit.snapshot import Snapshot

from ..control.commands.display import ChoosePoint
from ..control.queue import CommandQueue
from ..control.state import PageState, View
from ..viser_private import push_array
from . import meshes
from .arms import Arms, link_name, share_meshes
from .fixtures import LOOKS, VIEW_ROLES, Fixtures, add_light_and_floor, plate_map
from .hand_gizmo import HandGizmo
from .nodes import Nodes
from .picking import picked
from .view import FOV, fitted_view

BELOW = 0.22  # of the canvas's height, from the bottom: what status and curves cover
SAME_SHAPE = 0.01  # of an aspect: viser draws with fewer pixels when it is slow, and rounds their number
UNTOUCHED = 0.01  # m that a camera may be off the fitted view and still count as there
FAR_AWAY = np.array([0, 0, -50.0])  # m, where nobody looks
POINT_SIZE = {"learner": 0.021, "demonstrator": 0.027}


def share_scene(server: ViserServer) -> None:
    """What all pages share: link meshes, floor, light."""
    server.scene.configure_default_lights(enabled=False)
    add_light_and_floor(server.scene, LOOKS[False])
    for arm in ("learner", "demonstrator"):
        share_meshes(server, arm)


class Scene3D:
    """`build` for a world, then `arms.draw` and `show` as often as wanted; `build` again for another world.

    share_opponent(): puts its meshes on the server's scene, before they are first shown.
    """

    def __init__(self, client: ClientHandle, queue: CommandQueue, share_opponent: Callable[[], None]):
        self._client, self._queue = client, queue
        self._share_opponent = share_opponent
        self._arms: Arms | None = None  # before the first world
        self._nodes = Nodes()
        self._fixtures: Fixtures | None = None  # before the first world
        self._gizmo = HandGizmo(client, queue)
        self._dark, self._fits = False, 0
        self._aspect: float | None = None  # of the canvas that was fitted last
        self._found = self._fitted = np.array(client.camera.position)
        self._points = np.zeros((0, 3))  # m, the learner's and the demonstrator's as they are drawn

        @client.scene.on_click()  # type: ignore[arg-type]  # which takes coroutines too
        async def _(event: SceneClickEvent) -> None:
            self._choose_at(np.array(event.ray_origin), np.array(event.ray_direction))

    def build(self, world: World) -> None:
        """Set up the scene of a world, in place of the one before."""
        self._nodes.begin()
        self._world = world
        self._arms = Arms(self._client, self._nodes, world, self._share_opponent)
        self._bases = {"learner": world.T_world_own, "demonstrator": world.T_world_demo}
        self._cameras = (*world.demo_cameras, *world.own_cameras)
        self._plate_A, self._plate_b = map(np.array, zip(*map(plate_map, self._cameras)))
        self._demo_points: tuple[NDArray, NDArray] | None = None  # a posture and its points
        self._furnish()
        self._nodes.end()

    def _furnish(self) -> None:
        """All but the arms, in the colours of the scheme, in place of what there is."""
        self._shown: dict[str, bool] = {}
        self._fixtures = Fixtures(self._client, self._nodes, self._world, self._dark)
        for name in self._bases:
            for i in range(len(self._world.body)):
                self._add_point(name, i)
        self._add_moving_parts()

    def depends_on(self, state: PageState) -> tuple:
        """What `show` shows; of snapshots their identity counts."""
        posed = state.present.theta_demo.tobytes(), self._gizmo.drops, self._canvas_aspect()
        return state.generation, state.shown, state.view, *posed, *state.pictures.values()

    def show(self, state: PageState) -> None:
        """All but the poses of the arms. A canvas of another shape, as when panels dock, is fitted anew."""
        view, aspect = state.view, self._canvas_aspect()
        if view.on("dark") != self._dark:
            self._dark = view.on("dark")
            add_light_and_floor(self._client.scene, LOOKS[self._dark])
            self._furnish()
        if aspect is not None and (self._aspect is None or abs(np.log(aspect / self._aspect)) > SAME_SHAPE):
            self._aspect = aspect
            self._fit_untouched_view()
        if view.fits != self._fits:
            self._fits = view.fits
            self._fit_view()
        self._draw(state)
        self._standing.show_pictures(state.pictures)
        self._gizmo.show(view.gizmo, self._world, state.present.theta_demo)

    def _draw(self, state: PageState) -> None:
        """Points on the plates, rays and residuals."""
        snapshot, view = state.shown, state.view
        own = self._world.points_world(snapshot.theta, self._bases["learner"])
        if self._demo_points is None or self._demo_points[0] is not snapshot.theta_demo:  # it mostly rests
            points = self._world.points_world(snapshot.theta_demo, self._bases["demonstrator"])
            self._demo_points = snapshot.theta_demo, points
        demo = self._demo_points[1]
        self._points = np.concatenate([own, demo])
        on_plates, seen = self._on_plates(snapshot)
        self._draw_rays(on_plates, seen, demo, own, view)
        self._draw_residuals(state, own)
        self._draw_chosen(own, demo, view.chosen)

    def _fit_view(self) -> None:
        """The default camera, as near as the canvas allows."""
        camera = self._client.camera
        position, target = fitted_view(self._landmarks(), self._canvas_aspect() or 1.0, BELOW)
        camera.fov = float(FOV)
        camera.position, camera.look_at = position, target
        self._fitted = position

    def _fit_untouched_view(self) -> None:
        """Fit again, unless the visitor has moved the camera from where the page put it or found it."""
        here = self._client.camera.position
        if min(np.linalg.norm(here - place) for place in (self._found, self._fitted)) < UNTOUCHED:
            self._fit_view()

    @property
    def arms(self) -> Arms:
        """Of the world that was built."""
        assert self._arms is not None
        return self._arms

    @property
    def _standing(self) -> Fixtures:
        """The fixtures of the world that was built."""
        assert self._fixtures is not None
        return self._fixtures

    def _canvas_aspect(self) -> float | None:
        """Width by height; None while the canvas has no size."""
        camera = self._client.camera
        return camera.image_width / camera.image_height if min(camera.image_width, camera.image_height) > 0 else None

    def _landmarks(self) -> NDArray:
        """(k, 3) m: what the default view must hold."""
        points = [self._standing.landmarks()]
        for T_world_base in self._bases.values():
            for theta in (self._world.scene.lower, self._world.scene.upper, np.radians((45, -90))):
                if len(theta) == len(self._world.scene.moving):
                    points.append(self._world.points_world(theta, T_world_base))
        return np.concatenate(points)

    def _show(self, node, visible: bool) -> None:
        """Or hide it. viser's setter looks up types, which takes longer than most drawings."""
        if self._shown.get(node.name) != visible:
            self._shown[node.name] = node.visible = visible

    def _add_point(self, arm: str, i: int) -> None:
        body = self._world.body
        name = f"{link_name(self._world.scene, arm, int(body.link[i]))}/p{i}"
        scene, colour, position = self._client.scene, rgb(arm, self._dark), body.local[i]
        add = self._nodes.keep
        if arm == "learner":
            size = POINT_SIZE[arm] / 2
            add(scene.add_icosphere(name, size, color=colour, subdivisions=2, position=position, cast_shadow=False))
        else:
            shape = meshes.octahedron(POINT_SIZE[arm])
            add(scene.add_mesh_simple(name, *shape, color=colour, position=position, cast_shadow=False))

    def _add_moving_parts(self) -> None:
        count = len(self._world.body)
        scene, colour = self._client.scene, partial(rgb, dark=self._dark)
        nothing = np.zeros((4 * count, 2, 3), np.float32)
        self._rays = self._nodes.keep(
            scene.add_line_segments(
                "/now/rays",
                nothing,
                self._of_views(partial(faint, dark=self._dark), count),
                thickness=1,
                thickness_units="screen",
            )
        )
        self._chosen_rays = self._nodes.keep(
            scene.add_line_segments(
                "/now/chosen_rays", nothing[:4], self._of_views(colour, 1), thickness=1.6, thickness_units="screen"
            )
        )
        self._residuals = self._nodes.keep(
            scene.add_line_segments(
                "/now/residuals", nothing[:1], colour("residual"), thickness=3, thickness_units="screen"
            )
        )
        self._dots = self._nodes.keep(
            scene.add_point_cloud(
                "/now/dots",
                np.zeros((4 * count, 3)),
                np.repeat([colour(role) for role in VIEW_ROLES], count, axis=0),
                point_size=0.009,
                point_shape="circle",
                point_shading="flat",
                precision="float32",
            )
        )
        vertices, faces = meshes.octahedron(0.02)
        self._recovered = self._nodes.keep(
            scene.add_batched_meshes_simple(
                "/now/recovered",
                vertices,
                faces,
                batched_wxyzs=np.tile([1.0, 0, 0, 0], (count, 1)),
                batched_positions=np.zeros((count, 3)),
                batched_colors=linear(colour("recovered")),
                cast_shadow=False,
                lod="off",
            )
        )
        self._rings = [
            self._nodes.keep(
                scene.add_icosphere(
                    f"/now/chosen_{arm}", 0.017, color=colour("chosen"), visible=False, cast_shadow=False
                )
            )
            for arm in ("learner", "demonstrator")
        ]

    def _of_views(self, shade: Callable[[str], tuple[int, int, int]], count: int) -> NDArray:
        """(4 count, 2, 3): colours of so many segments from each view."""
        return np.repeat([linear(shade(role)) for role in VIEW_ROLES], 2 * count, axis=0).reshape(-1, 2, 3)

    def _on_plates(self, snapshot: Snapshot) -> tuple[NDArray, NDArray]:
        """All points as each camera sees them: (4, N, 3) m on its plate, and (4, N) whether it does."""
        images = np.concatenate([snapshot.views.demo, snapshot.views.own], -1).reshape(-1, 4, 2)
        plates = images.swapaxes(0, 1) @ self._plate_A.swapaxes(1, 2) + self._plate_b[:, None]
        return plates, snapshot.views.visible.T

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

    def _draw_residuals(self, state: PageState, own: NDArray) -> None:
        usable = state.shown.usable & (state.view.residuals and state.shown.transfer is not None)
        for node in (self._residuals, self._recovered):
            self._show(node, bool(usable.any()))
        if usable.any():
            positions = np.full((len(usable), 3), -50.0)
            positions[usable] = state.recovered_world[usable]
            push_array(self._recovered, "batched_positions", positions)
            push_array(self._residuals, "points", np.stack([positions[usable], own[usable]], axis=-2))

    def _choose_at(self, origin: NDArray, direction: NDArray) -> None:
        """The point at this ray, on whichever arm."""
        points = self._points
        if len(points):
            radius = np.repeat([POINT_SIZE["learner"] / 2, POINT_SIZE["demonstrator"] / 2], len(points) // 2)
            i = picked(points, radius, origin, direction, self._client.camera.fov)
            if i is not None:
                self._queue.put(ChoosePoint(i % (len(points) // 2)))

    def _draw_chosen(self, own: NDArray, demo: NDArray, chosen: int | None) -> None:
        for ring, points in zip(self._rings, (own, demo)):
            self._show(ring, chosen is not None)
            if chosen is not None:
                ring.position = points[chosen]


def segments(starts: NDArray, ends: NDArray, seen: NDArray) -> NDArray:
    """(…, 3) m twice → (n, 2, 3), those that are not seen out of sight."""
    return np.where(seen[..., None, None], np.stack([starts, ends], axis=-2), FAR_AWAY).reshape(-1, 2, 3)


def linear(color: tuple[int, int, int]) -> tuple[int, int, int]:
    """Batched meshes, and segments of several colours, read them as linear light."""
    return tuple(round(255 * (c / 255) ** 2.2) for c in color)
