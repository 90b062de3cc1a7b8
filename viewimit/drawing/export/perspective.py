"""The 3-D scene as a drawing in colours of print: shaded faces, painted from the farthest to the nearest.

Unlike a picture of the browser's canvas, it does not depend on the window's size and colour scheme.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...geometry.arrays import Floats
from ...loop.snapshot import Snapshot
from ...simulation import scene_geometry
from ...simulation.camera import triangulate
from ...simulation.robot import link_meshes
from ...simulation.scene_geometry import FOV, fit_view
from ...simulation.world import World
from .. import svg
from ..images.planes import image_points
from ..theme import ROLES, half_white, rgb
from .figures import WIDTH, Figure

SUN = np.array([-2.0, -3.0, 5.0]) / np.sqrt(38.0)
SKY, GROUND = np.array([0.91, 0.90, 1.0]), np.array([0.44, 0.43, 0.49])  # linear light from above and below
EXPOSURE = 4.0
NEAR = 0.02  # m: nearer parts are not drawn
CELLS = 7  # of the floor on either side
ASPECT = 1.3
CORNERS = 24  # of an outline or of a link's shadow
TRIANGLE = "M{:.1f} {:.1f}L{:.1f} {:.1f} {:.1f} {:.1f}z"
LOOK = scene_geometry.LOOKS[False]
_TURNS = 2 * np.pi * np.arange(CORNERS) / CORNERS
_COMPASS = np.stack([np.cos(_TURNS), np.sin(_TURNS)])


@dataclass(frozen=True)
class Viewpoint:
    """From where the scene is seen."""

    position: Floats  # (3,) m
    target: Floats  # (3,) m, in the middle of the picture
    fov: float = float(FOV)  # rad, vertical
    aspect: float = ASPECT  # width by height
    below: float = 0.0  # share of the height that is cut off at the bottom

    @property
    def axes(self) -> Floats:
        """Right, down and forward, (3, 3) in rows."""
        forward = self.target - self.position
        forward = forward / np.linalg.norm(forward)
        right = np.cross(forward, [0, 0, 1.0])
        right /= max(float(np.linalg.norm(right)), 1e-9)
        return np.stack([right, np.cross(forward, right), forward])

    def see(self, points: Floats) -> tuple[Floats, Floats]:
        """Project points, (..., 3) m. → px of the drawing, (..., 2); depth, (...) m."""
        seen = (points - self.position) @ self.axes.T
        depth = np.maximum(seen[..., 2], NEAR)
        half = np.array([WIDTH, WIDTH / self.aspect]) / 2
        return half + seen[..., :2] / depth[..., None] * (half[1] / np.tan(self.fov / 2)), seen[..., 2]


class Item(NamedTuple):
    """A part of the drawing, painted in the order of depth."""

    depth: float  # m
    drawing: str


Colour = tuple[int, int, int]  # 0 … 255


def default_viewpoint(world: World, moment: Snapshot) -> Viewpoint:
    """Return the page's default view, for a whole picture."""
    landmarks = [scene_geometry.landmarks(world), scene_geometry.arm_landmarks(world, moment.theta, moment.theta_demo)]
    return Viewpoint(*fit_view(np.concatenate(landmarks), ASPECT, 0.02))


def draw_space(
    world: World,
    moment: Snapshot,
    viewpoint: Viewpoint | None = None,
    rays: bool = False,
    outlines: bool = False,
    truth: bool = True,
) -> Figure:
    """Draw both arms at a moment.

    viewpoint: None for the page's own; rays: whether to draw lines from image points to body points; outlines: whether
    the arms' links are convex outlines instead of single faces, in a twentieth of the size; truth: whether to draw
    where the transferred points would be in space, and their residuals.
    """
    viewpoint = default_viewpoint(world, moment) if viewpoint is None else viewpoint
    bases = scene_geometry.bases_of(world)
    postures = {"learner": moment.theta, "demonstrator": moment.theta_demo}
    frames = {arm: world.link_frames(postures[arm], bases[arm]) for arm in bases}
    meshes, solids = link_meshes(world.scene.robot), scene_geometry.solids(world)
    links: list[tuple[Floats, NDArray[np.integer], Colour]] = [
        (mesh.vertices @ T[link, :3, :3].T + T[link, :3, 3], mesh.faces, half_white(arm))
        for arm, T in frames.items()
        for link, mesh in meshes.items()
    ]
    standing = [(one.vertices @ one.turn.T + one.position, one.faces, getattr(LOOK, one.colour)) for one in solids]
    drawn = standing if outlines else [*links, *standing]  # what stands is no convex body
    items = [item for vertices, faces, colour in drawn for item in _faces(viewpoint, vertices, faces, colour)]
    if outlines:
        items += [item for vertices, __, colour in links for item in _outline(viewpoint, vertices, colour)]
    points = {arm: world.points_world(postures[arm], bases[arm]) for arm in bases}
    items += _points(world, moment, viewpoint, points, rays, truth)
    painted = "".join(item.drawing for item in sorted(items, key=lambda item: -item.depth))
    shadows = "".join(_hull_shadow(viewpoint, vertices) for vertices, *__ in links)
    shadows += "".join(_shadow(viewpoint, vertices, faces) for vertices, faces, __ in standing)
    names = "".join(_label(viewpoint, label) for label in scene_geometry.labels(world))
    height = WIDTH / viewpoint.aspect * (1 - viewpoint.below)
    inside = (
        f'<svg width="{WIDTH}" height="{height:g}" viewBox="0 0 {WIDTH} {height:g}">{_floor(world, viewpoint)}'
        f'<g fill="{ROLES["ink"][0]}" opacity=".13">{shadows}</g>'
        f'<g stroke-width=".3" stroke-linejoin="round">{painted}</g>{names}</svg>'
    )
    title = f"Both arms in 3-D after {svg.count_motions(moment.motion)}, which the learner does not see"
    return Figure(inside, WIDTH, height, title)


def _faces(viewpoint: Viewpoint, vertices: Floats, faces: NDArray[np.integer], colour: Colour) -> Iterator[Item]:
    """Draw the faces that are turned to the viewer, shaded. colour: 0 … 255."""
    places, depth = viewpoint.see(vertices)
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normals, axis=1)
    normals = normals / np.maximum(length, 1e-12)[:, None]
    towards = (normals * (viewpoint.position - corners.mean(1))).sum(1)
    kept = (length > 0) & (depth[faces] > NEAR).all(1) & (towards > 0)
    shades = _shaded(normals[kept], colour)
    for triangle, far, shade in zip(places[faces[kept]].reshape(-1, 6), depth[faces[kept]].mean(1), shades.tolist()):
        tint = "#{:02x}{:02x}{:02x}".format(*shade)
        d = TRIANGLE.format(*triangle)
        yield Item(float(far), f'<path fill="{tint}" stroke="{tint}" d="{d}"/>')


def _outline(viewpoint: Viewpoint, vertices: Floats, colour: Colour) -> Iterator[Item]:
    """Draw the outline of a nearly convex body, lit from the side. colour: 0 … 255."""
    places, depth = viewpoint.see(vertices)
    if (depth > NEAR).all():
        corners = places[(places @ _COMPASS).argmax(0)]
        fill, edge = (
            "#{:02x}{:02x}{:02x}".format(*_shaded(np.array([way]), colour)[0])
            for way in ([0, -0.7, 0.7], [0, 0.7, -0.7])
        )
        look = f'fill="{fill}" stroke="{edge}"'
        yield Item(float(depth.mean()), f'<path {look} d="{svg.path(corners)}z"/>')


def _shaded(normals: Floats, colour: Colour) -> Floats:
    """Shade matt faces with these normals, (k, 3), under sky and sun. → (k, 3), 0 … 255."""
    up = 0.5 + 0.5 * normals[:, 2:]
    sky = (GROUND + (SKY - GROUND) * up) * LOOK.sky
    sun = np.maximum(normals @ SUN, 0)[:, None] * LOOK.sun
    light = (np.array(colour) / 255) ** 2.2 * (sky + sun) / EXPOSURE
    return np.rint(255 * np.minimum(light, 1) ** (1 / 2.2)).astype(int)


def _points(
    world: World, moment: Snapshot, viewpoint: Viewpoint, points: dict[str, Floats], rays: bool, truth: bool
) -> Iterator[Item]:
    """Draw body points, recovered points with residuals, and frusta with their image points."""
    size = world.scene.size
    for arm, places in points.items():
        shape = svg.circles if arm == "learner" else svg.diamonds
        for place in places:
            yield from _mark(viewpoint, place, scene_geometry.POINT_SIZE[arm] / 2 * size, shape, arm)
    recovered = triangulate(*world.own_cameras, moment.recovered)
    for own, found in zip(points["learner"], recovered if truth else ()):
        if np.isfinite(found).all():
            yield from _mark(viewpoint, found, 0.01 * size, svg.diamonds, "recovered")
            yield from _line(viewpoint, found, own, "residual", 1.4)
    images = image_points(moment.views)
    for k, (camera, role) in enumerate(zip(scene_geometry.cameras_of(world), scene_geometry.VIEW_ROLES)):
        for start, end in scene_geometry.frustum(camera, size):
            yield from _line(viewpoint, start, end, role, 0.9)
        plates = scene_geometry.on_plate(camera, images[k], size)
        for i in np.flatnonzero(moment.views.visible[:, k]):
            yield from _mark(viewpoint, plates[i], 0.0045 * size, svg.circles, role)
            if rays:
                yield from _line(viewpoint, plates[i], points[role][i], role, 0.5, 0.35)


def _mark(
    viewpoint: Viewpoint, place: Floats, radius: float, shape: Callable[[Floats, float], str], role: str
) -> Iterator[Item]:
    at, depth = viewpoint.see(place)
    if depth > NEAR:
        px = radius / float(depth) * WIDTH / viewpoint.aspect / 2 / np.tan(viewpoint.fov / 2)
        d = shape(at[None], round(max(px, 0.4), 2))
        yield Item(float(depth) - 2 * radius, f'<path fill="{ROLES[role][0]}" stroke="none" d="{d}"/>')


def _line(
    viewpoint: Viewpoint, start: Floats, end: Floats, role: str, width: float, opacity: float = 1
) -> Iterator[Item]:
    places, depth = viewpoint.see(np.stack([start, end]))
    if (depth > NEAR).all():
        look = f'stroke="{ROLES[role][0]}" stroke-width="{width}" stroke-opacity="{opacity}"'
        yield Item(float(depth.min()), f'<path {look} d="{svg.segments(places[:1], places[1:])}"/>')


def _hull_shadow(viewpoint: Viewpoint, vertices: Floats) -> str:
    """Draw the shadow of a nearly convex body on the floor."""
    ground = _cast(vertices)
    outline = ground[(ground @ _COMPASS).argmax(0)]
    places, depth = viewpoint.see(np.column_stack([outline, np.zeros(CORNERS)]))
    return f'<path d="{svg.path(places)}z"/>' if (depth > NEAR).all() else ""


def _shadow(viewpoint: Viewpoint, vertices: Floats, faces: NDArray[np.integer]) -> str:
    """Draw the shadow of any body on the floor, face by face, with one orientation, so that overlaps stay filled."""
    corners = _cast(vertices)[faces]
    (ax, ay), (bx, by) = (corners[:, 1] - corners[:, 0]).T, (corners[:, 2] - corners[:, 0]).T
    turned = ax * by < ay * bx
    corners[turned] = corners[turned][:, ::-1]
    places, depth = viewpoint.see(np.concatenate([corners, np.zeros((*corners.shape[:2], 1))], -1))
    seen = places[(depth > NEAR).all(1)].reshape(-1, 6)
    return f'<path d="{"".join(TRIANGLE.format(*triangle) for triangle in seen)}"/>'


def _cast(vertices: Floats) -> Floats:
    """Cast points, (V, 3) m, along the sunlight on the floor, (V, 2) m."""
    return vertices[:, :2] - vertices[:, 2:] * (SUN[:2] / SUN[2])


def _floor(world: World, viewpoint: Viewpoint) -> str:
    """Draw the floor's lines around the robots, without those that begin or end behind the viewer."""
    ends = scene_geometry.floor_lines(world, CELLS)[:, [0, -1]]
    places, depth = viewpoint.see(ends)
    seen = places[(depth > NEAR).all(1)]
    parts = [f'<path d="{svg.segments(line[:1], line[1:])}"/>' for line in seen]
    red, green, blue = LOOK.sections
    return f'<g stroke="rgb({red},{green},{blue})" stroke-width=".6">{"".join(parts)}</g>'


def _label(viewpoint: Viewpoint, label: scene_geometry.Label) -> str:
    at, depth = viewpoint.see(label.position)
    role = "demonstrator-edge" if label.role == "demonstrator" else label.role
    if depth <= NEAR:
        return ""
    red, green, blue = rgb(role)
    return (
        f'<text class="vi-b vi-mid" style="fill:rgb({red},{green},{blue})" x="{at[0]:.1f}" y="{at[1] + 4:.1f}">'
        f"{svg.escape(label.text)}</text>"
    )
