"""Bodies with pairs of markers at both ends of an arm's axles, as people place them: symmetric about the arm's plane.

The arm moves in that plane. Where all axles lie on one line when it is stretched, as the iiwa's do, the posture -θ is
the mirror image of θ, point by point: of the same shape but the other handedness, which affine and projective maps
allow. The panda's elbow is offset, and its -θ lies beyond its limits: there nothing is to be mistaken.
"""

from dataclasses import dataclass

import numpy as np

from ...simulation.robot import BodyPoints
from ...simulation.robots import load_robot
from ...simulation.scene import Scene, load_scene

SIDE_M = 0.07  # of a marker from the arm's plane
ALONG_M = 0.03  # of a pair from its axle, at most, along the stretched arm
OFF_M = 0.002, 0.010  # of a marker from exact symmetry
EXACT_SHARE = 0.5  # of the symmetric bodies, which are exactly so
SCENES = (  # whose other joints are at 0, so that all that moves stays in one plane
    'extends = "iiwa"\nrange_deg = [[-50, 50], [-100, 100]]\nstart_deg = [-20, 30]\n'
    "posture_deg = [0, 30, 0, -40, 0, 0, 0]\n",
    'extends = "panda"\nposture_deg = [0, 45, 0, -90, 0, 90, 0]\n',
    'extends = "iiwa"\nmoving_joints = [2, 4, 6]\nrange_deg = [[-50, 50], [-90, 90], [-90, 90]]\n'
    "start_deg = [-20, 30, 20]\nposture_deg = [0, 30, 0, -40, 0, 30, 0]\n",
)


@dataclass(frozen=True)
class MarkedArm:
    """A scene's text, and its body points: pairs, one after the other."""

    scene: str
    body: BodyPoints


def draw(rng: np.random.Generator, symmetric: bool) -> MarkedArm:
    """Return an arm with a pair of markers at its base and at each joint.

    symmetric: the markers of a pair lie on both sides of the arm's plane, exactly so or each moved by 2 to 10 mm; False
    leaves each anywhere between the two sides.
    """
    text = str(rng.choice(SCENES))
    return MarkedArm(text, _markers(load_scene(text), rng, symmetric))


def _markers(scene: Scene, rng: np.random.Generator, symmetric: bool) -> BodyPoints:
    robot = load_robot(scene.robot)
    stretched = np.radians(scene.posture_deg)
    stretched[scene.moving] = 0.0
    frames = robot.link_frames(stretched)
    links = np.repeat(np.arange(len(frames)), 2)
    frames = frames[links]
    places = frames[:, :3, 3].copy()
    places[:, 1] = SIDE_M * np.tile([1.0, -1.0], len(links) // 2)
    places[:, 2] += np.repeat(rng.uniform(-ALONG_M, ALONG_M, len(links) // 2), 2)
    off = rng.normal(size=places.shape)
    off *= rng.uniform(*OFF_M) / np.linalg.norm(off, axis=1, keepdims=True)
    if not symmetric:
        places[:, 1] *= rng.uniform(-1, 1, len(places))
    elif rng.random() > EXACT_SHARE:
        places += off
    return BodyPoints(links, np.einsum("nji,nj->ni", frames[:, :3, :3], places - frames[:, :3, 3]))
