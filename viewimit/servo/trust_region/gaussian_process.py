"""Gaussian-process regression of the own images on the joint displacements, from all visits.

Each coordinate of each image point is a process with the kernel

    k(a, b) = 30² + 200² a·b + 100² exp(-|a - b|² / 2ℓ²) px²,     ℓ = 100°,

of displacements a, b [rad] from a centre: a linear function, as images nearly are, plus a smooth deviation. With the
visits Θ and K = k(Θ, Θ) + σ² I, the prediction is k(θ, Θ) K⁻¹ y, and its variance k(θ, θ) - k(θ, Θ) K⁻¹ k(Θ, θ).

References
----------
Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006, sections 2.2 and 9.4.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..image_jacobian import MIN_WELL_SEEN
from ..observation import Visit, repeat_xy

OFFSET_PX, SLOPE_PX, BEND_PX = 30.0, 200.0, 100.0  # prior standard deviations: px, px/rad, px
LENGTH_RAD = float(np.radians(100.0))  # over which images deviate from linear functions
MIN_NOISE_PX = 0.02  # keeps K regular
NOISE_STEP, MAX_NOISE_PX = 1.25, 100.0  # factor between tested sizes of the noise, and the largest


@dataclass(frozen=True)
class GaussianProcessImages:
    """Images of the own points as a function of the displacement, about one of the visits."""

    centre: NDArray[np.float64]  # (m,) rad
    at_centre: NDArray[np.float64]  # (N, 4) px
    offsets: NDArray[np.float64]  # (n, m) rad: the visits, from the centre
    weights: NDArray[np.float64]  # (n, N, 4): K⁻¹ y
    noise_px: float  # standard deviation of an image coordinate
    seen: NDArray[np.bool_]  # (n, N): visible in both images

    @classmethod
    def fit(cls, visits: Sequence[Visit], centre: int, noise_px: float) -> "GaussianProcessImages":
        """Fit the process about one of the visits. noise_px: standard deviation of an image coordinate."""
        displacement = np.array([visit.displacement for visit in visits])
        own = np.array([visit.own for visit in visits])
        seen = np.array([visit.seen for visit in visits])
        offsets = displacement - displacement[centre]
        distance, K = np.abs(offsets).max(1), gram_matrix(offsets, noise_px)
        if seen.all():
            at_centre = own[distance.argmin()]
            weights = np.linalg.solve(K, (own - at_centre).reshape(len(visits), -1))
        else:
            at_centre, weights = _fit_partial(own, repeat_xy(seen), distance, K, min_visits=offsets.shape[1] + 1)
        return cls(displacement[centre], at_centre, offsets, weights.reshape(own.shape), noise_px, np.all(seen, -1))

    def predict(self, displacement: NDArray[np.float64]) -> NDArray[np.float64]:
        """Images (..., N, 4) px at (..., m) rad, NaN for points that were seen too rarely to show how they move."""
        k = kernel(displacement - self.centre, self.offsets)
        change = k.reshape(-1, len(self.offsets)) @ self.weights.reshape(len(self.offsets), -1)  # one product for all
        return self.at_centre + change.reshape(*k.shape[:-1], *self.at_centre.shape)

    def restrict(self, points: NDArray[np.bool_]) -> "GaussianProcessImages":
        """Forget all other points, (N,) bool."""
        return self if points.all() else replace(self, at_centre=np.where(points[:, None], self.at_centre, np.nan))

    def impute(self, own: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the visited images, (n, N, 4) px, as they are: predictions of hidden points are not certain enough."""
        return own

    def jacobian(self, displacement: NDArray[np.float64]) -> NDArray[np.float64]:
        """Derivatives of the predicted images, (m, N, 4) px/rad, at (m,) rad."""
        weights = self.weights.reshape(len(self.offsets), -1)
        return (self._jacobian_covariance(displacement).T @ weights).reshape(-1, *self.at_centre.shape)

    def prediction_std(self, displacement: NDArray[np.float64]) -> NDArray[np.float64]:
        """Standard deviations of the predictions, (k, N) px, at (k, m) rad; inf for points never seen."""
        from_centre = displacement - self.centre
        k, K = kernel(from_centre, self.offsets), gram_matrix(self.offsets, self.noise_px)
        prior = OFFSET_PX**2 + SLOPE_PX**2 * (from_centre**2).sum(-1) + BEND_PX**2
        std = np.full((len(k), self.seen.shape[1]), np.inf)
        patterns, index = np.unique(self.seen, axis=1, return_inverse=True)
        for pattern, seen in enumerate(patterns.T):
            if seen.any():
                explained = np.einsum("kn,nk->k", k[:, seen], np.linalg.solve(K[np.ix_(seen, seen)], k[:, seen].T))
                std[:, index.ravel() == pattern] = np.sqrt(np.maximum(prior - explained, 0.0))[:, None]
        return std

    def jacobian_std(self, displacement: NDArray[np.float64]) -> NDArray[np.float64]:
        """Standard deviation of each point's derivatives that its missing images cause, (N,) px/rad, at (m,) rad.

        It is that in the least certain direction, beyond the uncertainty of a point that was seen at every visit.
        """
        if self.seen.all():
            return np.zeros(self.seen.shape[1])
        K, covariance = gram_matrix(self.offsets, self.noise_px), self._jacobian_covariance(displacement)
        explained = lambda seen: covariance[seen].T @ np.linalg.solve(K[np.ix_(seen, seen)], covariance[seen])
        patterns, index = np.unique(self.seen, axis=1, return_inverse=True)
        missing = explained(np.ones(len(K), bool)) - np.array([explained(seen) for seen in patterns.T])
        return np.sqrt(np.maximum(np.linalg.eigvalsh(missing)[:, -1], 0.0))[index.ravel()]

    def image_weights(self, displacement: NDArray[np.float64]) -> NDArray[np.float64]:
        """Weights (n,) with which the visited images sum to the images predicted at (m,) rad."""
        K = gram_matrix(self.offsets, self.noise_px)
        weights = np.asarray(np.linalg.solve(K, kernel(displacement - self.centre, self.offsets)), float)
        weights[self._index_of_centre] += 1 - weights.sum()  # predictions are changes from the image at the centre
        return weights

    def jacobian_weights(self, displacement: NDArray[np.float64]) -> NDArray[np.float64]:
        """Weights (n, m) /rad with which the visited images sum to the derivatives predicted at (m,) rad."""
        K = gram_matrix(self.offsets, self.noise_px)
        weights = np.asarray(np.linalg.solve(K, self._jacobian_covariance(displacement)), float)
        weights[self._index_of_centre] -= weights.sum(0)
        return weights

    def _jacobian_covariance(self, displacement: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n, m) px²/rad: covariance of the visited images with the derivatives at a displacement."""
        difference = displacement - self.offsets - self.centre
        bend = BEND_PX**2 * np.exp((difference * difference).sum(-1, keepdims=True) / (-2 * LENGTH_RAD**2))
        return SLOPE_PX**2 * self.offsets - bend * difference / LENGTH_RAD**2

    @property
    def _index_of_centre(self) -> int:
        return int(np.abs(self.offsets).sum(-1).argmin())


def kernel(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Prior covariance of images at a, (..., m), and b, (n, m) rad → (..., n) px²."""
    inner = a @ b.T
    squared = np.einsum("...i,...i->...", a, a)[..., None] + np.einsum("ni,ni->n", b, b) - 2 * inner
    return OFFSET_PX**2 + SLOPE_PX**2 * inner + BEND_PX**2 * np.exp(squared / (-2 * LENGTH_RAD**2))


def gram_matrix(offsets: NDArray[np.float64], noise_px: float) -> NDArray[np.float64]:
    """Covariance of the visited images with their noise: (n, m) rad → (n, n) px²."""
    return kernel(offsets, offsets) + max(noise_px, MIN_NOISE_PX) ** 2 * np.eye(len(offsets))


def cross_validated_noise(visits: Sequence[Visit], noise_px: float, slack: float) -> float:
    """Return the noise of an image coordinate with which the process predicts each visit from all others.

    It is at least `noise_px`, the noise at rest, which may be exceeded `slack` times. Errors of prediction follow from
    one fit: that of visit i is (K⁻¹ y)_i / (K⁻¹)_ii, with the variance 1 / (K⁻¹)_ii.
    """
    displacement, own = np.array([visit.displacement for visit in visits]), np.array([visit.own for visit in visits])
    seen, noise = np.all([visit.seen for visit in visits], -1), noise_px
    patterns, index = np.unique(seen, axis=1, return_inverse=True)
    groups = [
        (at, own[at][:, index.ravel() == k]) for k, at in enumerate(patterns.T) if at.sum() > len(displacement[0]) + 1
    ]
    while groups and noise < MAX_NOISE_PX and _squared_errors(displacement, groups, noise) > slack**2:
        noise *= NOISE_STEP
    return noise


def _squared_errors(
    displacement: NDArray[np.float64],
    groups: Sequence[tuple[NDArray[np.bool_], NDArray[np.float64]]],
    noise_px: float,
) -> float:
    """Mean square of the errors of prediction over their variance. groups: visits that show some points, (n,) bool, and
    their images, (k, N, 4) px."""
    squares, count = 0.0, 0
    for at, images in groups:
        y = (images - images.mean(0)).reshape(len(images), -1)
        inverse = np.linalg.inv(gram_matrix(displacement[at] - displacement[at].mean(0), noise_px))
        squares += float(((inverse @ y) ** 2 / np.diag(inverse)[:, None]).sum())
        count += y.size
    return squares / count


def _fit_partial(
    own: NDArray[np.float64],
    seen: NDArray[np.bool_],
    distance: NDArray[np.float64],
    K: NDArray[np.float64],
    min_visits: int,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Image at the centre, (N, 4) px, and weights (n, 4 N), where some points are hidden at some visits.

    own: (n, N, 4) px; seen: (n, N, 4) bool; distance: (n,) rad, from the centre; min_visits: at which a point must be
    seen to show how it moves.
    """
    at_centre = _nearest_seen(own, seen, distance)
    at_centre[_rarely_seen(seen, min_visits)] = np.nan
    change = np.where(seen, own - at_centre, 0.0).reshape(len(own), -1)
    visible = seen.reshape(len(own), -1).T  # the rows and columns of hidden images become those of the identity
    K_visible = np.where(visible[:, :, None] & visible[:, None, :], K, np.eye(len(own)))
    return at_centre, np.linalg.solve(K_visible, change.T[:, :, None])[:, :, 0].T


def _nearest_seen(
    own: NDArray[np.float64], seen: NDArray[np.bool_], distance: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Each coordinate at the visit nearest to the centre that shows it: (N, 4) px, NaN if none does."""
    order = np.argsort(distance, kind="stable")
    first = seen[order].argmax(0)
    nearest = np.take_along_axis(own[order], first[None], 0)[0]
    return np.where(seen.any(0), nearest, np.nan)


def _rarely_seen(seen: NDArray[np.bool_], min_visits: int) -> NDArray[np.bool_]:
    """(N,) bool: points seen at fewer visits than a linear function needs, if enough others were seen that often."""
    count = seen.all(-1).sum(0)
    return count < min(min_visits, np.sort(count)[-min(MIN_WELL_SEEN, len(count))])
