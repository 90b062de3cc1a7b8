"""Where the balls sit on an arm: chosen for what stays in sight, and for where the paper's E then has its minimum.

    python -m viewimit.assets.build_markers panda assets/markers/panda.toml 1
    python -m viewimit.assets.build_markers iiwa assets/markers/iiwa.toml 0

A ball is seen where nothing of the arm and no nearer ball hides a part of it. E is of the balls that all four views
see, others at every pair of postures, so that it is small wherever only the balls of one part are left: what counts
first is that of each part of the arm enough are seen in both postures. Each part has its share of the balls, larger
farther out, where fewer are seen. Balls change places within their part, one by one, by simulated annealing
(Kirkpatrick et al. 1983), first for that alone, then for E's minima too. The last number is the seed.
"""

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray

from ..analysis.landscape import Landscape
from ..estimation.transfers import TRANSFERS
from ..estimation.transfers.transfer import conflict
from ..estimation.views import FourViews
from ..geometry.affine import MIN_POINTS
from ..simulation.rendering import Studio
from ..simulation.robot import BodyPoints, Markers
from ..simulation.scene import load_scene
from ..simulation.world import World
from . import ROOT
from .sightings import Sightings, sightings

RADIUS_M = 0.02  # 6 to 9 px across
FIRST = (2, 4, 3, 3, 6, 6, 5, 7)  # balls a link to begin with
BALLS = sum(FIRST)
A_LINK = 2  # at least
APART_M = 2.5 * RADIUS_M  # on one link
PLACES, OFF_M = 250, (0.0, 0.03, 0.06)  # a link; from the surface to the ball
SEEN_OFTEN, BEST_PLACES = 0.25, 60  # share of postures; a link
GRID = (7, 10)  # postures a joint over the range
DEMONSTRATORS = (3, 4)  # of them, a joint
AROUND_DEG, WORST_DEG = 4.0, 8.0  # of a demonstrator, where the parabola of E is taken; a bias that is no worse
PARTS = np.array([0, 0, 1, 1, 2, 2, 3, 3])  # of links: base, upper arm, forearm, hand
WANTED, TWO = 4, 2  # balls of each part in all four views; few, but not none
FEWEST = MIN_POINTS + 1
TRANSFER = "epipolar"
UPHILL_MARGIN = 0.2  # of ln E from a posture to its neighbour towards the demonstrator, which is to be so much lower
COVER_COST, UPHILL_COST, ASTRAY_COST = 3.0, 60.0, 10.0  # degrees; with the bias's own
COVERING, REFINING = (3000, 0.02, 0.002), (5000, 0.3, 0.03)  # exchanges, first and last temperature


@dataclass(frozen=True)
class Study:
    """demo: (D postures), own: (the grid), close: (around each demonstrator, one after the other);
    at: (D,) demonstrators' places in the grid; near_deg: (S, 2), close's offsets."""

    body: BodyPoints
    demo: Sightings
    own: Sightings
    close: Sightings
    at: NDArray
    near_deg: NDArray


def build(name: str, seed: int) -> Markers:
    """Markers of a shipped robot, in the scene of its name."""
    rng = np.random.default_rng(seed)
    study = _study(name)
    chosen = _first(study, rng)
    chosen = _annealed(study, chosen, lambda balls: _cover_cost(study, balls)[0], *COVERING, rng)
    chosen = _annealed(study, chosen, lambda balls: _cost(study, balls), *REFINING, rng)
    body = study.body
    order = np.lexsort((chosen, body.link[chosen]))
    hues = 360 / BALLS * ((7 * np.arange(BALLS)) % BALLS)  # neighbours on the arm are far apart in hue
    rows = [(int(body.link[k]), *map(float, body.local[k].round(4)), float(hue)) for k, hue in zip(chosen[order], hues)]
    return Markers(RADIUS_M, tuple(rows))


def _study(name: str) -> Study:
    scene, body = load_scene(name), _places(name)
    axes = [np.linspace(low, high, n) for low, high, n in zip(scene.lower, scene.upper, GRID)]
    grid = np.array(list(product(*axes)))
    spread = [np.linspace(1, n - 2, count).round().astype(int) for n, count in zip(GRID, DEMONSTRATORS)]
    at = np.array([np.ravel_multi_index(place, GRID) for place in product(*spread)])
    near_deg = AROUND_DEG * np.array(list(product((-1, 0, 1), repeat=len(GRID))))
    around = np.clip(grid[at][:, None] + np.radians(near_deg), scene.lower, scene.upper).reshape(-1, len(GRID))
    world = World(scene, body=body)
    studio = Studio(world, Markers(RADIUS_M, ()))
    demo = sightings(studio, world, RADIUS_M, grid[at], True)
    own, close = (sightings(studio, world, RADIUS_M, postures, False) for postures in (grid, around))
    return Study(body, demo, own, close, at, near_deg)


def _places(name: str) -> BodyPoints:
    """Middles of balls outside the surface."""
    shapes = trimesh.load(ROOT / "robots" / name / f"{name}.glb").geometry
    links, local = [], []
    for off_m, link in product(OFF_M, range(len(shapes))):
        mesh = shapes[f"link{link}"]
        points, faces = trimesh.sample.sample_surface(mesh, PLACES, seed=len(links))
        links += [link] * len(points)
        local.append(points + (RADIUS_M + off_m) * mesh.face_normals[faces])
    return BodyPoints(np.array(links), np.concatenate(local))


def _often(study: Study) -> NDArray:
    """(K,) share of postures in which a place is in sight of both views."""
    return (study.own.clear.all(-1).mean(0) + study.demo.clear.all(-1).mean(0)) / 2


def _first(study: Study, rng: np.random.Generator) -> NDArray:
    """Of each link's places most often seen, some that keep apart."""
    often, chosen = _often(study), np.empty(0, int)
    for link, count in enumerate(FIRST):
        places = np.flatnonzero((study.body.link == link) & (often > SEEN_OFTEN))
        for place in rng.permutation(places[np.argsort(-often[places])][:BEST_PLACES]):
            if (study.body.link[chosen] == link).sum() < count and _fits(study.body, np.append(chosen, place)):
                chosen = np.append(chosen, place)
    pool = np.flatnonzero(often > SEEN_OFTEN)
    while len(chosen) < BALLS:
        place = rng.choice(pool)
        if place not in chosen and _fits(study.body, np.append(chosen, place)):
            chosen = np.append(chosen, place)
    return chosen


def _annealed(
    study: Study,
    chosen: NDArray,
    cost_of: Callable[[NDArray], float],
    exchanges: int,
    first: float,
    last: float,
    rng: np.random.Generator,
) -> NDArray:
    """The best that was met."""
    link = study.body.link
    pool = np.flatnonzero(_often(study) > SEEN_OFTEN)
    cost = cost_of(chosen)
    best, best_cost = chosen, cost
    for k in range(exchanges):
        other, ball = chosen.copy(), rng.integers(BALLS)
        kin = link if rng.random() < 0.6 else PARTS[link]
        other[ball] = rng.choice(pool[kin[pool] == kin[chosen[ball]]])
        few = np.bincount(link[other], minlength=len(FIRST)).min() < A_LINK
        if few or len(np.unique(other)) < BALLS or not _fits(study.body, other):
            continue
        cost_other, temperature = cost_of(other), first * (last / first) ** (k / exchanges)
        if cost_other < cost or rng.random() < np.exp((cost - cost_other) / temperature):
            chosen, cost = other, cost_other
            if cost < best_cost:
                best, best_cost = chosen, cost
    return best


def _fits(body: BodyPoints, chosen: NDArray) -> bool:
    """Whether balls of one link keep apart."""
    same = np.triu(body.link[chosen, None] == body.link[None, chosen], 1)
    apart = np.linalg.norm(body.local[chosen, None] - body.local[None, chosen], axis=-1)
    return bool((apart[same] >= APART_M).all())


def _cover_cost(study: Study, chosen: NDArray) -> tuple[float, NDArray]:
    """How little of each part is seen in both postures, at least -2 a part; and which balls are: (D, G, N)."""
    usable = study.demo.of(chosen)[1][:, None] & study.own.of(chosen)[1]
    part = PARTS[study.body.link[chosen]]
    count = np.stack([usable[..., part == k].sum(-1) for k in range(PARTS.max() + 1)])
    share = (np.minimum(count, WANTED) / WANTED).mean((1, 2)) + (count >= TWO).mean((1, 2))
    return -float(share.sum()), usable


def _cost(study: Study, chosen: NDArray) -> float:
    """Degrees: with the cover's, where E does not fall towards the demonstrator, and how far off its minimum is."""
    cover, usable = _cover_cost(study, chosen)
    blind = usable.sum(-1) < FEWEST
    images = study.demo.image[:, chosen][:, None], study.own.image[:, chosen][None]
    E = np.where(blind, np.nan, _conflicts(*images, usable | blind[..., None]))
    here = np.stack(np.unravel_index(np.arange(E.shape[1]), GRID), -1)
    towards = np.ravel_multi_index(tuple(np.moveaxis(here + np.sign(here[study.at][:, None] - here), -1, 0)), GRID)
    rise = np.nan_to_num(np.log(np.take_along_axis(E, towards, 1) / E), nan=1.0)
    elsewhere = np.arange(E.shape[1]) != study.at[:, None]
    uphill = np.where(elsewhere, np.clip(rise + UPHILL_MARGIN, 0, 1), 0).mean()
    axes = tuple(np.arange(n) for n in GRID)
    astray = np.mean([1 - Landscape(axes, each.reshape(GRID)).basin_fraction() for each in E])
    bias = np.sqrt(np.mean(np.square(_biases_deg(study, chosen))))
    return float(COVER_COST * cover + UPHILL_COST * uphill + ASTRAY_COST * astray + bias)


def _biases_deg(study: Study, chosen: NDArray) -> list[float]:
    """Of E's minimum near each demonstrator, by the balls seen all around it."""
    demo, demo_seen = study.demo.of(chosen)
    close, close_seen = study.close.of(chosen)
    biases, steps = [], len(study.near_deg)
    for k in range(len(demo)):
        part = slice(k * steps, (k + 1) * steps)
        common = demo_seen[k] & close_seen[part].all(0)
        bias = np.inf
        if common.sum() >= FEWEST:
            views = FourViews(demo[k][common], close[part][:, common], np.ones(1, bool))
            bias = _minimum_deg(study.near_deg, conflict(TRANSFERS[TRANSFER](views).residual(views)))
        biases.append(min(bias, WORST_DEG))
    return biases


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
    E = conflict(TRANSFERS[TRANSFER](views).residual(views)).reshape(count.shape)
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


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("robot", choices=("panda", "iiwa"))
    parser.add_argument("file", type=Path, help="TOML to write")
    parser.add_argument("seed", type=int)
    args = parser.parse_args()
    args.file.write_text(text(build(args.robot, args.seed)))


if __name__ == "__main__":
    main()
