"""The adjustment of two bodies where the own arm is off by an unknown angle at each visit (`own_body`)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .disturbed import Extended
from .own_body import with_offsets
from .two_bodies import BodyPair, PairAdjustment, covariance_of

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LoosePair:
    """Covariance of that adjustment."""

    adjustment: PairAdjustment
    slack: float  # rad: standard deviation of an offset

    def std(self, pair: BodyPair) -> Array:
        """Of the way from the arm, where it is now, to the demonstrator: (m,) rad for noise of 1 px."""
        m, P = pair.n_joints, len(pair.parameters)
        n_offsets = self.adjustment.own.observations.displacement[1:].size
        model = Extended(np.append(pair.parameters, np.zeros(n_offsets)), pair.points, pair)
        prior = np.full(n_offsets, (self.adjustment.own.noise_px / self.slack) ** 2)
        weights = np.append(self.adjustment.prior_weights(pair), prior)
        covariance = covariance_of(model, self._residuals, weights)
        to, now = pair.angle_slice.start + np.arange(m), P + n_offsets - m + np.arange(m)
        variance = np.diag(covariance)
        return np.sqrt(np.maximum(variance[to] + variance[now] - 2 * covariance[to, now], 0))

    def _residuals(self, model: Extended) -> Array:
        own, pair = self.adjustment.own, model.body
        K = len(own.observations.displacement)
        theirs = self.adjustment.residuals(pair)[..., K:, :, :]
        moved = own.residuals(pair.body, with_offsets(own.observations.displacement, model.more))
        return np.concatenate([moved, theirs], -3)
