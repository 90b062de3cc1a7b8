"""Of the step about too few points: the landscape of E with all matches, with fewer, down to four, and with all of them
nearly in one plane."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from viewimit.analysis.landscape import Landscape, conflict_of_images, grid_axes
from viewimit.estimation.transfers import epipolar
from viewimit.estimation.transfers.epipolar import EpipolarTransfer
from viewimit.estimation.views import FourViews
from viewimit.geometry.affine import MIN_POINTS, centred
from viewimit.simulation.robot import BodyPoints
from viewimit.simulation.world import World

from .work import Task, Work

FEWEST = 4
STEP_DEG = 1.5
LEFT = 0.1  # of the points' distances from the plane: exactly in it, rounding errors would shape the landscape


@dataclass(frozen=True, eq=False)
class Matches:
    """order: (N,) indices of the points as they are added, the four best first; by_count: landscapes of the first 4, 5,
    … N of them; plane: of all, pressed towards the plane in which the arm moves. With conditions, but for four."""

    order: NDArray
    by_count: Mapping[int, Landscape]
    plane: Landscape


def _matches(task: Task) -> Matches | None:
    """None unless two joints move and five points are seen."""
    world, moment = task.world, task.snapshot
    if len(world.scene.moving_joints) != 2 or moment.transfer is None:
        return None
    seen = np.flatnonzero(moment.usable)
    order = seen[best_order(moment.views.demo[seen])]
    counts = range(FEWEST, len(order) + 1)
    flat = World(world.scene, body=pressed(world, moment.theta_demo))
    return Matches(
        order,
        {count: landscape_of(world, moment.theta_demo, order[:count]) for count in counts},
        landscape_of(flat, moment.theta_demo, order),
    )


def best_order(stereo: NDArray) -> NDArray:
    """stereo: (N, 4) px in [l, r] → (N,) the four points whose shape is the least flat, by the third singular value,
    then one after the other whichever makes it least flat."""

    def depth(chosen: tuple[int, ...]) -> float:
        return float(np.linalg.svd(centred(stereo[list(chosen)])[1], compute_uv=False)[2])

    chosen = max(combinations(range(len(stereo)), FEWEST), key=depth)
    while len(chosen) < len(stereo):
        left = (k for k in range(len(stereo)) if k not in chosen)
        chosen = max(((*chosen, k) for k in left), key=depth)
    return np.array(chosen)


def landscape_of(world: World, theta_demo: NDArray, points: NDArray) -> Landscape:
    """E of the paper's transfer with some of the points only: (k,) indices, k ≥ 4."""
    axes = grid_axes(world, STEP_DEG)
    demo, demo_visible = world.demo_images(theta_demo)
    own, own_visible = world.own_images((axes[0][:, None], axes[1]))
    demo, demo_visible, own, own_visible = (
        demo[points],
        demo_visible[points],
        own[..., points, :],
        own_visible[..., points, :],
    )
    if len(points) >= MIN_POINTS:
        return Landscape(axes, *conflict_of_images(epipolar.fit, demo, demo_visible, own, own_visible, True))
    shape = own.shape[:-2]
    views = FourViews(demo, own.reshape((-1,) + own.shape[-2:]), np.ones(1, bool))
    E = np.asarray(fit_any(views).conflict(views)).reshape(shape)
    return Landscape(axes, np.where(own_visible.all((-2, -1)) & demo_visible.all(), E, np.nan))


def fit_any(views: FourViews) -> EpipolarTransfer:
    """As `epipolar.fit`, of four points too, which it refuses: their fundamental matrices fit exactly, whatever the
    images are."""
    demo_mean, demo = centred(views.demo)
    own_mean, own = centred(views.own)
    batch = own.shape[:-2]
    f = epipolar.constraints(demo, own)
    matrix = epipolar.solve(f).transpose(2, 0, 1).reshape(batch + (4, 4))
    return EpipolarTransfer(matrix, demo_mean, own_mean, f.reshape((4, 5) + batch))


def pressed(world: World, theta: NDArray, left: float = LEFT) -> BodyPoints:
    """The world's points, moved on their links towards the plane through their middle in which the arm moves, so that
    this share of their distances is left: where its moving joints turn about one direction they stay as near to a
    plane. theta: (m,) rad, at which they are moved."""
    frames = world.link_frames(theta, world.T_world_demo)
    axes = np.array([frames[k + 1, :3, :3] @ world.robot.joints[k].axis for k in world.scene.moving])
    normal = (axes * np.where(axes @ axes[0] < 0, -1.0, 1.0)[:, None]).sum(0)
    normal /= np.linalg.norm(normal)
    points = world.points_world(theta, world.T_world_demo)
    flat = points - (1 - left) * ((points - points.mean(0)) @ normal)[:, None] * normal
    T_world_link = frames[world.body.link]
    local = np.einsum("nji,nj->ni", T_world_link[:, :3, :3], flat - T_world_link[:, :3, 3])
    return BodyPoints(world.body.link, local)


WORKS: Mapping[str, Work] = {"matches": Work(_matches)}
