"""Bodies with markers on both sides of the arm's plane, as at the ends of its axles: each posture has a mirror image.

The arm moves in a plane; pairs of markers lie on both sides of it, at the axles of the straight arm. Then the posture
-θ is a reflection of θ: the same shape with the other handedness, which affine and projective maps allow.
"""

from dataclasses import dataclass

import numpy as np

from ...simulation.robot import BodyPoints
from ...simulation.robots import load_robot
from ...simulation.scene import Scene, load_scene

SIDE_M = 0.07  # of a marker from the arm's plane
ALONG_M = 0.03  # from the axle, at most, along the stretched arm
OFF_M = 0.002, 0.010  # from exact symmetry
EXACT_SHARE = 0.5  # of the bodies that are exactly symmetric
SCENES = (  # whose other joints are at 0, so that all that moves stays in one plane
    'extends = "iiwa"\nrange_deg = [[-50, 50], [-100, 100]]\nstart_deg = [-20, 30]\n'
    "posture_deg = [0, 30, 0, -40, 0, 0, 0]\n",
    'extends = "panda"\nposture_deg = [0, 45, 0, -90, 0, 90, 0]\n',
    'extends = "iiwa"\nmoving_joints = [2, 4, 6]\nrange_deg = [[-50, 50], [-90, 90], [-90, 90]]\n'
    "start_deg = [-20, 30, 20]\nposture_deg = [0, 30, 0, -40, 0, 30, 0]\n",
)


@dataclass(frozen=True)
class MarkedArm:
    """A scene's text, and its body points."""

    scene: str
    body: BodyPoints


def draw(rng: np.random.Generator, symmetric: bool) -> MarkedArm:
    """Return an arm with a pair of markers at its base and at each joint.

    symmetric: False leaves each marker anywhere between the two sides.
    """
    text = str(rng.choice(SCENES))
    return MarkedArm(text, _markers(load_scene(text), rng, symmetric))


def _markers(scene: Scene, rng: np.random.Generator, symmetric: bool) -> BodyPoints:
    robot = load_robot(scene.robot)
    straight = np.radians(scene.posture_deg)
    straight[scene.moving] = 0.0
    frames = robot.link_frames(straight)
    links = np.repeat(np.arange(len(frames)), 2)
    places = frames[links, :3, 3].copy()
    places[:, 2] += np.repeat(rng.uniform(-ALONG_M, ALONG_M, len(frames)), 2)
    places[:, 1] = SIDE_M * np.tile([1.0, -1.0], len(frames))
    off = rng.normal(size=places.shape)
    off *= rng.uniform(*OFF_M) / np.linalg.norm(off, axis=1, keepdims=True)
    if not symmetric:
        places[:, 1] *= rng.uniform(-1, 1, len(places))
    elif rng.random() > EXACT_SHARE:
        places += off
    in_link = np.einsum("nji,nj->ni", frames[links, :3, :3], places - frames[links, :3, 3])
    return BodyPoints(links, in_link)
