"""Bodies whose points are symmetric about the plane of the stretched arm, as people place them: mirrored postures fit.

The iiwa moves in that plane, and its axles lie on one line when it is stretched. With pairs of markers at both ends of
the axles the posture -θ is, point by point, the mirror image of θ: of the same shape but the other handedness, which
affine and projective maps allow. The Panda turns out of the plane, by joints whose limits allow θ and -θ. With markers
in the plane, as along the front of the arm, -θ is the mirror image again. Near 0 these markers tell less, as all of
them lie in one plane.
"""

from dataclasses import dataclass

import numpy as np

from ...simulation.robot import BodyPoints, load_robot
from ...simulation.scene import Scene, load_scene

SIDE_M = 0.07  # of a pair's markers from its axle
ALONG_M = 0.03  # of a pair from its axle, at most, along the stretched arm
OFF_M = 0.002, 0.010  # of a marker from exact symmetry
EXACT_SHARE = 0.5  # of the symmetric bodies, which are exactly so
X, Y, Z = range(3)  # of the arm's base; the plane of the stretched arm is that of X and Z


@dataclass(frozen=True)
class Arm:
    """A scene's text, and the axis along which the markers of a pair lie apart: across the arm's plane, or in it."""

    scene: str
    apart: int


ARMS = (  # whose other joints are at 0, or turn about axles across the plane
    Arm(
        'extends = "iiwa"\nrange_deg = [[-50, 50], [-100, 100]]\nstart_deg = [-20, 30]\n'
        "posture_deg = [0, 30, 0, -40, 0, 0, 0]\n",
        Y,
    ),
    Arm(
        'extends = "panda"\nmoving_joints = [3, 5]\nrange_deg = [[-60, 60], [-80, 80]]\nstart_deg = [-20, 30]\n'
        "posture_deg = [0, 45, 30, -90, -40, 90, 0]\n",
        X,
    ),
    Arm(
        'extends = "iiwa"\nmoving_joints = [2, 4, 6]\nrange_deg = [[-50, 50], [-90, 90], [-90, 90]]\n'
        "start_deg = [-20, 30, 20]\nposture_deg = [0, 30, 0, -40, 0, 30, 0]\n",
        Y,
    ),
)


@dataclass(frozen=True)
class MarkedArm:
    """An arm, and its body points: pairs, one after the other."""

    arm: Arm
    body: BodyPoints

    @property
    def scene(self) -> str:
        return self.arm.scene


def draw(rng: np.random.Generator, symmetric: bool) -> MarkedArm:
    """Return an arm with a pair of markers at its base and at each joint.

    symmetric: about the arm's plane, exactly so or with each marker moved by 2 to 10 mm; False leaves each anywhere
    across the plane, within `SIDE_M`.
    """
    arm = ARMS[rng.choice(len(ARMS))]
    return MarkedArm(arm, _markers(load_scene(arm.scene), arm.apart, rng, symmetric))


def _markers(scene: Scene, apart: int, rng: np.random.Generator, symmetric: bool) -> BodyPoints:
    robot = load_robot(scene.robot)
    stretched = np.radians(scene.posture_deg)
    stretched[scene.moving] = 0.0
    frames = robot.link_frames(stretched)
    links = np.repeat(np.arange(len(frames)), 2)
    frames = frames[links]
    places, sides = frames[:, :3, 3].copy(), SIDE_M * np.tile([1.0, -1.0], len(links) // 2)
    places[:, apart] += sides
    places[:, Z] += np.repeat(rng.uniform(-ALONG_M, ALONG_M, len(links) // 2), 2)
    off = rng.normal(size=places.shape)
    off *= rng.uniform(*OFF_M) / np.linalg.norm(off, axis=1, keepdims=True)
    if not symmetric:
        places[:, Y] = sides * rng.uniform(-1, 1, len(places))
    elif rng.random() > EXACT_SHARE:
        places += off
    return BodyPoints(links, np.einsum("nji,nj->ni", frames[:, :3, :3], places - frames[:, :3, 3]))
