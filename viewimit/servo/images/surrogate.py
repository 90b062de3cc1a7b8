"""The own images as a Gaussian process over displacements: what the postures visited tell of those not visited.

Each coordinate of each image point is one process; all share the kernel 30² + 200² a·b + 100² exp(-|a-b|²/2ℓ²) px²,
a, b in rad from the centre: linear, as images nearly are, and smooth where they are not
(Rasmussen & Williams 2006, Ch. 2).
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..image_model import ENOUGH
from ..observation import Visit, by_coordinate

OFFSET, SLOPE, BEND, LENGTH = 30.0, 200.0, 100.0, float(np.radians(100.0))  # px, px/rad, px, rad
LEAST_NOISE = 0.02  # px: keeps the system regular


@dataclass(frozen=True)
class Surrogate:
    """centre: (m,) rad; at_centre: (N, 4) px; away: (n, m) rad, the visits from there; weight: (n, N, 4);
    noise_px: of an image coordinate; seen: (n, N) bool, in both images."""

    centre: NDArray
    at_centre: NDArray
    away: NDArray
    weight: NDArray
    noise_px: float
    seen: NDArray

    def predict(self, displacement: NDArray) -> NDArray:
        """(..., m) rad → (..., N, 4) px, NaN for points never seen, or too rarely to tell how they move."""
        k = kernel(displacement - self.centre, self.away)
        rise = k.reshape(-1, len(self.away)) @ self.weight.reshape(len(self.away), -1)  # of the whole batch at once
        return self.at_centre + rise.reshape(*k.shape[:-1], *self.at_centre.shape)

    def only(self, points: NDArray) -> "Surrogate":
        """The same of some points, (N,) bool, that knows nothing of the others."""
        return self if points.all() else replace(self, at_centre=np.where(points[:, None], self.at_centre, np.nan))

    def completed(self, own: NDArray) -> NDArray:
        """The images visited, (n, N, 4) px: what was not seen is not certain enough to add."""
        return own

    def slopes(self, displacement: NDArray) -> NDArray:
        """(m,) rad → (m, N, 4) px/rad: the derivatives of the predicted images."""
        weight = self.weight.reshape(len(self.away), -1)
        return (self._with_slopes(displacement).T @ weight).reshape(-1, *self.at_centre.shape)

    def spread(self, displacement: NDArray) -> NDArray:
        """(k, m) rad → (k, N) px: standard deviations of what is predicted, inf for points never seen."""
        from_centre = displacement - self.centre
        k, K = kernel(from_centre, self.away), gram(self.away, self.noise_px)
        prior = OFFSET**2 + SLOPE**2 * (from_centre**2).sum(-1) + BEND**2
        spread = np.full((len(k), self.seen.shape[1]), np.inf)
        patterns, of = np.unique(self.seen, axis=1, return_inverse=True)
        for pattern, told in enumerate(patterns.T):
            if told.any():
                explained = np.einsum("kn,nk->k", k[:, told], np.linalg.solve(K[np.ix_(told, told)], k[:, told].T))
                spread[:, of.ravel() == pattern] = np.sqrt(np.maximum(prior - explained, 0.0))[:, None]
        return spread

    def image_weights(self, displacement: NDArray) -> NDArray:
        """(m,) rad → (n,): the predicted images are these sums of the images visited."""
        weights = np.linalg.solve(gram(self.away, self.noise_px), kernel(displacement - self.centre, self.away))
        weights[self._at_centre] += 1 - weights.sum()  # images are told from that at the centre
        return weights

    def slope_weights(self, displacement: NDArray) -> NDArray:
        """(m,) rad → (n, m) /rad: the derivatives of the predicted images are these sums of the images visited."""
        weights = np.linalg.solve(gram(self.away, self.noise_px), self._with_slopes(displacement))
        weights[self._at_centre] -= weights.sum(0)
        return weights

    def unlearned_slopes(self, displacement: NDArray) -> NDArray:
        """(m,) rad → (N,) px/rad, standard deviations: what is not known of how a point's images move there, in the
        direction of which the least is known, but is of a point that was seen at every visit, for which it is 0."""
        if self.seen.all():
            return np.zeros(self.seen.shape[1])
        K, with_slopes = gram(self.away, self.noise_px), self._with_slopes(displacement)
        explained = lambda told: with_slopes[told].T @ np.linalg.solve(K[np.ix_(told, told)], with_slopes[told])
        patterns, of = np.unique(self.seen, axis=1, return_inverse=True)
        left = explained(np.ones(len(K), bool)) - np.array([explained(told) for told in patterns.T])
        return np.sqrt(np.maximum(np.linalg.eigvalsh(left)[:, -1], 0.0))[of.ravel()]

    def _with_slopes(self, displacement: NDArray) -> NDArray:
        """(n, m) px²/rad: the covariances of the images visited with the slopes at a displacement."""
        apart = displacement - self.away - self.centre
        bend = BEND**2 * np.exp((apart * apart).sum(-1, keepdims=True) / (-2 * LENGTH**2))
        return SLOPE**2 * self.away - bend * apart / LENGTH**2

    @property
    def _at_centre(self) -> int:
        return int(np.abs(self.away).sum(-1).argmin())


def learn(visits: list[Visit], centre: int, noise_px: float) -> Surrogate:
    """Around one of the visits. noise_px: of an image coordinate, standard deviation."""
    displacement = np.array([visit.displacement for visit in visits])
    own = np.array([visit.own for visit in visits])
    seen = np.array([visit.seen for visit in visits])
    away = displacement - displacement[centre]
    distance, K = np.abs(away).max(1), gram(away, noise_px)
    if seen.all():
        at_centre = own[distance.argmin()]
        weight = np.linalg.solve(K, (own - at_centre).reshape(len(visits), -1))
    else:
        at_centre, weight = _of_seen(own, by_coordinate(seen), distance, K, away.shape[1] + 1)
    return Surrogate(displacement[centre], at_centre, away, weight.reshape(own.shape), noise_px, np.all(seen, -1))


def _of_seen(own: NDArray, seen: NDArray, distance: NDArray, K: NDArray, times: int) -> tuple[NDArray, NDArray]:
    """Of images (n, N, 4) px of which those coordinates were seen: at the centre, (N, 4) px, and weights (n, 4N).
    distance: (n,) rad, from there; times: that a point must have been seen."""
    at_centre = _nearest_seen(own, seen, distance)
    at_centre[_rarely_seen(seen, times)] = np.nan
    rise = np.where(seen, own - at_centre, 0.0).reshape(len(own), -1)
    told = seen.reshape(len(own), -1).T  # what was not seen has no part: its rows and columns are those of the identity
    each = np.where(told[:, :, None] & told[:, None, :], K, np.eye(len(own)))
    return at_centre, np.linalg.solve(each, rise.T[:, :, None])[:, :, 0].T


def _nearest_seen(own: NDArray, seen: NDArray, distance: NDArray) -> NDArray:
    """Each coordinate where it was seen nearest to the centre: (N, 4) px, NaN if never."""
    order = np.argsort(distance, kind="stable")
    first = seen[order].argmax(0)
    nearest = np.take_along_axis(own[order], first[None], 0)[0]
    return np.where(seen.any(0), nearest, np.nan)


def _rarely_seen(seen: NDArray, times: int) -> NDArray:
    """(N,) bool: fewer times than a plane over the displacements needs, if others were seen that often."""
    count = seen.all(-1).sum(0)
    return count < min(times, np.sort(count)[-min(ENOUGH, len(count))])


def kernel(a: NDArray, b: NDArray) -> NDArray:
    """a: (..., m), b: (n, m) rad → (..., n) px²"""
    along = a @ b.T
    apart = np.einsum("...i,...i->...", a, a)[..., None] + np.einsum("ni,ni->n", b, b) - 2 * along
    return OFFSET**2 + SLOPE**2 * along + BEND**2 * np.exp(apart / (-2 * LENGTH**2))


def gram(away: NDArray, noise_px: float) -> NDArray:
    """(n, n) px²: of the images visited, with their noise."""
    return kernel(away, away) + max(noise_px, LEAST_NOISE) ** 2 * np.eye(len(away))
