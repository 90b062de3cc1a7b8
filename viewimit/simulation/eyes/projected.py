"""Image points as a camera's geometry has them, and arms without weight."""

import numpy as np
from numpy.typing import NDArray

from ...loop.settings import Settings
from ..disturbances import ArmDisturbance, any_of, drive
from ..robot import Angles
from ..scene import Scene
from ..world import World


class ProjectedEyes:
    """See `protocol.SimulatedEyes`."""

    noise_px = 0.0

    def __init__(self, scene: Scene, points: int):
        self.world = World(scene, points)

    def demo_images(self, theta: Angles) -> tuple[NDArray, NDArray]:
        return self.world.demo_images(theta)

    def own_images(self, theta: Angles) -> tuple[NDArray, NDArray]:
        return self.world.own_images(theta)

    def settle(self, theta: NDArray) -> NDArray:
        return theta

    def drive(self, settings: Settings, theta: NDArray, sent: NDArray, commanded: NDArray) -> NDArray:
        amounts, scene = settings.amounts(ArmDisturbance), self.world.scene
        if not any_of(amounts):
            return commanded
        return np.clip(drive(amounts, theta, theta + (commanded - sent)), scene.lower, scene.upper)
