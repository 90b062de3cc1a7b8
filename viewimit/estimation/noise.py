"""Noise of image points: how it propagates to residuals, how residuals are whitened, and which E it explains.

Theory
------
Let the noise of every image coordinate be independent and normal, with standard deviation σ in the demonstrator's
images and √κ σ in the own ones; κ is `own_variance_ratio`. To first order the residual e_i of point i at the true
posture is normal with covariance σ² Σ_i. Residuals are rows. With C Cᵀ = Σ_i⁻¹, the whitened residual e_i C has
covariance σ² I, and its squared length is the squared Mahalanobis distance e_i Σ_i⁻¹ e_iᵀ. A fit removes as many
combinations of residuals as it has parameters, so Σ|e_i C|² = 2N E is σ² χ²_f, where f is the number of residual
coordinates minus that of the parameters.

Two models of Σ_i are in use, and only here:

- Affine cameras. Own points follow from the demonstrator's by a linear map B (4 x 4), so that Σ = κ I + BᵀB for all
  points: `affine_whitening`. f = 4 (N - 4).
- Rectified pinhole cameras. A pair of views of a point is a triple t = (x_L, (y_L + y_R)/2, x_R): the point in space up
  to a projective map. So the demonstrator's images follow from the own ones by one homography G of space,
  ẑ_i = G [t_i; 1], read as (x_l, y, x_r, y). The residual z_i - ẑ_i has Σ_i = D_i D_iᵀ + κ K_i K_iᵀ, where D_i is the
  derivative of the rectification at the demonstrator's point, and K_i that of ẑ_i by the own point, both in px per px:
  `HomographyResiduals`. f = 4N - 15. A point that one camera alone sees has the two coordinates of that image, with
  their block of Σ_i (the marginal distribution; its inverse is the Schur complement in Σ_i⁻¹), so f is 2 less.

Σ_i is evaluated at one own image and then held constant. Evaluated at each posture, it would create minima of its own.
Far from that image it may be nearly singular.

References
----------
Hartley and Zisserman, Multiple View Geometry, 2nd ed. 2003, sections 4.2 (Mahalanobis distance), 5.2 (propagation).
Paulson, An approximate normalization of the analysis of variance distribution, Annals of Math. Statistics 13, 1942.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..geometry.affine import image_unit
from ..geometry.rectification import MIN_DENOMINATOR, Rectification
from .residuals import NoiseReference, conflict
from .transfers import linear
from .views import FourViews

Array = NDArray[np.float64]

GAUSS_NEWTON_STEPS = 3
DAMPING = 1e-10  # added to the diagonal of the normal equations, times its mean
DIFFERENCE_UNITS = 1e-3  # step of difference quotients, in image units (`geometry.affine.image_unit`)
TO_TRIPLE = np.array([[1, 0, 0, 0], [0, 0.5, 0, 0.5], [0, 0, 1, 0]])
TO_PAIR = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1], [0, 1, 0]])

NEAR_FRACTION = 1e-3  # E over the demonstrator's mean square, up to which own images are near: Σ_i holds there
NEAR_VARIANCES = 400.0  # E over the noise's variance, up to which own images are near, if that is larger

GRID_PARTS = 5040  # of a px: halves to tenths are whole numbers of these, and sixteenths, as of images scaled to 256 px
MIN_GRID_COORDINATES = 5  # different coordinates that show a grid; off any grid, 1 in 10⁸ has a step of MIN_STEP_PX
GRID_SCALES = 1.0, 10.0, 100.0, 1000.0  # px per unit of the coordinates, which may be normalised: tried in turn
MAX_EXTENT_PX = 50.0  # the next scale is tried only while the scaled points extend over less than this
MIN_STEP_PX, MAX_STEP_PX = 0.1, 8.0  # grid steps: finer ones are harmless; coarser ones are an order of the points


def conflict_quantile(n_points: int, degrees_of_freedom: int, noise_px: float, n_sigma: float) -> float:
    """Compute the E that noise exceeds only with the probability of n_sigma standard deviations.

    Parameters
    ----------
    n_points : int
        Points N that make E.
    degrees_of_freedom : int
        Residual coordinates minus fitted parameters.
    noise_px : float
        Standard deviation of a whitened residual coordinate [px].
    n_sigma : float
        Standard normal quantile; 2 means that noise exceeds the result in 2.3 % of cases.

    Returns
    -------
    float
        E [px²]: a quantile of χ², by the approximation of Wilson and Hilferty (1931).
    """
    variance = 2 / (9 * degrees_of_freedom)
    chi2 = degrees_of_freedom * (1 - variance + n_sigma * np.sqrt(variance)) ** 3
    return float(noise_px**2 * chi2 / (2 * n_points))


def f_test_sigmas(ratio: float, numerator: int, denominator: int) -> float:
    """Convert a ratio of two variances to standard deviations of a normal variable.

    Parameters
    ----------
    ratio : float
        Of two independent mean squares with the same expectation.
    numerator, denominator : int
        Their degrees of freedom.

    Returns
    -------
    float
        The standard normal quantile of F, by the approximation of Paulson (1942); 3.09 is exceeded once in a thousand.
    """
    root, a, b = np.cbrt(ratio), 2 / (9 * numerator), 2 / (9 * denominator)
    return float(((1 - b) * root - (1 - a)) / np.sqrt(a + b * root**2))


def affine_whitening(views: FourViews, own_variance_ratio: float = 1.0) -> Array:
    """Compute C with C Cᵀ = (κ I + BᵀB)⁻¹, which whitens residuals e (..., N, 4) of affine cameras as e C. views:
    points visible in all views, (..., N, 4) px; B maps centred [l; r] to [L; R]; own_variance_ratio: κ, variance of the
    own images over that of the demonstrator's. Returns (..., 4, 4)."""
    B = np.swapaxes(linear.fit(views).matrix, -1, -2)
    return np.linalg.cholesky(np.linalg.inv(own_variance_ratio * np.eye(4) + np.swapaxes(B, -1, -2) @ B))


@dataclass(frozen=True)
class HomographyResiduals:
    """Residuals of the demonstrator's images by the maximum-likelihood homography of space, for rectified views."""

    rectification: Rectification  # of all images
    frame: "_Frame"  # in which the homography is fitted
    weight: Array  # (N, 4, 4): Cᵀ, which whitens residuals as columns; C Cᵀ = Σ_i⁻¹, 0 for invisible coordinates

    @classmethod
    def whitened_at(
        cls, views: FourViews, rectification: Rectification, own_variance_ratio: float
    ) -> "HomographyResiduals":
        """Whiten by the noise about one own image.

        Parameters
        ----------
        views : FourViews
            One posture, (N, 4) px; Σ_i is evaluated at its own images.
        rectification : Rectification
            Of all images.
        own_variance_ratio : float
            κ, variance of the own images over that of the demonstrator's.
        """
        unweighted = cls.unweighted(views, rectification)
        z, t, frame = _demo(rectification, views), _triples(rectification, views.own), unweighted.frame
        G = _fit(z, t, unweighted.weight, frame)
        step_px = DIFFERENCE_UNITS * image_unit(views.own)
        steps = step_px * np.eye(4)
        moved = [_mapped(G, _triples(rectification, views.own + step), frame) for step in steps]
        K = (np.stack(moved, -1) - _mapped(G, t, frame)[..., None]) / step_px
        stepped = [_demo(rectification, replace(views, demo=views.demo + step)) for step in steps]
        D = (np.stack(stepped, -1) - z[..., None]) / step_px
        covariance = D @ np.swapaxes(D, -1, -2) + own_variance_ratio * K @ np.swapaxes(K, -1, -2)
        return cls(rectification, frame, _whitening(covariance, views.visible[:, :2]))

    @classmethod
    def unweighted(cls, views: FourViews, rectification: Rectification) -> "HomographyResiduals":
        """Give all points equal weights.

        Both images of a point have the same row y. Where both are visible, each y has half the weight.
        """
        n_images, ones = views.visible[:, :2].sum(1), np.ones(len(views.demo))
        covariance = np.stack([ones, n_images, ones, n_images], 1)[:, None] * np.eye(4)
        frame = _Frame.of(_demo(rectification, views), _triples(rectification, views.own.reshape(-1, 4)))
        return cls(rectification, frame, _whitening(covariance, views.visible[:, :2]))

    def residual(self, views: FourViews) -> Array:
        """Compute whitened residuals (..., N, 4) in px of the images as seen, of own (..., N, 4) px, demo (N, 4) px."""
        z, t = _demo(self.rectification, views), _triples(self.rectification, views.own)
        e = z - _mapped(_fit(z, t, self.weight, self.frame), t, self.frame)
        return np.einsum("nij,...nj->...ni", self.weight, e)


class HomographyWeighting:
    """Chooses the weights of `HomographyResiduals` for one demonstrator and one geometry of the stereo head.

    Near the demonstrator's posture they are those of the noise about the reference. Elsewhere, and for a reference
    without images, all points have equal weights.
    """

    def __init__(self, rectification: Rectification, noise_px: float):
        self._rectification, self._noise_px = rectification, noise_px
        self._cache: dict[tuple[bytes, float, bytes], HomographyResiduals] = {}  # a servo asks often with one reference

    def of(self, views: FourViews, points: NDArray[np.bool_], reference: NoiseReference | None) -> HomographyResiduals:
        """Return the residuals of views that hold only these points of the body, (N,) bool."""
        if reference is None or reference.own is None:
            return HomographyResiduals.unweighted(views, self._rectification)
        key = reference.own.tobytes(), reference.own_variance_ratio, points.tobytes()
        if key not in self._cache:
            self._cache[key] = self._about(views.with_own(reference.own[points]), reference.own_variance_ratio)
        return self._cache[key]

    def _about(self, views: FourViews, own_variance_ratio: float) -> HomographyResiduals:
        unweighted = HomographyResiduals.unweighted(views, self._rectification)
        E, demo = float(conflict(unweighted.residual(views))), views.demo[views.visible[:, :2].all(1)]
        near = max(NEAR_FRACTION * float(demo.var(0).sum()), NEAR_VARIANCES * self._noise_px**2)
        if E < near:
            return HomographyResiduals.whitened_at(views, self._rectification, own_variance_ratio)
        return unweighted


def _demo(rectification: Rectification, views: FourViews) -> Array:
    """Rectify the demonstrator's points, (N, 4) px. A missing image is placed at the mean depth of the other points."""
    visible = views.visible[:, :2]
    if visible.all():
        return rectification.apply(views.demo)
    z = rectification.apply(np.nan_to_num(views.demo))
    left, right = z[:, :2], z[:, 2:]
    disparity = (right - left)[visible.all(1)].mean(0) * [1, 0]
    return np.concatenate(
        [np.where(visible[:, :1], left, right - disparity), np.where(visible[:, 1:], right, left + disparity)], 1
    )


def _whitening(covariance: Array, visible: NDArray[np.bool_]) -> Array:
    """Compute Cᵀ of the visible coordinates, C Cᵀ = Σ⁻¹, else 0. covariance: (N, 4, 4); visible: (N, 2)."""
    coordinates = np.repeat(visible, 2, 1)
    both = coordinates[:, :, None] & coordinates[:, None, :]
    cholesky = np.linalg.cholesky(np.where(both | np.eye(4, dtype=bool), covariance, 0.0))
    weight = np.asarray(np.linalg.inv(cholesky), float)
    return weight if visible.all() else np.where(both, weight, 0.0)


def _triples(rectification: Rectification, own: Array) -> Array:
    """(..., N, 4) px → (..., N, 3) rectified px."""
    return rectification.apply(own) @ TO_TRIPLE.T


@dataclass(frozen=True)
class _Frame:
    """Normalised coordinates, in which the normal equations are well conditioned."""

    own_mean: Array  # (3,) px, of triples
    own_scale: float  # px
    demo_mean: Array  # (3,) px
    demo_scale: float  # px

    @classmethod
    def of(cls, z: Array, t: Array) -> "_Frame":
        """z: (N, 4), t: (N, 3) rectified px."""
        demo = z @ TO_TRIPLE.T
        return cls(t.mean(0), float(t.std()), demo.mean(0), float(demo.std()))


def _fit(z: Array, t: Array, weight: Array, frame: _Frame) -> Array:
    """Fit G, (..., 4, 4) in the frame, by Gauss and Newton. z: (N, 4), t: (..., N, 3) rectified px."""
    h = _homogeneous((t - frame.own_mean) / frame.own_scale)
    triple = (z @ TO_TRIPLE.T - frame.demo_mean) / frame.demo_scale
    target = (z - TO_PAIR @ frame.demo_mean) / frame.demo_scale
    hh = (h[..., :, None] * h[..., None, :]).reshape(*h.shape[:-1], 16)
    A = weight @ TO_PAIR  # (N, 4, 3): derivative by ẑ's three coordinates
    # Start: with the depth taken as 1 and ẑ in its place as observed, the equations are linear in G
    M = _normal(np.concatenate([A, -(A @ triple[:, :, None])], -1), hh, None)
    G = np.zeros(M.shape[:-1])
    G[..., 15] = 1.0
    G[..., :15] = np.linalg.solve(_damped(M[..., :15, :15]), -M[..., :15, 15:])[..., 0]
    G = G.reshape(*M.shape[:-2], 4, 4)
    for _ in range(GAUSS_NEWTON_STEPS):
        q = h @ np.swapaxes(G, -1, -2)
        depth = np.maximum(q[..., 3], MIN_DENOMINATOR)
        found = q[..., :3] / depth[..., None]
        e = np.einsum("nij,...nj->...ni", weight, target - found @ TO_PAIR.T)
        B = np.concatenate([np.broadcast_to(A, found.shape[:-1] + (4, 3)), -(A @ found[..., None])], -1)
        M = _normal(B, hh, depth)
        gauge = G.reshape(*G.shape[:-2], 16)
        M = M + gauge[..., :, None] * gauge[..., None, :]  # G's scale is a gauge freedom
        slope = np.einsum("...nba,...nb,...nc->...ac", B, e, h / depth[..., None])
        G = G + np.linalg.solve(_damped(M), slope.reshape(*G.shape[:-2], 16, 1)).reshape(G.shape)
        G = G / np.maximum(np.abs(G[..., 3:, 3:]), MIN_DENOMINATOR)
    return G


def _mapped(G: Array, t: Array, frame: _Frame) -> Array:
    """ẑ, (..., N, 4) rectified px, of triples t (..., N, 3)."""
    q = _homogeneous((t - frame.own_mean) / frame.own_scale) @ np.swapaxes(G, -1, -2)
    triple = q[..., :3] / np.maximum(q[..., 3:], MIN_DENOMINATOR) * frame.demo_scale + frame.demo_mean
    return triple @ TO_PAIR.T


def _normal(B: Array, hh: Array, depth: Array | None) -> Array:
    """Σ_n BᵀB ⊗ h hᵀ / depth²: (..., 16, 16). B: (..., N, 4, 4), hh: (..., N, 16), depth: (..., N)."""
    BB = (np.swapaxes(B, -1, -2) @ B).reshape(*B.shape[:-2], 16)
    if depth is not None:
        hh = hh / (depth * depth)[..., None]
    blocks = np.swapaxes(BB, -1, -2) @ hh
    blocks = blocks.reshape(*blocks.shape[:-2], 4, 4, 4, 4)
    return np.swapaxes(blocks, -3, -2).reshape(*blocks.shape[:-4], 16, 16)


def _damped(M: Array) -> Array:
    size = np.trace(M, axis1=-2, axis2=-1)[..., None, None] / M.shape[-1]
    return M + DAMPING * size * np.eye(M.shape[-1])


def _homogeneous(points: Array) -> Array:
    return np.concatenate([points, np.ones(points.shape[:-1] + (1,))], -1)


def rounding_std(points: Array, visible: NDArray[np.bool_]) -> float:
    """Compute the noise that rounding to whole pixels, or to another grid, has left.

    Images at rest do not show it: they are rounded alike. Rows of parallel cameras even hide it: most are equal to the
    last bit, and the others one step off. points: (..., N, 2 v) points in v views [px]. Each coordinate of each view
    has a grid of its own, with any origin; visible: (..., N, v). Returns standard deviation of a coordinate [px], root
    mean square of all, step/√12 each; 0 without a grid.
    """
    shown = np.repeat(visible, 2, -1)
    each = [points[..., k][shown[..., k]] for k in range(points.shape[-1])]
    largest = max((float(np.ptp(coordinates)) for coordinates in each if len(coordinates)), default=0.0)
    for scale in GRID_SCALES:
        steps = [step for coordinates in each if (step := _grid_step(coordinates * scale)) is not None]
        if any(steps) or not largest * scale < MAX_EXTENT_PX:
            break
    return float(np.sqrt(np.mean(np.square(steps)) / 12)) / scale if steps else 0.0


def _grid_step(coordinates: Array) -> float | None:
    """Largest step [px] of which all distances are multiples, 0 without one; None for too few coordinates."""
    parts = np.unique(np.round(coordinates * GRID_PARTS).astype(np.int64))
    if len(parts) < MIN_GRID_COORDINATES:
        return None
    step = float(np.gcd.reduce(np.diff(parts))) / GRID_PARTS
    if step > MAX_STEP_PX:
        return None
    return step if step > MIN_STEP_PX else 0.0


def views_rounding_std(views: FourViews) -> float:
    """Compute `rounding_std` of all four views [px]."""
    return rounding_std(np.concatenate([views.demo, views.own], -1), views.visible)
