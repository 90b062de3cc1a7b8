"""Motions of the demonstrator: made up or recorded, kept as JSON. Only its images reach a learner."""

from pathlib import Path
from typing import Annotated

import msgspec
import numpy as np
from numpy.typing import NDArray

from ..sensing.files import MEGABYTE, read_bytes
from ..simulation.scene import Scene
from ..simulation.world import World, hand_jacobian, hand_position, pose_for_hand

FRAMES, STEP_S = 120, 0.05
SWING_DEG = 15.0  # of the sinusoid, each joint
RADIUS_M = 0.08  # of the circle of the hand
MOST_FRAMES = 5_000
MOST_BYTES = 16 * MEGABYTE  # of a file
MOST_NAME = 200  # letters
FORMAT = "viewimit motion 1"


class Motion(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, omit_defaults=False):
    """A posture of the moving joints a frame, `step_s` seconds apart. joints: their numbers from 1."""

    format: str = FORMAT
    name: Annotated[str, msgspec.Meta(max_length=MOST_NAME)]
    joints: tuple[int, ...]
    step_s: float = STEP_S
    theta_deg: tuple[tuple[float, ...], ...]

    @property
    def theta(self) -> NDArray:
        """(T, m) rad"""
        return np.radians(self.theta_deg).reshape(len(self.theta_deg), len(self.joints))

    @property
    def seconds(self) -> float:
        return self.step_s * max(len(self.theta_deg) - 1, 0)


def motion(name: str, scene: Scene, theta: NDArray, step_s: float = STEP_S) -> Motion:
    """Of postures theta (T, m) rad, checked. Raises ValueError for none, too many, or one that the scene forbids."""
    made = Motion(name=name, joints=scene.moving_joints, step_s=step_s, theta_deg=_rows(theta))
    require_motion(made, scene)
    return made


def sinusoid(world: World, theta: NDArray, frames: int = FRAMES) -> Motion:
    """Joint k swings k times about theta (m,) rad, or about the nearest posture with room for it."""
    scene, (low, high) = world.scene, (world.scene.lower, world.scene.upper)
    swing = np.minimum(np.radians(SWING_DEG), (high - low) / 2)
    centre = np.clip(theta, low + swing, high - swing)
    phase = np.linspace(0, 2 * np.pi, frames)[:, None] * np.arange(1, len(centre) + 1)
    return motion("sinusoid", scene, centre + swing * np.sin(phase))


def hand_circle(world: World, theta: NDArray, frames: int = FRAMES) -> Motion:
    """The hand's circle from theta (m,) rad, towards the base, in the plane in which it moves most easily there."""
    base, here = world.T_world_demo, hand_position(world, theta, world.T_world_demo)
    axes, _, _ = np.linalg.svd(hand_jacobian(world, theta, base))
    inward = axes[:, 0] * np.sign(axes[:, 0] @ (base[:3, 3] - here) or 1.0)
    postures = []
    for angle in np.linspace(0, 2 * np.pi, frames):
        target = here + RADIUS_M * ((1 - np.cos(angle)) * inward + np.sin(angle) * axes[:, 1])
        theta = pose_for_hand(world, target, theta)
        postures.append(theta)
    return motion("circle of the hand", world.scene, np.array(postures))


MOTIONS = {"sinusoid": sinusoid, "circle": hand_circle}
TITLES = {"circle": "circle of the hand"}  # of those that their name does not say it all of


def save(path: str | Path, saved: Motion) -> None:
    """As JSON. Raises OSError."""
    Path(path).write_bytes(encode(saved))


def load(path: str | Path, scene: Scene) -> Motion:
    """Of a JSON file. Raises OSError, or ValueError that names the file and what is wrong with it."""
    try:
        return decode(read_bytes(Path(path), MOST_BYTES), scene)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None


def encode(saved: Motion) -> bytes:
    return msgspec.json.format(msgspec.json.encode(saved), indent=1)


def decode(data: bytes, scene: Scene) -> Motion:
    """Raises ValueError if this is no motion, or none of this scene."""
    try:
        found = msgspec.json.decode(data, type=Motion)
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"not a recorded motion: {error}") from None
    require_motion(found, scene)
    return found


def require_motion(asked: Motion, scene: Scene) -> None:
    """Raise ValueError unless every frame is a posture of this scene."""
    if asked.format != FORMAT:
        raise ValueError(f"format {asked.format[:40]!r} is not {FORMAT!r}")
    if asked.joints != scene.moving_joints:
        raise ValueError(f"it moves joints {_listed(asked.joints)}, but in this scene joints "
                         f"{_listed(scene.moving_joints)} move")  # fmt: skip
    if not 2 <= len(asked.theta_deg) <= MOST_FRAMES:
        raise ValueError(f"a motion has 2 to {MOST_FRAMES} frames, this one {len(asked.theta_deg)}")
    if not 0.001 <= asked.step_s <= 10:
        raise ValueError(f"step_s must be between 0.001 and 10 s, got {asked.step_s:g}")
    for k, posture in enumerate(asked.theta_deg):
        scene.require_posture(np.radians(posture), f"frame {k}, demonstrator's")


def _rows(theta: NDArray) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(row) for row in np.round(np.degrees(theta), 6).tolist())


def _listed(joints: tuple[int, ...]) -> str:
    return ", ".join(map(str, joints))
