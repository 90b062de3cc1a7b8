"""A circle of the demonstrator's hand, imitated by a transfer that was frozen: where the postures agree, and too early.
The hand is the origin of the last link. It wears no mark, but a transfer maps any point that [l] and [r] can show."""

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from viewimit.analysis.trajectory import Trajectory, follow, hand_circle, hand_points
from viewimit.loop.snapshot import Snapshot
from viewimit.simulation.camera import Cameras
from viewimit.simulation.world import World

from .records import plain
from .situation import Situation

Array = NDArray[np.float64]
CIRCLE_FRAMES = 25  # one more than motions that are played
MAX_MOTIONS = 100  # until the postures agree
FORWARD_UP = [0, 2]  # axes of a base: the plane in which both joints turn the arm
SAME_SHARE = 0.25  # of the circle's radius: a hand that stays as near draws the circle itself
DRAWS = ("the circle", "a loop elsewhere", "no loop")
LOOP_SHARE = 0.5  # breadth over length, from which a path is a loop


@dataclass(frozen=True, eq=False)
class Followed:
    """A motion that was followed with one frozen transfer, over T frames; k links."""

    frozen: Snapshot  # to which the transfer was fitted
    run: Trajectory
    overlap_px: Array  # (T,) from the hand to its target, mean of L and R
    truth_px: Array  # (T,) from the hand to its true place, mean of L and R
    side: Array  # (T, k, 2) m: the learner's links from the side, base at 0
    demo_side: Array  # (T, k, 2) m: the demonstrator's

    @property
    def hand_mm(self) -> float:
        """Median distance of the hands, each from its base."""
        return 1e3 * float(np.median(self.run.hand_m))

    @property
    def radius_m(self) -> float:
        """Radius of the demonstrator's circle."""
        hand = self.demo_side[:-1, -1]
        return float(np.linalg.norm(hand - hand.mean(0), axis=1).mean())

    @property
    def loop_m(self) -> Array:
        """(2,) length and breadth of the ellipse that has the second moments of the hand's path."""
        hand = self.side[:-1, -1]
        return 2 * np.linalg.svd(hand - hand.mean(0), compute_uv=False) * np.sqrt(2 / len(hand))

    @property
    def draws(self) -> str:
        """What the hand draws, of DRAWS."""
        away = np.linalg.norm(self.side[:, -1] - self.demo_side[:, -1], axis=1)
        if away.max() < SAME_SHARE * self.radius_m:
            return DRAWS[0]
        (long, broad), between = self.loop_m, self.side[:, -1].mean(0) - self.demo_side[:, -1].mean(0)
        return DRAWS[1] if broad > LOOP_SHARE * long and np.linalg.norm(between) > self.radius_m else DRAWS[2]


@dataclass(frozen=True, eq=False)
class CircleRuns:
    """The circle with both transfers."""

    right: Followed  # frozen where the postures agree
    early: Followed  # frozen at the step's start
    mm_per_px: float  # across the view, at the hand's depth in L


@cache
def follow_circle(situation: Situation) -> CircleRuns:
    """Follow the circle with both transfers. Raises ValueError if too few points are seen to fit one."""
    session = situation.session()
    first = session.snapshot
    last = session.run(MAX_MOTIONS, patience=1).last
    motion, points = hand_circle(session.world, last.theta_demo, CIRCLE_FRAMES), hand_points(session)

    def followed(frozen: Snapshot) -> Followed:
        if frozen.transfer is None:
            raise ValueError("too few points are seen in all four images to fit a transfer")
        return _followed(session.world, frozen, follow(session, frozen.transfer, motion, points))

    hand = session.world.link_frames(last.theta_demo, session.world.T_world_own)[-1:, :3, 3]
    depth = float(session.world.own_pair.images(hand)[1][0, 0])
    return CircleRuns(followed(last), followed(first), 1e3 * depth / session.world.own_cameras[0].lens.focal[0])


def circle_record(situation: Situation) -> dict[str, Any]:
    """Postures of both arms and where the transfers were frozen, rad, as the page has them."""
    made = follow_circle(situation)
    told = lambda one: {"frozen": plain(one.frozen.theta, 8), "postures": plain(one.run.theta, 6)}
    demonstrator = plain(made.right.run.theta_demo, 6)
    return {"demonstrator": demonstrator, "right": told(made.right), "early": told(made.early)}


def _followed(world: World, frozen: Snapshot, run: Trajectory) -> Followed:
    assert frozen.transfer is not None
    own, truth = (_links(world, theta, world.T_world_own, world.own_pair) for theta in (run.theta, run.theta_demo))
    demo = _links(world, run.theta_demo, world.T_world_demo, world.demo_pair)[:, :, -1]
    target = frozen.transfer.recover(demo[:, 0], demo[:, 1]).reshape(-1, 2, 2)
    off = lambda place: np.linalg.norm(own[:, :, -1] - place, axis=-1).mean(-1)
    return Followed(
        frozen, run, overlap_px=off(target), truth_px=off(truth[:, :, -1]),
        side=_from_side(world, run.theta), demo_side=_from_side(world, run.theta_demo),
    )  # fmt: skip


def _links(world: World, postures: Array, T_world_base: Array, pair: Cameras) -> Array:
    """(T, m) rad -> (T, 2, k, 2) px in both images of a pair: the origins of all links."""
    return np.array([pair.images(world.link_frames(theta, T_world_base)[:, :3, 3])[0] for theta in postures])


def _from_side(world: World, postures: Array) -> Array:
    """(T, m) rad -> (T, k, 2) m"""
    return np.array([world.link_frames(theta, np.eye(4))[:, FORWARD_UP, 3] for theta in postures])
