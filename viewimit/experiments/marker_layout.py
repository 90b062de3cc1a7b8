"""Where the balls sit on an arm: places on its surface, chosen for what is seen of them and for a transfer's bias.

    python -m viewimit.experiments.marker_layout panda assets/markers/panda.toml

A ball is seen where nothing of the arm and no nearer ball hides a part of it. Places are exchanged one by one, and an
exchange stays if the points that all four views see then serve the paper's transfer better, over demonstrators and
postures spread over the scene's range. The same seed gives the same layout.
"""

import sys
import tempfile
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray

from ..assets import ROOT
from ..camera import Camera
from ..evaluation import conflict, residual
from ..geometry.affine import MIN_POINTS
from ..landscape import Landscape
from ..markers import Markers
from ..physics.model import write_urdf
from ..physics.studio import SAMPLES, Studio
from ..robot import BodyPoints
from ..scene import load_scene
from ..transfer import TRANSFERS
from ..views import FourViews
from ..world import World

RADIUS_M = 0.02  # 8 px across at the arm's distance
BALLS = 24
PLACES = 70  # a link
A_LINK = 2  # balls on each, at least
APART_M = 2.5 * RADIUS_M  # on one link
GRID = (7, 10)  # postures a joint over the range
DEMONSTRATORS = (3, 4)  # of them, a joint
AROUND_DEG = 4.0  # of a demonstrator, where the parabola of E is taken
ENOUGH, LEAST = 14, 8  # points in all four views: wanted, and never fewer
FEW_COSTS_DEG, TOO_FEW_COST_DEG = 0.3, 2.0  # for each that lacks
ASTRAY_COSTS_DEG = 20.0  # times the share of postures from which descent ends elsewhere
TRANSFER = "epipolar"
EXCHANGES = 5000
BEHIND_M = 0.004  # that a surface may lie before the ball's own without hiding it


@dataclass(frozen=True)
class Sightings:
    """Of K places in G postures, in both views of a body: image (G, K, 4) px, depth_m and radius_px (G, K, 2),
    clear (G, K, 2): nothing of the arm is before it."""

    image: NDArray
    depth_m: NDArray
    radius_px: NDArray
    clear: NDArray

    def of(self, chosen: NDArray) -> tuple[NDArray, NDArray]:
        """Images (G, N, 4) and seen (G, N): in both views, no nearer ball of the chosen before it."""
        image = self.image[:, chosen].reshape(len(self.image), -1, 2, 2)
        apart = np.linalg.norm(image[:, :, None] - image[:, None], axis=-1)
        touch = apart < self.radius_px[:, chosen, None] + self.radius_px[:, None, chosen]
        nearer = self.depth_m[:, None, chosen] < self.depth_m[:, chosen, None]
        return self.image[:, chosen], (self.clear[:, chosen] & ~(touch & nearer).any(2)).all(-1)


def build(name: str, seed: int = 0) -> Markers:
    """Markers of a shipped robot, in the scene of its name."""
    rng = np.random.default_rng(seed)
    scene = load_scene(name)
    body = _places(name, rng)
    axes = [np.linspace(low, high, n) for low, high, n in zip(scene.lower, scene.upper, GRID)]
    grid = np.array(list(product(*axes)))
    spread = [axis[np.linspace(1, len(axis) - 2, n).round().astype(int)] for axis, n in zip(axes, DEMONSTRATORS)]
    demonstrators = np.array(list(product(*spread)))
    near = np.radians(AROUND_DEG) * np.array(list(product((-1, 0, 1), repeat=grid.shape[1])))
    around = np.clip(demonstrators[:, None] + near, scene.lower, scene.upper).reshape(-1, grid.shape[1])
    with tempfile.TemporaryDirectory() as folder:
        studio = Studio(scene, write_urdf(scene, Markers(RADIUS_M, ()), Path(folder)))
    world = World(scene, body=body)
    demo = _sightings(studio, world, demonstrators, True)
    own, close = (_sightings(studio, world, postures, False) for postures in (grid, around))
    chosen = _chosen(body, demo, own, close, near, rng)
    order = np.lexsort((chosen, body.link[chosen]))
    hues = 360 / BALLS * ((7 * np.arange(BALLS)) % BALLS)  # neighbours on the arm are far apart in hue
    rows = [(int(body.link[k]), *map(float, body.local[k].round(4)), float(hue)) for k, hue in zip(chosen[order], hues)]
    return Markers(RADIUS_M, tuple(rows))


def _places(name: str, rng: np.random.Generator) -> BodyPoints:
    """Middles of balls that touch the surface from outside."""
    shapes = trimesh.load(ROOT / "robots" / name / f"{name}.glb").geometry
    links, local = [], []
    for link in range(len(shapes)):
        mesh = shapes[f"link{link}"]
        points, faces = trimesh.sample.sample_surface(mesh, PLACES, seed=int(rng.integers(2**31)))
        links += [link] * len(points)
        local.append(points + RADIUS_M * mesh.face_normals[faces])
    return BodyPoints(np.array(links), np.concatenate(local))


def _sightings(studio: Studio, world: World, postures: NDArray, demo: bool) -> Sightings:
    scene_rest = world.scene.lower
    found = []
    for theta in postures:
        studio.pose(*((theta, scene_rest) if demo else (scene_rest, theta)))
        points = world.points_world(theta, world.T_world_demo if demo else world.T_world_own)
        cameras = world.demo_cameras if demo else world.own_cameras
        found.append([_sight(studio.depth_m(camera), camera, points) for camera in cameras])
    image, depth, radius, clear = (np.array([[side[k] for side in pair] for pair in found]) for k in range(4))
    image = np.moveaxis(image, 1, -2).reshape(len(postures), -1, 4)
    return Sightings(image, *(np.moveaxis(each, 1, -1) for each in (depth, radius, clear)))


def _sight(surface_m: NDArray, camera: Camera, points: NDArray) -> tuple[NDArray, NDArray, NDArray, NDArray]:
    """Of balls at (K, 3) m: image (K, 2), depth (K,), radius (K,) px, clear (K,)."""
    image, inside = camera.project(points.T)
    depth = (points - camera.T_world_camera[:3, 3]) @ camera.T_world_camera[:3, 2]
    radius = camera.focal * RADIUS_M / depth
    clear = inside.copy()
    for share, angle in product((0.0, 0.5, 0.9), np.arange(0, 2 * np.pi, np.pi / 4)):
        x, y = image + share * radius * np.array([[np.cos(angle)], [np.sin(angle)]])
        column = np.clip((SAMPLES * x).astype(int), 0, surface_m.shape[1] - 1)
        row = np.clip((SAMPLES * y).astype(int), 0, surface_m.shape[0] - 1)
        front = depth - RADIUS_M * np.sqrt(1 - share**2)
        clear &= surface_m[row, column] > front - BEHIND_M
    return image.T, depth, radius, clear


def _chosen(
    body: BodyPoints, demo: Sightings, own: Sightings, close: Sightings, near: NDArray, rng: np.random.Generator
) -> NDArray:
    often = own.clear.all(-1).mean(0)
    first = np.concatenate([np.flatnonzero(body.link == k)[np.argsort(-often[body.link == k])] for k in _links(body)])
    chosen = np.empty(0, int)
    for least in (A_LINK, BALLS):  # the most often seen of each link, then of all
        for place in first if least == A_LINK else first[np.argsort(-often[first])]:
            room = len(chosen) < BALLS and (body.link[chosen] == body.link[place]).sum() < least
            if room and _fits(body, np.append(chosen, place)):
                chosen = np.append(chosen, place)
    cost = _cost(demo, own, close, near, chosen)
    for _ in range(EXCHANGES):
        other = chosen.copy()
        other[rng.integers(BALLS)] = rng.integers(len(body))
        few = np.bincount(body.link[other], minlength=len(_links(body))).min() < A_LINK
        if few or not _fits(body, other):
            continue
        cost_other = _cost(demo, own, close, near, other)
        if cost_other < cost:
            chosen, cost = other, cost_other
    return chosen


def _links(body: BodyPoints) -> NDArray:
    return np.unique(body.link)


def _fits(body: BodyPoints, chosen: NDArray) -> bool:
    """Whether balls of one link keep apart."""
    same = np.triu(body.link[chosen, None] == body.link[None, chosen], 1)
    apart = np.linalg.norm(body.local[chosen, None] - body.local[None, chosen], axis=-1)
    return bool((apart[same] >= APART_M).all())


def _cost(demo: Sightings, own: Sightings, close: Sightings, near: NDArray, chosen: NDArray) -> float:
    """Degrees: rms bias of the minimum of E, and what too few points and other minima over the range count for."""
    (demo_image, demo_seen), (own_image, own_seen), (close_image, close_seen) = (
        each.of(chosen) for each in (demo, own, close)
    )
    usable = demo_seen[:, None] & own_seen
    count = usable.sum(-1)
    if count.min() < MIN_POINTS:
        return np.inf
    few = FEW_COSTS_DEG * np.maximum(ENOUGH - count, 0).mean() + TOO_FEW_COST_DEG * max(LEAST - count.min(), 0)
    biases, steps = [], len(near)
    for k in range(len(demo_image)):
        part = slice(k * steps, (k + 1) * steps)
        common = demo_seen[k] & close_seen[part].all(0)
        bias = np.inf
        if common.sum() >= LEAST:
            views = FourViews(demo_image[k][common], close_image[part][:, common], np.ones(1, bool))
            bias = _minimum_deg(np.degrees(near), conflict(residual(TRANSFERS[TRANSFER](views), views)))
        biases.append(min(bias, 2 * AROUND_DEG))
    E = _conflicts(demo_image[:, None], own_image[None], usable).reshape(-1, *GRID)
    axes = tuple(np.arange(n) for n in GRID)
    astray = np.mean([1 - Landscape(axes, each).basin_fraction() for each in E])
    return float(few + np.sqrt(np.mean(np.square(biases))) + ASTRAY_COSTS_DEG * astray)


def _conflicts(demo: NDArray, own: NDArray, usable: NDArray) -> NDArray:
    """E of the usable points, (D, G, N) bool, of images that broadcast to (D, G, N, 4).

    A point at the centroid in all views changes neither fit nor residual, only the count that E is a mean over.
    """
    count, weight = usable.sum(-1), usable[..., None]
    filled = []
    for images in np.broadcast_arrays(demo, own):
        centroid = (images * weight).sum(-2, keepdims=True) / count[..., None, None]
        filled.append(np.where(weight, images, centroid).reshape(-1, *images.shape[-2:]))
    views = FourViews(*filled, np.ones(1, bool))
    E = conflict(residual(TRANSFERS[TRANSFER](views), views)).reshape(count.shape)
    return E * usable.shape[-1] / count


def _minimum_deg(delta: NDArray, E: NDArray) -> float:
    """How far from 0 the minimum of the parabola through E at delta (S, 2) is; infinite if it opens downwards."""
    a, b = delta.T
    terms = np.stack([np.ones_like(a), a, b, a * a, a * b, b * b], -1)
    _, ga, gb, aa, ab, bb = np.linalg.lstsq(terms, E, rcond=None)[0]
    Q = np.array([[2 * aa, ab], [ab, 2 * bb]])
    if np.linalg.eigvalsh(Q)[0] <= 0:
        return np.inf
    return float(np.abs(np.linalg.solve(Q, [ga, gb])).max())


def text(markers: Markers) -> str:
    """As a TOML file."""
    rows = "".join(f"  [{', '.join(f'{number:g}' for number in ball)}],\n" for ball in markers.balls)
    what = "# [link, x, y, z, hue]: middle of a ball in its link's frame, metres, and its hue, degrees"
    return f"radius = {markers.radius:g}\n\n{what}\nballs = [\n{rows}]\n"


if __name__ == "__main__":
    Path(sys.argv[2]).write_text(text(build(sys.argv[1])))
