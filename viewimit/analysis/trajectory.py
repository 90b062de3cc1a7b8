"""Motions of the demonstrator, and their imitation with a frozen transfer (Section 5.4 of the paper).

    demonstrator's frame → frozen transfer → target points → image-based servoing → next posture

The demonstrator's images are recorded first, so that the learner aims at where the points will be, not where they were.
A learner sees images and its own displacements only. Everything else recorded here is for people.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import msgspec
import numpy as np
from numpy.typing import NDArray

from ..estimation.transfers import FittedTransfer
from ..geometry.arrays import Floats
from ..loop.session import Session
from ..loop.settings import Settings
from ..loop.simulated_robot import observed_images
from ..sensing.files import MEGABYTE, read_bytes
from ..servo import Observation
from ..servo.image_jacobian import BroydenModel
from ..simulation.scene import Scene
from ..simulation.world import World, hand_jacobian, hand_position, pose_for_hand

FRAMES, STEP_S = 120, 0.05  # of a built-in motion
SWING_DEG = 15.0  # amplitude of the sinusoid, each joint
RADIUS_M = 0.08  # of the hand's circle
MAX_FRAMES = 5_000
MAX_FILE_BYTES = 16 * MEGABYTE
MAX_NAME_LENGTH = 200
FORMAT = "viewimit motion 1"

MAX_APPROACH_STEPS = 20  # to the first frame; then one step for each frame
APPROACH_END_RAD = np.radians(0.05)  # a smaller step ends the approach
MIN_HAND_POINTS = 3
DEMO_FRAMES, OWN_FRAMES = 2, 3  # streams of the seed


class Motion(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, omit_defaults=False):
    """A motion of the demonstrator, saved as JSON."""

    format: str = FORMAT
    name: Annotated[str, msgspec.Meta(max_length=MAX_NAME_LENGTH)]
    joints: tuple[int, ...]  # numbers of the moving joints, from 1
    step_s: float = STEP_S  # time from frame to frame
    theta_deg: tuple[tuple[float, ...], ...]  # a posture of the moving joints for each frame

    @property
    def theta(self) -> Floats:
        """(T, m) rad."""
        return np.radians(self.theta_deg).reshape(len(self.theta_deg), len(self.joints))

    @property
    def seconds(self) -> float:
        """Duration."""
        return self.step_s * max(len(self.theta_deg) - 1, 0)


def make_motion(name: str, scene: Scene, theta: Floats, step_s: float = STEP_S) -> Motion:
    """Make a motion of postures theta, (T, m) rad. Raises ValueError as `require_motion`."""
    rows = tuple(tuple(row) for row in np.round(np.degrees(theta), 6).tolist())
    made = Motion(name=name, joints=scene.moving_joints, step_s=step_s, theta_deg=rows)
    require_motion(made, scene)
    return made


def sinusoid(world: World, theta: Floats, frames: int = FRAMES) -> Motion:
    """Swing joint k for k periods about theta, (m,) rad, or about the nearest posture within the limits."""
    scene, (low, high) = world.scene, (world.scene.lower, world.scene.upper)
    swing = np.minimum(np.radians(SWING_DEG), (high - low) / 2)
    centre = np.clip(theta, low + swing, high - swing)
    phase = np.linspace(0, 2 * np.pi, frames)[:, None] * np.arange(1, len(centre) + 1)
    return make_motion("sinusoid", scene, centre + swing * np.sin(phase))


def hand_circle(world: World, theta: Floats, frames: int = FRAMES) -> Motion:
    """Move the hand on a circle from theta, (m,) rad, in the plane in which it moves most easily, towards the base."""
    base, here = world.T_world_demo, hand_position(world, theta, world.T_world_demo)
    axes, _, _ = np.linalg.svd(hand_jacobian(world, theta, base))
    inward = axes[:, 0] * np.sign(axes[:, 0] @ (base[:3, 3] - here) or 1.0)
    postures = []
    for angle in np.linspace(0, 2 * np.pi, frames):
        target = here + RADIUS_M * ((1 - np.cos(angle)) * inward + np.sin(angle) * axes[:, 1])
        theta = pose_for_hand(world, target, theta)
        postures.append(theta)
    return make_motion("circle of the hand", world.scene, np.array(postures))


MOTIONS = {"sinusoid": sinusoid, "circle": hand_circle}


def load_motion(path: str | Path, scene: Scene) -> Motion:
    """Read JSON. Raises OSError, or ValueError that names the file and its fault."""
    try:
        return decode_motion(read_bytes(Path(path), MAX_FILE_BYTES), scene)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None


def encode_motion(saved: Motion) -> bytes:
    return msgspec.json.format(msgspec.json.encode(saved), indent=1)


def decode_motion(data: bytes, scene: Scene) -> Motion:
    """Decode JSON. Raises ValueError if it is no motion, or not one of this scene."""
    if not data.strip():
        raise ValueError("not a recorded motion: the file is empty")
    try:
        found = msgspec.json.decode(data, type=Motion)
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"not a recorded motion: {error}") from None
    require_motion(found, scene)
    return found


def require_motion(motion: Motion, scene: Scene) -> None:
    """Raise ValueError unless every frame is a posture of this scene."""
    listed = lambda joints: ", ".join(map(str, joints))
    if motion.format != FORMAT:
        raise ValueError(f"format {motion.format[:40]!r} is not {FORMAT!r}")
    if motion.joints != scene.moving_joints:
        raise ValueError(
            f"it moves joints {listed(motion.joints)}, but in this scene joints {listed(scene.moving_joints)} move"
        )
    if not 2 <= len(motion.theta_deg) <= MAX_FRAMES:
        raise ValueError(f"a motion has 2 to {MAX_FRAMES} frames, this one {len(motion.theta_deg)}")
    if not 0.001 <= motion.step_s <= 10:
        raise ValueError(f"step_s must be between 0.001 and 10 s, got {motion.step_s:g}")
    for k, posture in enumerate(motion.theta_deg):
        scene.require_posture(np.radians(posture), f"frame {k}, demonstrator's")


@dataclass(frozen=True)
class Trajectory:
    """An imitated motion of T frames. Only `target` and `own` are known to the learner."""

    theta_demo: Floats  # (T, m) rad
    theta: Floats  # (T, m) rad
    followed: NDArray[np.bool_]  # (N,) which points are followed
    target: Floats  # (T, N, 4) px of [L, R]: transferred points
    own: Floats  # (T, N, 4) px: the learner's own points
    desired: Floats  # (T, N, 4) px: the own points in the demonstrator's posture
    hand_m: Floats  # (T,) distance of the hands, each from its base

    @property
    def image_px(self) -> Floats:
        """(T,) mean distance from the desired points, over both images."""
        return _mean_distance(self.own - self.desired, self.followed)

    @property
    def target_px(self) -> Floats:
        """(T,) mean distance from the transferred points: the part of its error that the learner can see."""
        return _mean_distance(self.own - self.target, self.followed)

    @property
    def joint_deg(self) -> Floats:
        """(T,) largest joint error."""
        return np.degrees(np.abs(self.theta - self.theta_demo)).max(-1)


@dataclass(frozen=True)
class Imitation:
    """An imitated motion to be played back."""

    name: str
    settings: Settings
    transfer: FittedTransfer  # frozen during the motion
    step_s: float
    theta_demo: Floats  # (T, m) rad
    theta: Floats  # (T, m) rad


def hand_points(session: Session) -> NDArray[np.bool_]:
    """Select the points of the outermost links, at least MIN_HAND_POINTS: (N,)."""
    link = session.world.body.link
    return link >= np.sort(link)[-MIN_HAND_POINTS]


def learned_images(session: Session) -> BroydenModel:
    """Fit the image model to all motions so far, of any servo."""
    first, *later = session.history[: session.cursor + 1]
    model = BroydenModel.start(session.observation(first))
    for moment in later:
        model = model.update(session.observation(moment))
    return model


def follow(
    session: Session,
    transfer: FittedTransfer,
    motion: Motion,
    followed: NDArray[np.bool_],
    tell: Callable[[float], None] = lambda share: None,
) -> Trajectory:
    """Imitate a motion with a frozen transfer, from the session's present posture. The session does not change.

    followed: (N,) bool, the points that image-based servoing takes to their targets; tell: receives the share done
    after each frame.
    """
    settings, world, eyes = session.settings, session.world, session.eyes
    (low, high), max_step = session.workspace, settings.max_step
    start, model, n_motions = settings.start_rad, learned_images(session), 0
    theta, sent = session.snapshot.theta, session.snapshot.commanded

    def look() -> Observation:
        own, visible = observed_images(settings, eyes.own_images(theta), OWN_FRAMES, n_motions)
        return Observation(own, visible, np.nan, sent - start, low - start, high - start, n_motions, max_step=max_step)

    seen, frames = look(), []
    for frame, theta_demo in enumerate(motion.theta):
        demo, visible = observed_images(settings, eyes.demo_images(theta_demo), DEMO_FRAMES, frame)
        target = transfer.recover(demo[:, :2], demo[:, 2:])
        for _ in range(1 if frame else MAX_APPROACH_STEPS):
            step = model.step_towards(seen, target, followed & visible.all(-1))
            commanded = np.clip(sent + step, low, high)
            theta, sent = session.embodiment.drive(settings, theta, sent, commanded), commanded
            n_motions += 1
            seen = look()
            model = model.update(seen)
            if np.max(np.abs(step)) < APPROACH_END_RAD:
                break
        hands = [hand_position(world, posture, world.T_world_own) for posture in (theta, theta_demo)]
        desired, _ = world.own_images(theta_demo)
        frames.append((theta_demo, theta, target, seen.own, desired, np.linalg.norm(hands[0] - hands[1])))
        tell((frame + 1) / len(motion.theta))
    theta_demos, thetas, targets, owns, desireds, hand_m = map(np.array, zip(*frames))
    return Trajectory(theta_demos, thetas, followed, targets, owns, desireds, hand_m)


def _mean_distance(difference: NDArray, followed: NDArray) -> NDArray:
    """(T, N, 4) px → (T,)"""
    both = difference[:, followed].reshape(len(difference), -1, 2)
    return np.sqrt((both * both).sum(-1)).mean(-1)
