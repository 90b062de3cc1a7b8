"""Trajectory imitation, Section 5.4: a frozen transfer carries the demonstrator's motion into the own views.

    demonstrator's frame → frozen transfer → target points → image-based servoing → next posture

The demonstrator's images are stored first, so that the learner aims at where the points are to be and not at where they
were. It knows its own displacements and images, nothing else; what else is kept here is for people.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..estimation.transfers import FittedTransfer
from ..loop.session import Session
from ..loop.settings import Settings
from ..loop.simulated_robot import average_frames
from ..servo import Observation
from ..servo.image_based import towards
from ..servo.image_model import ImageModel
from ..simulation.world import hand_position
from .motion import Motion

APPROACH = 20  # motions at most to the first frame; then one a frame
ARRIVED = np.radians(0.05)  # a smaller motion ends the approach
HAND_POINTS = 3
DEMO_FRAMES, OWN_FRAMES = 2, 3  # streams of the seed


@dataclass(frozen=True)
class Trajectory:
    """T frames. theta_demo, theta: (T, m) rad; wanted: (N,) bool, the points followed; px of [L, R] in (T, N, 4):
    target recovered, own seen, desired what the own images show in the demonstrator's posture; hand_m: (T,) distance
    of the hands, each from its base. Only target and own are known to the learner.
    """

    theta_demo: NDArray
    theta: NDArray
    wanted: NDArray
    target: NDArray
    own: NDArray
    desired: NDArray
    hand_m: NDArray

    @property
    def image_px(self) -> NDArray:
        """(T,) mean distance from the desired points, over both images."""
        return _distance(self.own - self.desired, self.wanted)

    @property
    def target_px(self) -> NDArray:
        """(T,) mean distance from the recovered points: all that the learner itself can see of its error."""
        return _distance(self.own - self.target, self.wanted)

    @property
    def joint_deg(self) -> NDArray:
        """(T,) largest joint error."""
        return np.degrees(np.abs(self.theta - self.theta_demo)).max(-1)


@dataclass(frozen=True)
class Imitation:
    """A motion as it was imitated, to be seen: theta_demo, theta: (T, m) rad; transfer: that stayed as it was."""

    name: str
    settings: Settings
    transfer: FittedTransfer
    step_s: float
    theta_demo: NDArray
    theta: NDArray


def hand_points(session: Session) -> NDArray:
    """(N,) bool: the points of the outermost links, at least three."""
    link = session.world.body.link
    return link >= np.sort(link)[-HAND_POINTS]


def learned_images(session: Session) -> ImageModel:
    """What all motions up to now have taught of the own images, whichever servo made them."""
    first, *later = session.history[: session.cursor + 1]
    model = ImageModel.start(session.observation(first))
    for moment in later:
        model = model.learn(session.observation(moment))
    return model


def follow(
    session: Session, transfer, motion: Motion, wanted: NDArray, tell: Callable[[float], None] = lambda share: None
) -> Trajectory:
    """The session's learner, from where it is, by a transfer that stays as it is. wanted: (N,) bool.

    The session itself stays as it is, too. tell: the share done.
    """
    settings, world, eyes = session.settings, session.world, session.eyes
    (low, high), longest = session.workspace, settings.max_step
    start, model, moved = settings.start_rad, learned_images(session), 0
    theta, sent = session.snapshot.theta, session.snapshot.commanded

    def look() -> Observation:
        own, visible = average_frames(settings, eyes.own_images(theta), OWN_FRAMES, moved)
        return Observation(own, visible, np.nan, sent - start, low - start, high - start, moved, max_step=longest)

    seen, frames = look(), []
    for frame, theta_demo in enumerate(motion.theta):
        demo, visible = average_frames(settings, eyes.demo_images(theta_demo), DEMO_FRAMES, frame)
        target = transfer.recover(demo[:, :2], demo[:, 2:])
        for _ in range(1 if frame else APPROACH):
            step = towards(model, seen, target, wanted & visible.all(-1))
            commanded = np.clip(sent + step, low, high)
            theta, sent, moved = eyes.drive(settings, theta, sent, commanded), commanded, moved + 1
            seen = look()
            model = model.learn(seen)
            if np.max(np.abs(step)) < ARRIVED:
                break
        hands = [hand_position(world, posture, world.T_world_own) for posture in (theta, theta_demo)]
        desired, _ = world.own_images(theta_demo)
        frames.append((theta_demo, theta, target, seen.own, desired, np.linalg.norm(hands[0] - hands[1])))
        tell((frame + 1) / len(motion.theta))
    theta_demos, thetas, targets, owns, desireds, hand_m = map(np.array, zip(*frames))
    return Trajectory(theta_demos, thetas, wanted, targets, owns, desireds, hand_m)


def _distance(difference: NDArray, wanted: NDArray) -> NDArray:
    """(T, N, 4) px → (T,)"""
    both = difference[:, wanted].reshape(len(difference), -1, 2)
    return np.sqrt((both * both).sum(-1)).mean(-1)
