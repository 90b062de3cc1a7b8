"""The own images as the joints turn them: kinematics that explain all visits foretell every posture at once.

Of points of which it is not told yet which joints move them, a Gaussian process does.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...geometry.kinematics.clusters import Observations
from ...geometry.kinematics.covariance import KinematicsCovariance
from ...geometry.kinematics.model import ProjectiveKinematics
from .surrogate import Surrogate

APART = 1e-5  # rad, of difference quotients
CONFIRMING = 4  # points seen at a visit, so that the others are as good as seen
TINY = 1e-3  # standard deviations, of linear draws


@dataclass(frozen=True)
class KinematicImages:
    """centre: (m,) rad; visited: what was learned from; noise_px: of an image coordinate; process: what the same visits
    tell without kinematics, None where those tell all points."""

    kinematics: ProjectiveKinematics
    centre: NDArray
    visited: Observations
    noise_px: float
    process: Surrogate | None

    @property
    def seen(self) -> NDArray:
        """(n, N) bool: in both images, or as good as seen there, as what was seen confirms the kinematics."""
        confirmed = self.visited.visible_in_both.sum(1, keepdims=True) >= CONFIRMING
        return self.visited.visible_in_both | (confirmed & self._told[:, 0])

    def completed(self, own: NDArray) -> NDArray:
        """The images visited, (n, N, 4) px, those that were not seen as they are foretold: `seen` says what they are
        worth."""
        seen = self.visited.visible_in_both[..., None]
        return own if seen.all() else np.where(seen, own, self.predict(self.visited.displacement))

    @cached_property
    def at_centre(self) -> NDArray:
        return self.predict(self.centre)

    def predict(self, displacement: NDArray) -> NDArray:
        """(..., m) rad → (..., N, 4) px"""
        images = self.kinematics.predict(displacement)
        return images if self.process is None else np.where(self._told, images, self.process.predict(displacement))

    def only(self, points: NDArray) -> "KinematicImages":
        """The same of some points, (N,) bool, that knows nothing of the others."""
        if points.all():
            return self
        shape = np.where(points[:, None], self.kinematics.points, np.nan)
        process = None if self.process is None else self.process.only(points)
        return replace(self, kinematics=replace(self.kinematics, points=shape), process=process)

    def slopes(self, displacement: NDArray) -> NDArray:
        """(m,) rad → (m, N, 4) px/rad"""
        apart = APART * np.eye(len(displacement))
        ahead, behind = self.predict(np.stack([displacement + apart, displacement - apart]))
        return (ahead - behind) / (2 * APART)

    def spread(self, displacement: NDArray) -> NDArray:
        """(k, m) rad → (k, N) px: standard deviations of what is foretold, inf for points never seen."""
        spread = np.zeros((len(displacement), len(self._told)))
        if self.noise_px > 0:
            columns = self._with(self._information.columns(TINY)).predict(displacement)
            off = (columns - self.kinematics.predict(displacement)) * (self.noise_px / TINY)
            spread = np.sqrt((off**2).sum(0).mean(-1))
        rest = np.inf if self.process is None else self.process.spread(displacement)
        return np.where(self._told[:, 0], spread, rest)

    def unlearned_slopes(self, displacement: NDArray) -> NDArray:
        """(m,) rad → (N,) px/rad: as the process has it, 0 for points that kinematics tell."""
        rest = np.inf if self.process is None else self.process.unlearned_slopes(displacement)
        return np.where(self._told[:, 0], 0.0, rest)

    def drawn(self, displacement: NDArray, draws: int, seed: int) -> tuple[NDArray, NDArray]:
        """(m,) rad → draws of what the noise of all visits makes of the image foretold there, (draws, N, 4) px, and of
        its slopes, (draws, m, N, 4) px/rad."""
        apart = APART * np.eye(1 + len(displacement), len(displacement), -1)
        rng = np.random.default_rng(seed)
        off = self._with(self._information.sample(rng, draws, TINY)).predict(displacement + apart)
        off = (off - self.kinematics.predict(displacement + apart)) * (self.noise_px / TINY)
        images, slopes = off[:, 0], (off[:, 1:] - off[:, :1]) / APART
        if self.process is None:
            return images, slopes
        noise = self.noise_px * rng.standard_normal((draws, len(self.seen), *images.shape[1:]))
        of_images = np.tensordot(self.process.image_weights(displacement), noise, ([0], [1]))
        of_slopes = np.moveaxis(np.tensordot(self.process.slope_weights(displacement), noise, ([0], [1])), 0, 1)
        return np.where(self._told, images, of_images), np.where(self._told, slopes, of_slopes)

    def _with(self, off: tuple[NDArray, NDArray]) -> ProjectiveKinematics:
        """Several kinematics at once, that much off: (D, P), (D, N, 3)."""
        parameters, shape = self.kinematics.parameters + off[0], self.kinematics.points + off[1]
        return replace(self.kinematics, parameters=parameters, points=shape)

    @cached_property
    def _told(self) -> NDArray:
        """(N, 1) bool: points that kinematics tell."""
        return ~self.kinematics.unknown[:, None]

    @cached_property
    def _information(self) -> KinematicsCovariance:
        return KinematicsCovariance.estimate(self.kinematics, self.visited)
