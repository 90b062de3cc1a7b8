"""The 3-D scene of one page: arms, head, frusta, body points, residuals, rays. Truth, for the viewer only."""

import math
from collections import deque
from collections.abc import Callable, Iterable, Sequence

import numpy as np
from numpy.typing import NDArray
from viser import ClientHandle, ImageHandle, SceneClickEvent, ViserServer

from viewimit.drawing.export.perspective import Viewpoint
from viewimit.drawing.theme import rgb
from viewimit.loop.snapshot import Snapshot
from viewimit.simulation import scene_geometry as geometry
from viewimit.simulation.meshes import SurfaceHit, first_hit
from viewimit.simulation.robot import link_meshes
from viewimit.simulation.world import World, hand_position

from ..model.displayed import Displayed
from ..model.page_model import PageModel
from ..model.queue import CommandQueue
from .arms import ALWAYS_SEEN, Arms, link_name
from .fixtures import Fixtures, add_floor, add_light
from .moment import Moment, ProposedPoint
from .nodes import Nodes, add_text

UNCOVERED = 0.05  # of the canvas's height, that is kept of what the strip covers


def share_light(server: ViserServer) -> None:
    """What all pages share besides meshes. Without viser's environment map, whose shaders take a browser that renders
    in software seconds to make ready."""
    server.scene.configure_default_lights(enabled=False)
    server.scene.configure_environment_map(hdri=None)
    add_light(server.scene, geometry.LOOKS[False])


class Scene3D:
    """`build` for a world, then `arms.draw` and `show` as often as needed; `build` again for another world.
    share(robot, arm): puts its meshes on the server's scene, before they are first shown."""

    def __init__(self, client: ClientHandle, queue: CommandQueue, share: Callable[[str, str], None]):
        self._client, self._queue = client, queue
        self._share = share
        self.arms: Arms | None = None  # before the first world
        self._nodes = Nodes()
        self._gizmo = HandGizmo(client, queue)
        self._dark, self._shadows, self._fits = False, False, 0
        self._pictured = False  # whether the image plates show pictures
        self._view = DefaultView(client)
        self._points = np.zeros((0, 3))  # m, the learner's and the demonstrator's as they are drawn
        self._edited: Snapshot | None = None  # where the arms stand while a click places a point

        @client.scene.on_click()  # type: ignore[arg-type]  # which takes coroutines too
        async def _(event: SceneClickEvent) -> None:
            self._take_click(np.array(event.ray_origin), np.array(event.ray_direction))

    def build(self, world: World) -> None:
        """Set up the scene of a world, after removing the one before."""
        self._nodes.begin()
        self._world = world
        self.arms = Arms(self._client, self._nodes, world, self._share)
        self._bases = {"learner": world.T_world_own, "demonstrator": world.T_world_demo}
        self._demo_points: tuple[NDArray, NDArray] | None = None  # a posture and its points
        self._furnish()
        self._nodes.end()
        self._view.forget()

    def _furnish(self) -> None:
        """All but the arms, in the colours of the scheme, after removing those there."""
        add_floor(self._client.scene, self._world, self._dark, self._shadows)
        self._fixtures = Fixtures(self._client, self._nodes, self._world, self._dark)
        for name in self._bases:
            for i in range(len(self._world.body)):
                self._add_point(name, i)
        self._gizmo.furnish(self._nodes, self._dark, self._world.scene.size)
        self._moment = Moment(self._client, self._nodes, self._world, self._dark)
        self._proposed = ProposedPoint(self._client, self._nodes, self._world)

    def key(self, model: PageModel) -> tuple:
        """What `show` depends on; of snapshots their identity counts."""
        shown = model.displayed
        posed = model.snapshot.theta_demo.tobytes(), self._gizmo.drops, self._view.aspect, self._view.camera_is_default
        return model.generation, shown.scene_snapshot, model.view, model.edited, *posed, *shown.pictures.values()

    def show(self, model: PageModel) -> None:
        """All but the poses of the arms. A canvas of another shape, as when panels dock, is fitted again."""
        view, snapshot, points = model.view, model.displayed.scene_snapshot, model.edited
        if (view.on("dark"), view.shadows) != (self._dark, self._shadows):
            self._dark, self._shadows = view.on("dark"), view.shadows
            add_light(self._client.scene, geometry.LOOKS[self._dark], self._shadows)
            self._furnish()
        self._view.follow(lambda: self._landmarks(model.snapshot))
        if view.fits != self._fits:
            self._fits = view.fits
            self._view.fit(self._landmarks(model.snapshot))
        self._draw(model.displayed)
        self._edited = snapshot if points.on else None
        self._proposed.show(None if points.proposal is None else points.proposal.point)
        if model.displayed.pictures or self._pictured:
            self._fixtures.show_pictures(model.displayed.pictures)
        self._pictured = bool(model.displayed.pictures)
        self._gizmo.show(view.gizmo, self._world, snapshot.theta_demo)

    def _draw(self, displayed: Displayed) -> None:
        """The snapshot that is shown."""
        snapshot = displayed.scene_snapshot
        own = self._world.points_world(snapshot.theta, self._bases["learner"])
        if self._demo_points is None or self._demo_points[0] is not snapshot.theta_demo:  # it mostly rests
            points = self._world.points_world(snapshot.theta_demo, self._bases["demonstrator"])
            self._demo_points = snapshot.theta_demo, points
        demo = self._demo_points[1]
        self._points = np.concatenate([own, demo])
        self._moment.draw(displayed, own, demo)

    def eye(self) -> Viewpoint | None:
        """That of the visitor, without what lies under the strip; None before the browser has said."""
        camera = self._client.camera
        if (aspect := self._view.aspect) is None:
            return None
        position, target = np.array(camera.position), np.array(camera.look_at)
        return Viewpoint(position, target, float(camera.fov), aspect, geometry.BELOW - UNCOVERED)

    def _landmarks(self, present: Snapshot) -> NDArray:
        """(k, 3) m: what the default view must hold, the arms where they are and at the ends of their range."""
        arms = geometry.arm_landmarks(self._world, present.theta, present.theta_demo)
        return np.concatenate([geometry.landmarks(self._world), arms])

    def _add_point(self, arm: str, i: int) -> None:
        body, scene, size = self._world.body, self._client.scene, self._world.scene.size * geometry.POINT_SIZE[arm]
        name = f"{link_name(self._world.scene, arm, int(body.link[i]))}/p{i}"
        colour, at, keep = rgb(arm, self._dark), body.local[i], self._nodes.keep
        if arm == "learner":
            keep(scene.add_icosphere(name, size / 2, colour, subdivisions=2, position=at, cast_shadow=False))
        else:
            keep(scene.add_mesh_simple(name, *geometry.octahedron(size), color=colour, position=at, cast_shadow=False))

    def _take_click(self, origin: NDArray, direction: NDArray) -> None:
        """Choose the point at this ray, on either arm; while points are edited, one that nothing hides, or place
        one where the ray meets an arm."""
        points, size = self._points, self._world.scene.size
        if not len(points):
            return
        radius = size * np.repeat([geometry.POINT_SIZE[arm] / 2 for arm in ALWAYS_SEEN], len(points) // 2)
        hit = None if self._edited is None else self._surface_at(self._edited, origin, direction)
        surface = np.inf if hit is None else hit.distance
        i = picked(points, radius, origin, direction, self._client.camera.fov, surface)
        if i is not None:
            self._queue.call("choose_point", i % (len(points) // 2))
        elif hit is not None:
            self._queue.call("place_point", hit.link, hit.local)

    def _surface_at(self, shown: Snapshot, origin: NDArray, direction: NDArray) -> SurfaceHit | None:
        """Where the ray meets the nearer of both arms."""
        world, meshes = self._world, link_meshes(self._world.scene.robot)
        postures = {"learner": shown.theta, "demonstrator": shown.theta_demo}
        frames = [world.link_frames(postures[name], T_world_base) for name, T_world_base in self._bases.items()]
        hits = [first_hit(meshes, T_world_links, origin, direction) for T_world_links in frames]
        return min((hit for hit in hits if hit is not None), key=lambda hit: hit.distance, default=None)


SAME_SHAPE = 0.01  # of an aspect: viser draws with fewer pixels when it is slow, and rounds their number
UNTOUCHED = 0.01  # m that a camera may be off a place where the page put it
NUDGE = 1e-3  # m: viser sends no place that equals the browser's last one, which may be outdated
LATELY = 8  # such places: the browser may tell of an earlier one while the window's edge is dragged
BEFORE = (-5.0, 0.0, 0.0), (3.0, 3.0, 3.0)  # m, where three.js and then viser put a camera that nobody has put anywhere


class DefaultView:
    """One page's camera, put where it shows all, until the visitor moves it."""

    def __init__(self, client: ClientHandle):
        self._client = client
        self._aspect: float | None = None  # of the canvas that was fitted last
        self._places = deque([np.array(client.camera.position)], LATELY)  # where it was found or put

    @property
    def aspect(self) -> float | None:
        """Width by height of the canvas, in pixels of any size; None while it has no size."""
        width, height = self._client.camera.image_width, self._client.camera.image_height
        return width / height if min(width, height) > 0 else None

    def fit(self, landmarks: NDArray) -> None:
        """As near as the canvas allows. landmarks: (k, 3) m, what must be seen."""
        camera, self._aspect = self._client.camera, self.aspect
        position, target = geometry.fit_view(landmarks, self._aspect or 1.0, geometry.BELOW)
        camera.fov = float(geometry.FOV)
        for offset in (NUDGE, 0.0):
            camera.position, camera.look_at = position + offset, target + offset
        self._places.append(position)

    @property
    def camera_is_default(self) -> bool:
        """Whether the browser reports viser's own place for a camera that was put elsewhere: it had no camera yet."""
        return self._aspect is not None and self._at(BEFORE)

    def follow(self, landmarks: Callable[[], NDArray]) -> None:
        """Fit a camera that is where the page put it to a canvas of another shape than before, or one that is
        at viser's default place."""
        aspect, is_default = self.aspect, self.camera_is_default
        if aspect is None:
            return
        is_same = self._aspect is not None and abs(math.log(aspect / self._aspect)) < SAME_SHAPE
        if is_same and not is_default:
            return
        self._aspect = aspect
        if is_default or self._at((*BEFORE, *self._places)):
            self.fit(landmarks())

    def forget(self) -> None:
        """The scene was replaced: the next `follow` fits the camera again."""
        self._aspect = None

    def _at(self, places: Iterable[Sequence[float] | NDArray]) -> bool:
        """Whether the camera is at one of places (3,) m."""
        here = self._client.camera.position
        return any(math.dist(here, place) < UNTOUCHED for place in places)


NODE = "/demonstrator_hand"
SIZE = 0.22  # m, of its arrows
ABOVE, LINE = np.array([0, 0, SIZE + 0.07]), 0.07  # m from the hand to its name; the height of a line


class HandGizmo:
    """The demonstrator's hand follows while it is dragged. drops: how often it was released, after which it is to be
    shown where the hand could come to."""

    def __init__(self, client: ClientHandle, queue: CommandQueue):
        self.drops, self._size = 0, 1.0
        self._client, self._dragging, self._let_go = client, False, False
        self._hand: tuple[World, NDArray, NDArray] | None = None  # where, in which posture, and so at which place
        self._name: ImageHandle | None = None  # before the first world
        self._visible: bool | None = None  # None: as it was made
        self._gizmo = client.scene.add_transform_controls(
            NODE, scale=SIZE, disable_rotations=True, disable_sliders=True, opacity=0.7
        )

        @self._gizmo.on_update
        async def _(event) -> None:
            self._dragging = event.phase != "end"
            queue.call("pose_hand", event.target.position)
            if not self._dragging:
                self.drops, self._let_go = self.drops + 1, True

    def furnish(self, nodes: Nodes, dark: bool, size: float) -> None:
        """Give it its name, in the colours of a scheme, in a scene of that size."""
        nothing, self._size = np.zeros(3), size
        if self._gizmo.scale != SIZE * size:
            self._gizmo.scale = SIZE * size
        name = add_text(self._client.scene, f"{NODE}_name", "hand", "demonstrator", dark, nothing, LINE * size)
        self._name = nodes.keep(name)
        self._hand = self._visible = None

    def show(self, visible: bool, world: World, theta_demo: NDArray) -> None:
        """At the hand in this posture, unless the visitor holds it somewhere else."""
        assert self._name is not None
        if visible != self._visible:
            self._visible = self._gizmo.visible = self._name.visible = visible
        if self._hand is None or self._hand[0] is not world or not np.array_equal(self._hand[1], theta_demo):
            self._hand, self._let_go = (world, theta_demo, hand_position(world, theta_demo, world.T_world_demo)), True
            self._name.position = self._hand[2] + self._size * ABOVE
        if self._let_go and not self._dragging:
            self._gizmo.position, self._let_go = self._hand[2], False


REACH = 0.02  # of the canvas's height that a click may be off: a fingertip, 12 px of 600


def picked(
    points: NDArray, radius: NDArray, origin: NDArray, direction: NDArray, fov: float, surface: float = np.inf
) -> int | None:
    """Index of the one of (k, 3) points that a click at this ray means, None if all are too far from it. radius: (k,)
    m, as they are drawn; origin (3,) m, direction (3,): the ray; fov: rad, of the canvas's height; surface: m from the
    origin, where the ray ends: drawings behind that are hidden. Of points that are drawn under the click it is the one
    nearest to the eye, else the one nearest to the click."""
    away = points - origin
    depth = away @ (direction / np.linalg.norm(direction))
    offset = np.sqrt(np.maximum((away**2).sum(-1) - depth**2, 0))
    height = 2 * np.tan(fov / 2) * np.maximum(depth, 1e-6)  # m of the canvas at that depth
    off = np.where((depth > 0) & (depth - radius <= surface), np.maximum(offset - radius, 0) / height, np.inf)
    nearest = int(np.lexsort((depth, off))[0])
    return nearest if off[nearest] <= REACH else None
