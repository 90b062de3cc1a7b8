"""Robust fits of the epipolar geometry of matches: least median of squares (Rousseeuw 1984).

Samples of as few matches as determine a geometry are drawn, and the one from which half of all matches are nearest is
kept; so up to half of them may be wrong. Concentration steps then fit the geometry to the nearest half of the matches
(Rousseeuw and Van Driessen 1999). Geometries are affine, as of parallel optical axes, or fundamental matrices, where
these have fewer outliers. If neither fits half of the matches as well as noise allows, no match is an outlier.

References
----------
Rousseeuw, "Least median of squares regression", 1984.
Rousseeuw and Van Driessen, "A fast algorithm for the minimum covariance determinant estimator", 1999.
Torr and Murray, "The development and comparison of robust methods for estimating the fundamental matrix", IJCV 1997.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .affine import fit_affine_fundamental, image_unit
from .fundamental import fit_fundamental, homogeneous, sampson_distance

MIN_MATCHES, MIN_MATCHES_F = 12, 24  # for an affine geometry, for a fundamental matrix
N_SAMPLES, N_SAMPLES_F = 40, 120  # with a fifth of the matches wrong, less than one in a billion finds no good sample
OUTLIER_SIGMA, MIN_THRESHOLD_PX = 6.0, 0.2  # distances up to either are inliers
MIN_THRESHOLD_FEW_PX = 1.0  # with too few matches to see whether they need a fundamental matrix
MAX_STD_RATIO = 3.0  # of the nearer half's deviation to the noise, or to MIN_THRESHOLD_PX: beyond it nothing fits
MAD_TO_STD = 1.4826  # of a normal distribution: from the median of |x| to the standard deviation
N_CONCENTRATIONS = 3
N_LOW_LEVERAGE = 120  # matches, from which on no single match has much influence on the fit to all
N_UNCERTAIN_STD = 17  # matches, whose standard deviation is so uncertain that the threshold is doubled
MAX_ROW_STD_PX = 1.5  # of matches in equal rows
GAP_FACTOR = 2.0  # times the farthest inlier: cameras that are turned a little spread matches without a gap
MIN_F_RATIO = 12.0  # of the squares that a fundamental matrix's three further parameters explain to the remaining ones


@dataclass(frozen=True)
class GeometryFit:
    """An epipolar geometry that was fitted to matches."""

    distance: Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]  # left, right (M, 2) → (M,) px
    std_px: float  # of the distances of the matches
    threshold: float  # in standard deviations, beyond which a match is an outlier; larger after a fit to few matches


def all_inliers(left: NDArray[np.float64], right: NDArray[np.float64], noise_px: float) -> bool:
    """Whether one affine geometry fits all matches, (M, 2) px each, or they are too few to say."""
    threshold = max(MIN_THRESHOLD_PX * _unit(left, right), OUTLIER_SIGMA * noise_px)
    has_equal_rows = (np.abs(right[:, 1] - left[:, 1]) <= threshold).all()  # an affine geometry that most heads have
    if len(left) < MIN_MATCHES or has_equal_rows:
        return True
    return bool((np.abs(affine_distance(left, right)) <= threshold).all())


def detect_outliers(
    left: NDArray[np.float64], right: NDArray[np.float64], noise_px: float, rng: np.random.Generator
) -> NDArray[np.bool_]:
    """Find matches that contradict the epipolar geometry of the others.

    Parameters
    ----------
    left, right : (M, 2) array
        Matches [px].
    noise_px : float
        Standard deviation of an image coordinate.
    rng : numpy.random.Generator
        Draws the samples.

    Returns
    -------
    (M,) bool array
        All False with too few matches, or where no geometry fits half of them.
    """
    count, unit_px = len(left), _unit(left, right)
    found = [np.zeros(count, bool)]
    if count >= MIN_MATCHES:
        min_px = unit_px * (MIN_THRESHOLD_PX if count >= MIN_MATCHES_F else MIN_THRESHOLD_FEW_PX)
        found += _outliers_of(_sample_affine(left, right, rng), affine_distance, left, right, noise_px, min_px)
    if count >= MIN_MATCHES_F:
        distances, min_px = _sample_fundamental(left, right, rng), unit_px * MIN_THRESHOLD_PX
        found += _outliers_of(distances, fundamental_distance, left, right, noise_px, min_px)
    return min(found[1:], key=np.count_nonzero, default=found[0])


def inlier_std(left: NDArray[np.float64], right: NDArray[np.float64], rng: np.random.Generator) -> float:
    """Estimate the noise [px] of matches, (M, 2) px each, from the half of them that one geometry fits best.

    Raises ValueError with fewer than MIN_MATCHES.
    """
    count = len(left)
    if count < MIN_MATCHES:
        raise ValueError(f"needs {MIN_MATCHES} matches, got {count}")
    distances = [_concentrate(_sample_affine(left, right, rng), affine_distance, left, right)]
    if count >= MIN_MATCHES_F:
        distances.append(_concentrate(_sample_fundamental(left, right, rng), fundamental_distance, left, right))
    return _median_std(count) * min(float(np.median(one)) for one in distances)


def fit_geometry(left: NDArray[np.float64], right: NDArray[np.float64], rounding_px: float = 0.0) -> GeometryFit:
    """Fit an epipolar geometry to inliers, (M, 2) px each.

    It is affine, or a fundamental matrix if an F-test of the further parameters asks for it and the matches are enough.
    rounding_px: standard deviation of rounding errors of a coordinate, which equal rows hide.
    """
    count = len(left)
    min_px = MIN_THRESHOLD_PX if count >= MIN_MATCHES_F else MIN_THRESHOLD_FEW_PX
    distance, n_parameters, squares = affine_distance, 4, _sum_of_squares(affine_distance(left, right))
    if count >= MIN_MATCHES_F:
        squares_F = _sum_of_squares(fundamental_distance(left, right))
        if (squares - squares_F) / 3 > MIN_F_RATIO * squares_F / (count - 7):
            distance, n_parameters, squares = fundamental_distance, 7, squares_F
    std = max(float(np.sqrt(squares / (count - n_parameters))), min_px / OUTLIER_SIGMA, rounding_px)
    if count < N_LOW_LEVERAGE:
        return GeometryFit(lambda l, r: _added_distance(distance, left, right, l, r), std, _threshold(count))
    return GeometryFit(lambda l, r: distance(left, right, l, r), std, _threshold(count))


def fit_row_geometry(left: NDArray[np.float64], right: NDArray[np.float64], rounding_px: float) -> GeometryFit | None:
    """Fit equal rows with an offset, as of parallel cameras: the one geometry that few matches determine.

    left, right: (M, 2) px; rounding_px: as of `fit_geometry`. None if most matches do not lie in equal rows.
    """
    below = right[:, 1] - left[:, 1]
    offset = float(np.median(below))
    distances = np.abs(below - offset) / np.sqrt(2)
    std = max(_median_std(len(distances)) * float(np.median(distances)), rounding_px, MIN_THRESHOLD_PX / OUTLIER_SIGMA)
    if std > MAX_ROW_STD_PX:
        return None
    threshold = _threshold(len(distances))
    farthest = float(distances[distances <= threshold * std].max()) / std
    row_distance = lambda l, r: (r[:, 1] - l[:, 1] - offset) / np.sqrt(2)
    return GeometryFit(row_distance, std, max(threshold, GAP_FACTOR * farthest))


def affine_distance(
    left: NDArray[np.float64], right: NDArray[np.float64], *other: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Signed distances (M,) px from the affine geometry fitted to matches (n, 2) px, of these or `other` matches."""
    f, f33 = fit_affine_fundamental(left, right)
    left, right = other or (left, right)
    return left @ f[:2] + right @ f[2:] + f33


def fundamental_distance(
    left: NDArray[np.float64], right: NDArray[np.float64], *other: NDArray[np.float64]
) -> NDArray[np.float64]:
    """As `affine_distance`, Sampson's distances from the fundamental matrix."""
    return sampson_distance(fit_fundamental(left, right), *(other or (left, right)))


def _outliers_of(
    distances: NDArray, distance: Callable, left: NDArray, right: NDArray, noise_px: float, min_px: float
) -> list[NDArray]:
    """[(M,) bool] of the outliers of one kind of geometry; [] if it does not fit.

    distances: (M,) px from the best sample.
    """
    distances = _concentrate(distances, distance, left, right)
    for _ in range(N_CONCENTRATIONS):
        std = max(noise_px, _median_std(len(distances)) * float(np.median(distances)))
        wrong = distances > max(min_px, OUTLIER_SIGMA * std)
        max_std = max(MIN_THRESHOLD_PX * _unit(left, right), MAX_STD_RATIO * noise_px)
        if std > max_std or (~wrong).sum() < MIN_MATCHES:
            return []
        distances = np.abs(distance(left[~wrong], right[~wrong], left, right))
    return [wrong]


def _concentrate(distances: NDArray, distance: Callable, left: NDArray, right: NDArray) -> NDArray:
    """(M,) px: distances from the geometry of the nearest half, found by concentration steps."""
    for _ in range(N_CONCENTRATIONS):
        half = distances <= np.median(distances)
        distances = np.abs(distance(left[half], right[half], left, right))
    return distances


def _added_distance(distance: Callable, left: NDArray, right: NDArray, *more: NDArray) -> NDArray:
    """(M,) px: root of the squares that each further match, (M, 2) px, adds to a fit that includes it.

    It is large for a match that is far from all others, which is off any geometry that was fitted without it.
    """
    squares = _sum_of_squares(distance(left, right))
    each = zip(
        *(np.concatenate([np.repeat(of[None], len(one), 0), one[:, None]], 1) for of, one in zip((left, right), more))
    )
    return np.sqrt(np.maximum([_sum_of_squares(distance(*both)) - squares for both in each], 0.0))


def _median_std(count: int) -> float:
    """Factor from the median of |x| to the standard deviation, with the small-sample correction of Rousseeuw (1984)."""
    return MAD_TO_STD * (1 + 5 / count)


def _threshold(count: int) -> float:
    """In standard deviations, for a deviation that was estimated from so few matches."""
    return OUTLIER_SIGMA * (1 + (N_UNCERTAIN_STD / count) ** 2)


def _unit(left: NDArray, right: NDArray) -> float:
    return image_unit(np.concatenate([left, right], 1))


def _sum_of_squares(distances: NDArray) -> float:
    return float(distances @ distances)


def _sample_affine(left: NDArray, right: NDArray, rng: np.random.Generator) -> NDArray:
    """(M,) px: distances from the geometry of the best sample of four matches."""
    matches = np.concatenate([left, right], 1)
    matches = matches - np.median(matches, 0)
    rows = np.concatenate([matches, np.ones((len(matches), 1))], 1)
    found = np.linalg.svd(rows[_samples(rng, N_SAMPLES, len(rows), 4)])[2][:, -1]
    return _best(np.abs(rows @ found.T).T / np.maximum(np.linalg.norm(found[:, :4], axis=1), 1e-12)[:, None])


def _sample_fundamental(left: NDArray, right: NDArray, rng: np.random.Generator) -> NDArray:
    """(M,) px: distances from the geometry of the best sample of eight matches."""
    centres = np.median(left, 0), np.median(right, 0)
    scale = max(float(np.median(np.abs(left - centres[0]))), 1e-12)
    l, r = (homogeneous((points - centre) / scale) for points, centre in zip((left, right), centres))
    rows = (r[:, :, None] * l[:, None, :]).reshape(-1, 9)
    found = np.linalg.svd(rows[_samples(rng, N_SAMPLES_F, len(rows), 8)])[2][:, -1]
    F = found.reshape(-1, 3, 3)
    gradient = ((l @ np.swapaxes(F, 1, 2))[..., :2] ** 2).sum(-1) + ((r @ F)[..., :2] ** 2).sum(-1)
    return _best(scale * np.abs(rows @ found.T).T / np.sqrt(np.maximum(gradient, 1e-300)))


def _samples(rng: np.random.Generator, n_samples: int, count: int, size: int) -> NDArray:
    """(n_samples, size) different indices below count."""
    return rng.random((n_samples, count)).argpartition(size, axis=1)[:, :size]


def _best(distances: NDArray) -> NDArray:
    """The row of distances (n_samples, M) whose median is smallest."""
    return distances[np.median(distances, 1).argmin()]
