"""A geometry that stays as it was carries a circle of the demonstrator's hand over: frozen where the postures agree,
and frozen at the step's start.

The hand is the origin of the last link. It wears no mark, but a geometry carries any point over that l and r can show.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from viewimit.analysis.trajectory import Trajectory, follow, hand_circle, hand_points
from viewimit.loop.snapshot import Snapshot
from viewimit.simulation.camera import Cameras
from viewimit.simulation.world import World

from .work import Task, Work

FRAMES = 25  # of the circle: one more than motions that are played
MOST_MOTIONS = 100  # until the postures agree
UPRIGHT = [0, 2]  # of a base's axes: forward and up, the plane in which both joints turn the arm


@dataclass(frozen=True, eq=False)
class Followed:
    """By one geometry. frozen: what was seen when it was; run: what came of it; arms: (T, 2, k, 2) px in L, R, from the
    base to the hand; target: (T, 2, 2) px in L, R, where the geometry says that the hand should be, truth: where it
    would be in the demonstrator's posture; side: (T, k, 2) m, the arm from the side, base at 0; demo_side: the
    demonstrator's."""

    frozen: Snapshot
    run: Trajectory
    arms: NDArray
    target: NDArray
    truth: NDArray
    side: NDArray
    demo_side: NDArray

    @property
    def hand(self) -> NDArray:
        """(T, 2, 2) px in L, R"""
        return self.arms[:, :, -1]

    @property
    def overlap_px(self) -> NDArray:
        """(T,) from where the geometry says that the hand should be, mean of L and R."""
        return np.linalg.norm(self.hand - self.target, axis=-1).mean(-1)

    @property
    def truth_px(self) -> NDArray:
        """(T,) from where the hand would be in the demonstrator's posture."""
        return np.linalg.norm(self.hand - self.truth, axis=-1).mean(-1)


@dataclass(frozen=True, eq=False)
class Carried:
    """right: frozen where the postures agree, early: at the start. mm_a_px: what one pixel across is at the hand."""

    right: Followed
    early: Followed
    mm_a_px: float


def _carried(task: Task) -> Carried:
    """Raises ValueError if too few points are seen to fit a geometry."""
    session = task.session()
    first = session.snapshot
    last = session.run(MOST_MOTIONS, patience=1).last
    if first.transfer is None or last.transfer is None:
        raise ValueError("too few points are seen in all four images to fit a geometry")
    motion = hand_circle(session.world, last.theta_demo, FRAMES)
    wanted = hand_points(session)
    trajectories = (follow(session, transfer, motion, wanted) for transfer in (last.transfer, first.transfer))
    right, early = (_followed(session.world, *made) for made in zip((last, first), trajectories))
    return Carried(right, early, _mm_a_px(session.world, last.theta_demo))


def _followed(world: World, frozen: Snapshot, run: Trajectory) -> Followed:
    arms, truth = (
        _arms(world, postures, world.T_world_own, world.own_pair) for postures in (run.theta, run.theta_demo)
    )
    demo = _arms(world, run.theta_demo, world.T_world_demo, world.demo_pair)[:, :, -1]
    assert frozen.transfer is not None
    target = frozen.transfer.recover(demo[:, 0], demo[:, 1]).reshape(-1, 2, 2)
    side, demo_side = _from_side(world, run.theta), _from_side(world, run.theta_demo)
    return Followed(frozen, run, arms, target, truth[:, :, -1], side, demo_side)


def _arms(world: World, postures: NDArray, T_world_base: NDArray, pair: Cameras) -> NDArray:
    """postures: (T, m) rad → (T, 2, k, 2) px in both images of a pair: all links' origins."""
    return np.array([pair.images(world.link_frames(theta, T_world_base)[:, :3, 3])[0] for theta in postures])


def _from_side(world: World, postures: NDArray) -> NDArray:
    """postures: (T, m) rad → (T, k, 2) m"""
    return np.array([world.link_frames(theta, np.eye(4))[:, UPRIGHT, 3] for theta in postures])


def _mm_a_px(world: World, theta: NDArray) -> float:
    """Across, at the hand's depth in L."""
    hand = world.link_frames(theta, world.T_world_own)[-1:, :3, 3]
    depth = float(world.own_pair.images(hand)[1][0, 0])
    return 1e3 * depth / world.own_cameras[0].lens.focal[0]


WORKS: Mapping[str, Work] = {"carried": Work(_carried, "entered", played=True)}
