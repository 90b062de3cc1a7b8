"""What body points tell of the joints, and which further point would tell most: for whoever places them.

From exact images, with both arms in the demonstrator's posture. The truth, for people: no learner sees any of it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..geometry.affine import MIN_POINTS, flatness
from ..loop.snapshot import Snapshot
from ..simulation.robot import BodyPoints
from ..simulation.world import World
from .observability import joint_uncertainty, untold_joints


@dataclass(frozen=True, eq=False)
class PointInformation:
    """count, seen: how many points there are, and how many of them are in all four images; spread: (m,) rad/px, what a
    pixel of noise costs at each joint, None with too few points; flatness: σ1/σ3 of the demonstrator's in [l, r]."""

    count: int
    seen: int
    spread: NDArray | None
    flatness: float

    @property
    def untold(self) -> list[int]:
        """Indices of the joints that are not told, the worst first; none where too few points are seen to ask."""
        return [] if self.spread is None else untold_joints(self.spread)


@dataclass(frozen=True, eq=False)
class Proposal:
    """point: a single one; before, after: what the points tell without it, and with it."""

    point: BodyPoints
    before: PointInformation
    after: PointInformation


def point_information(world: World, moment: Snapshot) -> PointInformation:
    """Of the world's points, by the moment's transfer, with its demonstrator's posture."""
    theta = moment.theta_demo
    demo, visible = world.demo_images(theta)
    usable = visible.all(-1) & world.own_images(theta)[1].all(-1)
    enough = usable.sum() >= MIN_POINTS
    spread = joint_uncertainty(world, moment.fit, demo, visible, theta) if enough else None
    flat = flatness(demo[usable]) if enough else np.inf
    return PointInformation(len(world.body), int(usable.sum()), spread, flat)


def best_next(world: World, moment: Snapshot, candidates: BodyPoints) -> Proposal:
    """The one of the candidates with which the joint that costs most costs least, and then the next.

    Where too few points are seen for any cost, the one that is farthest from all others. Raises ValueError without
    candidates.
    """
    if not len(candidates):
        raise ValueError("no place on the arm is seen in all four images in this posture: pose the demonstrator anew")
    before = point_information(world, moment)
    apart = _apart(world, candidates, moment.theta_demo)
    found = [point_information(with_point(world, candidates, k), moment) for k in range(len(candidates))]
    best = min(range(len(candidates)), key=lambda k: (_costs(found[k]), -apart[k]))
    return Proposal(BodyPoints(candidates.link[[best]], candidates.local[[best]]), before, found[best])


def with_point(world: World, points: BodyPoints, k: int) -> World:
    """The same world with another body point, the k-th of these."""
    body = world.body
    link, local = np.append(body.link, points.link[k]), np.concatenate([body.local, points.local[[k]]])
    return World(world.scene, robot=world.robot, body=BodyPoints(link, local))


def _costs(information: PointInformation) -> tuple[float, ...]:
    """The largest first."""
    return () if information.spread is None else tuple(sorted(information.spread.tolist(), reverse=True))


def _apart(world: World, candidates: BodyPoints, theta: NDArray) -> NDArray:
    """(K,) m from each candidate to the nearest body point, in this posture."""
    frames = world.link_frames(theta, np.eye(4))
    T = frames[candidates.link]
    places = np.einsum("kij,kj->ki", T[:, :3, :3], candidates.local) + T[:, :3, 3]
    points = world.points_world(theta, np.eye(4))
    return np.linalg.norm(places[:, None] - points, axis=-1).min(1, initial=np.inf)
