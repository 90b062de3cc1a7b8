"""The 3-D scene of one page: arms, head, frusta, body points, residuals, rays. Truth, for the viewer only."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from viser import ClientHandle, ViserServer

from viewimit.camera import Camera, triangulate
from viewimit.geometry.rigid import rotation_about_axis
from viewimit.session import Snapshot
from viewimit.world import World

from . import meshes
from .arms import Arm, link_name, share_meshes, skeleton_frames
from .theme import rgb
from .wire import quaternion

PLATE = 0.17  # m from the camera to its image plate
VIEW_ROLES = ("demonstrator", "demonstrator", "learner", "learner")
POINT_SIZE = {"learner": 0.021, "demonstrator": 0.027}
FOV = np.radians(36.0)
MARGIN = 0.93  # of the half angle that the default view fills
AZIMUTH, ELEVATION = np.radians((-134.0, 27.0))  # from behind left: no image plate is seen edge-on


def share_scene(server: ViserServer) -> None:
    """What all pages share: link meshes, floor, light."""
    scene = server.scene
    scene.configure_default_lights(enabled=False)
    scene.add_light_hemisphere("/light/sky", sky_color=(255, 255, 255), ground_color=(190, 190, 200), intensity=1.2)
    scene.add_light_directional("/light/sun", intensity=1.7, cast_shadow=True, position=(-2.0, -3.0, 5.0))
    scene.add_grid(
        "/floor",
        width=12,
        height=12,
        cell_size=0.25,
        section_size=1.0,
        cell_color=(236, 238, 241),
        section_color=(214, 218, 224),
        shadow_opacity=0.10,
        fade_distance=9.0,
    )
    share_meshes(server)


class Scene3D:
    """build in __init__, then draw(snapshot, …) as often as wanted; rebuild for another world."""

    def __init__(self, client: ClientHandle, on_choose: Callable[[int], None], below: float):
        self._client, self._on_choose, self._below = client, on_choose, below
        self._arms: dict[str, Arm] = {}
        self._nodes: list = []
        self._points: dict[str, list] = {}

    def build(self, world: World) -> None:
        """Set up the scene of a world, in place of the one before."""
        for arm in self._arms.values():
            arm.remove()
        for node in self._nodes:
            node.remove()
        self._world, self._nodes = world, []
        self._arms = {
            "learner": Arm(self._client, world, "learner", world.T_world_own),
            "demonstrator": Arm(self._client, world, "demonstrator", world.T_world_demo),
        }
        self._bases = {"learner": world.T_world_own, "demonstrator": world.T_world_demo}
        self._cameras = (*world.demo_cameras, *world.own_cameras)
        for arm, T_world_base in self._bases.items():
            self._add_pedestal(arm, T_world_base)
            self._points[arm] = [self._add_point(arm, i) for i in range(len(world.body))]
        self._add_head()
        for name, camera, role in zip("lrLR", self._cameras, VIEW_ROLES):
            self._add_frustum(name, camera, role)
        self._add_moving_parts()

    def draw(self, snapshot: Snapshot, chosen: int | None, show: dict[str, bool]) -> None:
        """Poses at once; points on the plates, rays and residuals with them."""
        self.draw_poses(snapshot.theta, snapshot.theta_demo)
        own = self._world.points_world(snapshot.theta, self._bases["learner"])
        demo = self._world.points_world(snapshot.theta_demo, self._bases["demonstrator"])
        on_plates, seen = self._on_plates(snapshot)
        self._draw_rays(on_plates, seen, demo, own, chosen, show)
        self._draw_residuals(snapshot, own, show["residuals"])
        self._draw_chosen(own, demo, chosen)

    def draw_poses(self, theta: NDArray, theta_demo: NDArray) -> None:
        """Turn the arms only, (m,) rad each."""
        self._arms["learner"].draw(self._world.joint_angles(theta))
        self._arms["demonstrator"].draw(self._world.joint_angles(theta_demo))

    def hand_position(self, theta_demo: NDArray) -> NDArray:
        """(3,) m, the origin of the demonstrator's last link."""
        return skeleton_frames(self._world, theta_demo, self._bases["demonstrator"])[-1][:3, 3]

    def fit_view(self) -> None:
        """The default camera, as near as the canvas allows; `below` px of it are covered by overlays."""
        camera = self._client.camera
        width, height = camera.image_width, max(camera.image_height, 1)
        position, target = fitted_view(self._landmarks(), width / height, self._below / height)
        camera.fov = float(FOV)
        camera.position, camera.look_at = position, target

    def _landmarks(self) -> NDArray:
        """(k, 3) m: what the default view must hold."""
        plates = [self._to_plate(camera, corners(camera)) for camera in self._cameras]
        points = [*plates, np.array([self._world.scene.head.position]) * [1, 1, 0]]
        for T_world_base in self._bases.values():
            points.append(T_world_base[:3, 3][None] * [1, 1, 0])
            for theta in (self._world.scene.lower, self._world.scene.upper, np.radians((45, -90))):
                if len(theta) == len(self._world.scene.moving):
                    points.append(self._world.points_world(theta, T_world_base))
        return np.concatenate(points)

    def _keep(self, node):
        self._nodes.append(node)
        return node

    def _add_pedestal(self, arm: str, T_world_base: NDArray) -> None:
        x, y, height = T_world_base[:3, 3]
        vertices, faces = meshes.pedestal(max(height, 0.03))
        scene = self._client.scene
        self._keep(
            scene.add_mesh_simple(
                f"/stage/{arm}_pedestal", vertices, faces, color=(176, 180, 188), position=(x, y, height), side="double"
            )
        )
        self._keep(
            scene.add_label(
                f"/stage/{arm}_label",
                arm,
                position=(x - 0.3, y - 0.3, 0.02),
                font_screen_scale=0.8,
                anchor="top-center",
            )
        )

    def _add_head(self) -> None:
        """The head between its two gazes: a stand, a bar of the baseline's length, a camera at each end."""
        centre = np.array(self._world.scene.head.position)
        below = centre - [0, 0, 0.045]
        scene = self._client.scene
        forward = sum(camera.T_world_camera[:3, 2] for camera in self._cameras) * [1, 1, 0]
        turn = rotation_about_axis([0, 0, 1], np.arctan2(forward[1], forward[0]))
        half = self._world.scene.head.baseline / 2
        parts = [("stand", meshes.stand(below[2]), below, (120, 128, 140))]
        parts.append(("bar", meshes.box((0.04, 2 * half + 0.06, 0.025)), below, (120, 128, 140)))
        for side in (-1, 1):
            place = centre + turn @ [-0.035, side * half, 0]
            parts.append((f"camera{side}", meshes.box((0.07, 0.09, 0.065)), place, (44, 50, 60)))
        for name, (vertices, faces), position, color in parts:
            self._keep(
                scene.add_mesh_simple(
                    f"/stage/{name}",
                    vertices,
                    faces,
                    color=color,
                    position=position,
                    wxyz=quaternion(turn),
                    side="double",
                )
            )

    def _add_frustum(self, name: str, camera: Camera, role: str) -> None:
        plate = self._to_plate(camera, corners(camera))
        eye = camera.T_world_camera[:3, 3]
        edges = [(plate[i], plate[(i + 1) % 4]) for i in range(4)] + [(eye, corner) for corner in plate]
        scene = self._client.scene
        self._keep(
            scene.add_line_segments(
                f"/stage/frustum_{name}",
                np.array(edges, np.float32),
                rgb(role),
                thickness=1.6,
                thickness_units="screen",
            )
        )
        self._keep(
            scene.add_mesh_simple(
                f"/stage/plate_{name}",
                plate,
                np.array([[0, 1, 2], [0, 2, 3]]),
                color=(245, 246, 248),
                opacity=0.55,
                side="double",
                cast_shadow=False,
                receive_shadow=False,
            )
        )
        self._keep(
            scene.add_label(
                f"/stage/name_{name}", name, position=plate[1] + 0.12 * (plate[1] - eye), font_screen_scale=0.8
            )
        )

    def _add_point(self, arm: str, i: int):
        body = self._world.body
        name = f"{link_name(self._world.scene, arm, int(body.link[i]))}/p{i}"
        if arm == "learner":
            handle = self._client.scene.add_icosphere(
                name, POINT_SIZE[arm] / 2, color=rgb(arm), subdivisions=2, position=body.local[i], cast_shadow=False
            )
        else:
            vertices, faces = meshes.octahedron(POINT_SIZE[arm])
            handle = self._client.scene.add_mesh_simple(
                name, vertices, faces, color=rgb(arm), position=body.local[i], cast_shadow=False
            )

        @handle.on_click
        async def _(_event, i=i) -> None:
            self._on_choose(i)

        return self._keep(handle)

    def _add_moving_parts(self) -> None:
        scene, nothing = self._client.scene, np.zeros((1, 2, 3), np.float32)
        count = len(self._world.body)
        self._rays = self._keep(
            scene.add_line_segments("/now/rays", nothing, rgb("secondary"), thickness=1, thickness_units="screen")
        )
        self._chosen_rays = self._keep(
            scene.add_line_segments("/now/chosen_rays", nothing, rgb("chosen"), thickness=2.4, thickness_units="screen")
        )
        self._residuals = self._keep(
            scene.add_line_segments("/now/residuals", nothing, rgb("residual"), thickness=3, thickness_units="screen")
        )
        self._dots = self._keep(
            scene.add_point_cloud(
                "/now/dots",
                np.zeros((4 * count, 3)),
                np.repeat([rgb(role) for role in VIEW_ROLES], count, axis=0),
                point_size=0.009,
                point_shape="circle",
                point_shading="flat",
                precision="float32",
            )
        )
        vertices, faces = meshes.octahedron(0.02)
        self._recovered = self._keep(
            scene.add_batched_meshes_simple(
                "/now/recovered",
                vertices,
                faces,
                batched_wxyzs=np.tile([1.0, 0, 0, 0], (count, 1)),
                batched_positions=np.zeros((count, 3)),
                batched_colors=linear(rgb("recovered")),
                cast_shadow=False,
                lod="off",
            )
        )
        self._rings = [
            self._keep(
                scene.add_icosphere(f"/now/chosen_{arm}", 0.017, color=rgb("chosen"), visible=False, cast_shadow=False)
            )
            for arm in ("learner", "demonstrator")
        ]

    def _to_plate(self, camera: Camera, image: NDArray) -> NDArray:
        """image: (k, 2) px → (k, 3) m on the plate in front of the camera."""
        x = (image[:, 0] - camera.centre[0]) / camera.focal
        y = (image[:, 1] - camera.centre[1]) / camera.focal
        T = camera.T_world_camera
        return np.column_stack([x, y, np.ones_like(x)]) * PLATE @ T[:3, :3].T + T[:3, 3]

    def _on_plates(self, snapshot: Snapshot) -> tuple[NDArray, NDArray]:
        """All points as each camera sees them: (4, N, 3) m on its plate, and (4, N) whether it does."""
        images = np.concatenate([snapshot.views.demo, snapshot.views.own], -1)
        plates = [self._to_plate(camera, images[:, 2 * k : 2 * k + 2]) for k, camera in enumerate(self._cameras)]
        return np.array(plates), snapshot.views.visible.T

    def _draw_rays(self, plates: NDArray, seen: NDArray, demo, own, chosen: int | None, show) -> None:
        far_away = np.array([0, 0, -50.0])
        self._dots.points = np.where(seen[..., None], plates, far_away).reshape(-1, 3)
        targets = np.stack([demo, demo, own, own])
        rays = np.stack([plates, targets], axis=-2)  # (4, N, 2, 3)
        self._rays.visible = show["rays"]
        if show["rays"]:
            self._rays.points = rays[seen].astype(np.float32)
        picked = chosen is not None and bool(seen[:, chosen].any())
        self._chosen_rays.visible = picked
        if picked:
            eyes = np.array([camera.T_world_camera[:3, 3] for camera in self._cameras])
            lines = np.stack([eyes, targets[:, chosen]], axis=-2)
            self._chosen_rays.points = lines[seen[:, chosen]].astype(np.float32)

    def _draw_residuals(self, snapshot: Snapshot, own: NDArray, show: bool) -> None:
        usable = snapshot.usable & bool(show)
        self._residuals.visible = self._recovered.visible = bool(usable.any())
        if usable.any():
            positions = np.full((len(usable), 3), -50.0)
            positions[usable] = triangulate(*self._world.own_cameras, snapshot.recovered[usable])
            self._recovered.batched_positions = positions.astype(np.float32)
            ends = np.stack([positions[usable], own[usable]], axis=-2)
            self._residuals.points = ends.astype(np.float32)

    def _draw_chosen(self, own: NDArray, demo: NDArray, chosen: int | None) -> None:
        for ring, points in zip(self._rings, (own, demo)):
            ring.visible = chosen is not None
            if chosen is not None:
                ring.position = points[chosen]


def corners(camera: Camera) -> NDArray:
    """(4, 2) px, clockwise from the top left."""
    return np.array([[0, 0], [camera.width, 0], [camera.width, camera.height], [0, camera.height]], float)


def fitted_view(points: NDArray, aspect: float, below: float) -> tuple[NDArray, NDArray]:
    """Position and target of a camera from AZIMUTH, ELEVATION and FOV that just holds (k, 3) points.

    below: share of the height, from the bottom, that stays free. Each side of the frame is a plane through the
    eye, with a slope per depth; along its normal the points give one bound, and opposite bounds meet at the eye.
    """
    backward = np.array(
        [np.cos(ELEVATION) * np.cos(AZIMUTH), np.cos(ELEVATION) * np.sin(AZIMUTH), np.sin(ELEVATION)]
    )
    right = np.cross([0, 0, 1.0], backward)
    right /= np.linalg.norm(right)
    up = np.cross(backward, right)
    tan = np.tan(FOV / 2)
    x, y, z = points @ right, points @ up, points @ backward
    eye = []
    for coordinate, low_slope, high_slope in (
        (x, tan * aspect * MARGIN, tan * aspect * MARGIN),
        (y, tan * (1 - 2 * below) * MARGIN, tan * MARGIN),
    ):
        high, low = np.max(coordinate + high_slope * z), np.min(coordinate - low_slope * z)
        distance = (high - low) / (high_slope + low_slope)
        eye.append((distance, high_slope, low_slope, high, low))
    distance = max(eye[0][0], eye[1][0])
    centres = []  # of the room that is left where the other direction decides the distance
    for _, high_slope, low_slope, high, low in eye:
        centres.append((high - high_slope * distance + low + low_slope * distance) / 2)
    position = centres[0] * right + centres[1] * up + distance * backward
    depth = distance - np.mean(z)
    return position, position - depth * backward


def linear(color: tuple[int, int, int]) -> tuple[int, int, int]:
    """Batched meshes read colours as linear light."""
    return tuple(round(255 * (c / 255) ** 2.2) for c in color)
