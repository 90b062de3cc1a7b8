"""Images that are linear in the joints, for servos that are driven without cameras."""

import numpy as np

from viewimit.estimation.transfers.transfer import conflict
from viewimit.servo import Observation


class LinearWorld:
    """own(θ) = y + J θ exactly, θ within ±limit rad; e is the way from the images of `aim`."""

    def __init__(self, m, rng, points, limit=2.0):
        self.J, self.y = rng.normal(0, 100, (points, 4, m)), rng.uniform(0, 240, (points, 4))
        self.aim, self.limit = rng.uniform(-0.35, 0.35, m), limit

    def images(self, theta):
        return self.y + self.J @ theta

    def residuals(self, own):
        return own - self.images(self.aim)

    def seen(self, theta, motion=0, noise_px=0.0, limit=None):
        own, limits = self.images(theta), np.full(len(theta), self.limit if limit is None else limit)
        E = float(conflict(self.residuals(own)))
        return Observation(own, np.ones((len(own), 2), bool), E, theta, -limits, limits, motion, noise_px)
