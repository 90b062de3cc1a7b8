"""The 3-D scene as a drawing, in colours of print: faces shaded and painted from the farthest to the nearest.

A picture from the server, not from the browser's canvas: whatever its size, it is as large and as light as print needs.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...loop.snapshot import Snapshot
from ...simulation import scene_geometry
from ...simulation.camera import triangulate
from ...simulation.robot import link_meshes
from ...simulation.scene_geometry import FOV, fitted_view
from ...simulation.world import World
from .. import svg
from ..theme import ROLES, half_white, rgb
from .figures import WIDTH, Figure

SUN = np.array([-2.0, -3.0, 5.0]) / np.sqrt(38.0)
SKY, GROUND = np.array([0.91, 0.90, 1.0]), np.array([0.44, 0.43, 0.49])  # linear light from above and below
EXPOSURE = 4.0
NEAR = 0.02  # m before the eye, nearer than which nothing is drawn
CELLS = 7  # of the floor on either side
ASPECT = 1.3
CORNERS = 24  # of a link's shadow
TRIANGLE = "M{:.1f} {:.1f}L{:.1f} {:.1f} {:.1f} {:.1f}z"
LOOK = scene_geometry.LOOKS[False]


@dataclass(frozen=True)
class Eye:
    """Where it is looked from. position, target: (3,) m; fov: rad, of the height; aspect: width by height; below: share
    of the height, from the bottom, that is cut off."""

    position: NDArray
    target: NDArray
    fov: float = float(FOV)
    aspect: float = ASPECT
    below: float = 0.0

    @property
    def axes(self) -> NDArray:
        """(3, 3): right, down, forward, in rows."""
        forward = self.target - self.position
        forward = forward / np.linalg.norm(forward)
        right = np.cross(forward, [0, 0, 1.0])
        right /= max(float(np.linalg.norm(right)), 1e-9)
        return np.stack([right, np.cross(forward, right), forward])

    def see(self, points: NDArray) -> tuple[NDArray, NDArray]:
        """(..., 3) m → px of the drawing (..., 2), depth (...) m."""
        seen = (points - self.position) @ self.axes.T
        depth = np.maximum(seen[..., 2], NEAR)
        half = np.array([WIDTH, WIDTH / self.aspect]) / 2
        return half + seen[..., :2] / depth[..., None] * (half[1] / np.tan(self.fov / 2)), seen[..., 2]


class Item(NamedTuple):
    """depth: m, at which it is painted."""

    depth: float
    drawing: str


def default_eye(world: World, moment: Snapshot) -> Eye:
    """As the page's, over the whole canvas."""
    landmarks = [scene_geometry.landmarks(world), scene_geometry.arm_landmarks(world, moment.theta, moment.theta_demo)]
    return Eye(*fitted_view(np.concatenate(landmarks), ASPECT, 0.02))


def draw_space(world: World, moment: Snapshot, eye: Eye | None = None, rays: bool = False) -> Figure:
    """Both arms at a moment. rays: from the image points to the points in space."""
    eye = default_eye(world, moment) if eye is None else eye
    bases = scene_geometry.bases_of(world)
    postures = {"learner": moment.theta, "demonstrator": moment.theta_demo}
    frames = {arm: world.link_frames(postures[arm], bases[arm]) for arm in bases}
    links, standing = list(_links(world, frames)), list(_standing(world))
    solids = [*links, *standing]
    items = [item for vertices, faces, colour in solids for item in _faces(eye, vertices, faces, colour)]
    items += _points(world, moment, eye, {arm: world.points_world(postures[arm], bases[arm]) for arm in bases}, rays)
    painted = "".join(item.drawing for item in sorted(items, key=lambda item: -item.depth))
    shadows = "".join(_hull_shadow(eye, vertices) for vertices, _, _ in links)
    shadows += "".join(_shadow(eye, vertices, faces) for vertices, faces, _ in standing)
    names = "".join(_label(eye, label) for label in scene_geometry.labels(world))
    height = WIDTH / eye.aspect * (1 - eye.below)
    inside = (
        f'<svg width="{WIDTH}" height="{height:g}" viewBox="0 0 {WIDTH} {height:g}">{_floor(world, eye)}'
        f'<g fill="{ROLES["ink"][0]}" opacity=".13">{shadows}</g>'
        f'<g stroke-width=".3" stroke-linejoin="round">{painted}</g>{names}</svg>'
    )
    title = f"Both arms in 3-D after {svg.count_motions(moment.motion)}, which the learner does not see"
    return Figure(inside, WIDTH, height, title)


def _links(world: World, frames: dict[str, NDArray]) -> Iterator[tuple[NDArray, NDArray, tuple]]:
    for arm, T_world_links in frames.items():
        for link, mesh in link_meshes(world.scene.robot).items():
            T = T_world_links[link]
            yield np.asarray(mesh.vertices) @ T[:3, :3].T + T[:3, 3], np.asarray(mesh.faces), half_white(arm)


def _standing(world: World) -> Iterator[tuple[NDArray, NDArray, tuple]]:
    for solid in scene_geometry.solids(world):
        yield solid.vertices @ solid.turn.T + solid.position, solid.faces, getattr(LOOK, solid.colour)


def _faces(eye: Eye, vertices: NDArray, faces: NDArray, colour: tuple[int, int, int]) -> Iterator[Item]:
    """Those that are turned to the eye, or all of them whose mesh may be open, shaded."""
    places, depth = eye.see(vertices)
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normals, axis=1)
    normals = normals / np.maximum(length, 1e-12)[:, None]
    towards = (normals * (eye.position - corners.mean(1))).sum(1)
    kept = (length > 0) & (depth[faces] > NEAR).all(1) & (towards > 0)
    shades = _shaded(normals[kept], colour)
    for triangle, far, shade in zip(places[faces[kept]].reshape(-1, 6), depth[faces[kept]].mean(1), shades.tolist()):
        tint = "#{:02x}{:02x}{:02x}".format(*shade)
        d = TRIANGLE.format(*triangle)
        yield Item(float(far), f'<path fill="{tint}" stroke="{tint}" d="{d}"/>')


def _shaded(normals: NDArray, colour: tuple[int, int, int]) -> NDArray:
    """(k, 3) normals → (k, 3) 0 … 255: matt, under a sky and the sun."""
    up = 0.5 + 0.5 * normals[:, 2:]
    sky = (GROUND + (SKY - GROUND) * up) * LOOK.sky
    sun = np.maximum(normals @ SUN, 0)[:, None] * LOOK.sun
    light = (np.array(colour) / 255) ** 2.2 * (sky + sun) / EXPOSURE
    return np.rint(255 * np.minimum(light, 1) ** (1 / 2.2)).astype(int)


def _points(world: World, moment: Snapshot, eye: Eye, points: dict[str, NDArray], rays: bool) -> Iterator[Item]:
    """Body points, recovered ones with their residuals, frusta with what their images show."""
    size = world.scene.size
    for arm, places in points.items():
        shape = svg.circles if arm == "learner" else svg.diamonds
        for place in places:
            yield from _mark(eye, place, scene_geometry.POINT_SIZE[arm] / 2 * size, shape, arm)
    recovered = triangulate(*world.own_cameras, moment.recovered)
    for own, found in zip(points["learner"], recovered):
        if np.isfinite(found).all():
            yield from _mark(eye, found, 0.01 * size, svg.diamonds, "recovered")
            yield from _line(eye, found, own, "residual", 1.4)
    images = np.concatenate([moment.views.demo, moment.views.own], -1).reshape(-1, 4, 2).swapaxes(0, 1)
    for k, (camera, role) in enumerate(zip(scene_geometry.cameras_of(world), scene_geometry.VIEW_ROLES)):
        for start, end in scene_geometry.frustum(camera, size):
            yield from _line(eye, start, end, role, 0.9)
        plates = scene_geometry.on_plate(camera, images[k], size)
        for i in np.flatnonzero(moment.views.visible[:, k]):
            yield from _mark(eye, plates[i], 0.0045 * size, svg.circles, role)
            if rays:
                yield from _line(eye, plates[i], points[role][i], role, 0.5, 0.35)


def _mark(eye: Eye, place: NDArray, radius: float, shape: Callable[[NDArray, float], str], role: str) -> Iterator[Item]:
    at, depth = eye.see(place)
    if depth > NEAR:
        px = radius / float(depth) * WIDTH / eye.aspect / 2 / np.tan(eye.fov / 2)
        d = shape(at[None], round(max(px, 0.4), 2))
        yield Item(float(depth) - 2 * radius, f'<path fill="{ROLES[role][0]}" stroke="none" d="{d}"/>')


def _line(eye: Eye, start: NDArray, end: NDArray, role: str, width: float, opacity: float = 1) -> Iterator[Item]:
    places, depth = eye.see(np.stack([start, end]))
    if (depth > NEAR).all():
        look = f'stroke="{ROLES[role][0]}" stroke-width="{width}" stroke-opacity="{opacity}"'
        yield Item(float(depth.min()), f'<path {look} d="{svg.segments(places[:1], places[1:])}"/>')


def _hull_shadow(eye: Eye, vertices: NDArray) -> str:
    """On the floor, of a body that is nearly convex."""
    ground = _cast(vertices)
    turns = 2 * np.pi * np.arange(CORNERS) / CORNERS
    outline = ground[(ground @ np.stack([np.cos(turns), np.sin(turns)])).argmax(0)]
    places, depth = eye.see(np.column_stack([outline, np.zeros(CORNERS)]))
    return f'<path d="{svg.path(places)}z"/>' if (depth > NEAR).all() else ""


def _shadow(eye: Eye, vertices: NDArray, faces: NDArray) -> str:
    """On the floor, of any body, face by face, all turned the same way, so that none takes another away."""
    corners = _cast(vertices)[faces]
    (ax, ay), (bx, by) = (corners[:, 1] - corners[:, 0]).T, (corners[:, 2] - corners[:, 0]).T
    turned = ax * by < ay * bx
    corners[turned] = corners[turned][:, ::-1]
    places, depth = eye.see(np.concatenate([corners, np.zeros((*corners.shape[:2], 1))], -1))
    seen = places[(depth > NEAR).all(1)].reshape(-1, 6)
    return f'<path d="{"".join(TRIANGLE.format(*triangle) for triangle in seen)}"/>'


def _cast(vertices: NDArray) -> NDArray:
    """(V, 3) m → (V, 2) m, where the sun casts them on the floor."""
    return vertices[:, :2] - vertices[:, 2:] * (SUN[:2] / SUN[2])


def _floor(world: World, eye: Eye) -> str:
    """Lines about what stands there, but for those that begin or end behind the eye."""
    ends = scene_geometry.floor_lines(world, CELLS)[:, [0, -1]]
    places, depth = eye.see(ends)
    seen = places[(depth > NEAR).all(1)]
    parts = [f'<path d="{svg.segments(line[:1], line[1:])}"/>' for line in seen]
    red, green, blue = LOOK.sections
    return f'<g stroke="rgb({red},{green},{blue})" stroke-width=".6">{"".join(parts)}</g>'


def _label(eye: Eye, label: scene_geometry.Label) -> str:
    at, depth = eye.see(label.position)
    role = "demonstrator-edge" if label.role == "demonstrator" else label.role
    if depth <= NEAR:
        return ""
    red, green, blue = rgb(role)
    return (
        f'<text class="vi-b vi-mid" style="fill:rgb({red},{green},{blue})" x="{at[0]:.1f}" y="{at[1] + 4:.1f}">'
        f"{svg.escape(label.text)}</text>"
    )
