"""Images that are linear in the joints, for servos that are driven without cameras."""

from dataclasses import replace

import numpy as np

from viewimit.estimation.transfers.transfer import conflict
from viewimit.servo import Observation


class LinearWorld:
    """own(θ) = y + J θ exactly; e is the way from the images of `aim`, each joint of which is within so many rad of 0,
    and `least` keeps it from 0. limit: rad, of each joint."""

    def __init__(self, m, rng, points, within=0.35, limit=2.0):
        self.J, self.y = rng.normal(0, 100, (points, 4, m)), rng.uniform(0, 240, (points, 4))
        self.aim, self.least = rng.uniform(-within, within, m), np.zeros((points, 4))
        self.limit = limit

    def images(self, theta):
        return self.y + self.J @ theta

    def residuals(self, own):
        return own - self.images(self.aim) + self.least

    def seen(self, theta, motion=0, noise=0.0, noise_px=0.0, limit=None):
        """Without an E. noise: px, of each coordinate or all."""
        own, limits = self.images(theta) + noise, np.full(len(theta), self.limit if limit is None else limit)
        return Observation(own, np.ones((len(own), 2), bool), np.nan, theta, -limits, limits, motion, noise_px)

    def observe(self, theta, motion):
        seen = self.seen(theta, motion)
        return replace(seen, E=float(conflict(self.residuals(seen.own))))
