"""Kinematics of an arm that stops short of where it is sent, and of images that a lens bends.

Either may be why no kinematics explain the own images, or not the demonstrator's. A few unknowns more are adjusted with
the kinematics (`bundle`).

An arm that stops short makes a share 1 - s of the way from where it is to where it is sent, all joints alike:

    θ_k = θ_{k-1} + (1 - s)(sent_k - θ_{k-1}).

With s < 0 it goes too far. A lens bends images. Without it the point p would be at

    p + κ |p - c|²/R² (p - c),

the first term of the inverse of a radial distortion with the centre c (Hartley and Kang 2007). R is the rms distance of
all image points from their mean. Both cameras share κ, and each has its own c.

References
----------
Hartley and Kang, "Parameter-free radial distortion correction with center of distortion estimation", PAMI 29(8), 2007.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..rectification import Rectification
from .adjustment import NEAR_RAD, BundleAdjustment, is_of_parallel_cameras
from .bundle import levenberg_marquardt
from .chains import with_likely_chains
from .clusters import Observations
from .model import ProjectiveKinematics, StereoFrame

Array = NDArray[np.float64]
FIRST_SHARES = 0.15, 0.3, -0.15  # that a fit begins from
SHARES = 0.01, 0.45  # of a motion: an arm that misses less reaches where it is sent; one that misses more is broken
MAX_SHARE = 0.5  # that a fit tries
MIN_SEEN = 0.5  # of the points, that all visits near the first one must show
MOVED_SHARE = 0.1  # of the fastest point's motion with a joint, from which that joint is taken to move a point
ROUNDS = 4  # of letting points be moved by other joints
MAX_ITER, FTOL = 60, 1e-5
CENTRE_STD = 1.0  # of a lens's centre about the mean of the points, in R, where noise leaves it open
N_LENS = 5  # κ, and the centre in either image


@dataclass(frozen=True)
class Shortfall:
    """An arm that stops short."""

    share: float  # s

    def reached(self, sent: Array) -> Array:
        """Return where the arm is after each motion, (K, m) rad, of where it was sent, (K, m) rad."""
        return _reached(sent, np.asarray(self.share))

    def to_reach(self, here: Array, target: Array) -> Array:
        """Return where to send it from a posture, (m,) rad, to reach another one."""
        return here + (target - here) / (1 - self.share)


def _reached(sent: Array, share: Array) -> Array:
    """(K, m) rad and (...) → (..., K, m) rad."""
    way = 1 - share[..., None]
    reached = [np.broadcast_to(sent[0], (*share.shape, sent.shape[1]))]
    for to in sent[1:]:
        reached.append(reached[-1] + way * (to - reached[-1]))
    return np.stack(reached, -2)


@dataclass(frozen=True)
class Lens:
    """A lens of both cameras. Several at once have leading axes in bend and centre."""

    bend: Array  # (...): κ
    centre: Array  # (..., 4): c from the mean, in R
    mean: Array  # (4,) px, of all image points
    radius_px: float  # R

    def straightened(self, images: Array) -> Array:
        """Images (K, N, 4) px without the distortion, (..., K, N, 4) px."""
        off = (images - self.mean) / self.radius_px - self.centre[..., None, None, :]
        pairs = off.reshape(*off.shape[:-1], 2, 2)
        bent = self.bend[..., None, None, None, None] * (pairs**2).sum(-1, keepdims=True) * pairs
        return images + self.radius_px * bent.reshape(off.shape)


@dataclass(frozen=True)
class Extended:
    """Kinematics, or a pair of bodies, with unknowns more, as `bundle` adjusts them."""

    parameters: Array  # (..., P + n): of the kinematics, and n more
    points: Array  # (..., N, 3)
    kinematics: Any  # ProjectiveKinematics or BodyPair, whose parameters and points these replace

    @property
    def body(self) -> Any:
        return replace(self.kinematics, parameters=self.parameters[..., : self._n], points=self.points)

    @property
    def more(self) -> Array:
        """(..., n)."""
        return self.parameters[..., self._n :]

    @property
    def _n(self) -> int:
        return self.kinematics.parameters.shape[-1]


def _adjusted(
    kinematics: ProjectiveKinematics,
    more: Array,
    residuals_of: Callable[[Extended], Array],
    problem: BundleAdjustment,
    prior: Array,
) -> tuple[ProjectiveKinematics, Array]:
    """Adjust kinematics and (n,) unknowns more, which have the prior weights (n,) px²."""
    initial = Extended(np.concatenate([kinematics.parameters, more]), kinematics.points, kinematics)
    weights = np.concatenate([problem.prior_weights(len(kinematics.parameters)), prior])
    found = levenberg_marquardt(initial, residuals_of, weights, FTOL, MAX_ITER)
    return found.body, found.more


def fit_shortfall(
    sent: Observations,
    noise_px: float,
    rectification: Rectification | None = None,
    previous: tuple[ProjectiveKinematics, Shortfall] | None = None,
) -> tuple[ProjectiveKinematics, Shortfall] | None:
    """Fit kinematics of an arm that stops short of where it is sent.

    Parameters
    ----------
    sent : Observations
        Images of K visits, in the order of the motions, and where the arm was sent.
    noise_px : float
        Standard deviation of an image coordinate.
    rectification : Rectification, optional
        Of the images.
    previous : tuple, optional
        What explained all visits but the last one.

    Returns
    -------
    tuple or None
        Kinematics that explain the images where the arm has been, and how short it stops. None if there are none, or
        the arm reaches where it is sent.
    """
    images = np.where(sent.visible_in_both[..., None], sent.images, 0.0)
    if previous is not None and (previous[0].rectification is None) == (rectification is None):
        kinematics, shortfall = replace(previous[0], rectification=rectification), previous[1]
        problem = BundleAdjustment.of(kinematics, sent, noise_px).restricted_to_known(kinematics)
        found = _fit_shortfall(kinematics, shortfall.share, problem)
        if found is not None and SHARES[0] < abs(found[1].share) < SHARES[1]:
            return found
    images = images if rectification is None else rectification.apply(images)
    frame = StereoFrame.fit(images[sent.visible_in_both])
    if not is_of_parallel_cameras(frame, noise_px):
        return None
    near = np.abs(sent.displacement - sent.displacement[0]).max(1) < NEAR_RAD
    seen = sent.visible_in_both[near].all(0)
    if near.sum() <= sent.displacement.shape[1] or seen.mean() < MIN_SEEN:
        return None
    initial = ProjectiveKinematics.initial(len(seen), sent.displacement[0], frame, rectification)
    problem = BundleAdjustment.of(initial, sent.restrict(seen), noise_px)
    if problem.degrees_of_freedom < 2:
        return None
    for first in FIRST_SHARES:
        reached = Shortfall(first).reached(sent.displacement)
        rates = np.linalg.lstsq(reached[near] - reached[0], (images[near] - images[0]).reshape(near.sum(), -1))[0]
        rates = np.abs(rates).reshape(-1, *images.shape[1:]).max(-1).T * seen[:, None]  # (N, m)
        moved_by = rates > MOVED_SHARE * rates.max(0)
        kinematics = replace(initial, moved_by=moved_by).with_points(seen, problem.observations, problem.coordinates)
        found = _fit_shortfall(kinematics, first, problem)
        if found is not None and SHARES[0] < abs(found[1].share) < SHARES[1]:
            return None if problem.solve(found[0]) is not None else found
    return None


def _fit_shortfall(
    kinematics: ProjectiveKinematics, share: float, problem: BundleAdjustment
) -> tuple[ProjectiveKinematics, Shortfall] | None:
    """Fit from initial kinematics, and let points that contradict be moved by other joints."""
    sent = problem.observations.displacement

    def bounded(more: Array) -> Array:
        """Shares of unbounded unknowns: a share of 2 or more would let the arm swing farther from motion to motion."""
        return MAX_SHARE * np.tanh(more[..., 0])

    def residuals(model: Extended) -> Array:
        return problem.residuals(model.body, _reached(sent, bounded(model.more)))

    more = np.arctanh([share / MAX_SHARE])
    for _ in range(ROUNDS):
        if not kinematics.moved_by.any(0).all():  # A joint that moves no point has no kinematics.
            break
        kinematics, more = _adjusted(kinematics, more, residuals, problem, np.zeros(1))
        found = Shortfall(float(bounded(more)))
        there = replace(problem, observations=replace(problem.observations, displacement=found.reached(sent)))
        if there.fits_noise(kinematics):
            return kinematics, found
        before, seen = kinematics, np.asarray(there.observations.visible_in_both.any(0))
        kinematics = with_likely_chains(kinematics, there, seen)
        if kinematics is before:
            break
    return None


def fit_lens(
    observations: Observations,
    noise_px: float,
    moved_by: NDArray[np.bool_],
    known: NDArray[np.bool_],
    rectification: Rectification | None = None,
) -> tuple[ProjectiveKinematics, Lens] | None:
    """Fit kinematics to images that a lens bends.

    Parameters
    ----------
    observations : Observations
        Images of K visits.
    noise_px : float
        Standard deviation of an image coordinate.
    moved_by : (N, m) array of bool
        Which joints move a point.
    known : (N,) array of bool
        For which points this is known. The others are left out.
    rectification : Rectification, optional
        Of the images, which is left out if straight images need none.

    Returns
    -------
    tuple or None
        Kinematics that explain the straight images, and the lens; None if the images do not determine them.
    """
    seen = observations.restrict(known)
    images = np.where(seen.visible_in_both[..., None], seen.images, 0.0)
    shown = images[seen.visible_in_both]
    mean = shown.mean(0)
    flat = Lens(np.zeros(()), np.zeros(N_LENS - 1), mean, float(np.sqrt(((shown - mean) ** 2).sum(1).mean() / 2)))
    for rectified in (None,) if rectification is None else (None, rectification):
        frame = StereoFrame.fit(shown if rectified is None else rectified.apply(shown))
        kinematics = ProjectiveKinematics.initial(len(known), seen.displacement[0], frame, rectified)
        kinematics = replace(kinematics, moved_by=moved_by)
        problem = BundleAdjustment.of(kinematics, seen, noise_px)
        if problem.degrees_of_freedom <= N_LENS:
            return None
        kinematics = kinematics.with_points(known, seen, problem.coordinates)
        kinematics, lens, straight = _fit_lens(kinematics, flat, problem, images)
        bent_back = lens.straightened(images)[seen.visible_in_both]
        is_straight = rectified is not None or is_of_parallel_cameras(StereoFrame.fit(bent_back), noise_px)
        if straight.fits_noise(kinematics) and is_straight:
            return kinematics, lens
    return None


def _fit_lens(
    kinematics: ProjectiveKinematics, flat: Lens, problem: BundleAdjustment, images: Array
) -> tuple[ProjectiveKinematics, Lens, BundleAdjustment]:
    """Fit from initial kinematics and a lens that bends nothing. Returns the problem of the straight images, too."""

    def lens(more: Array) -> Lens:
        return replace(flat, bend=more[..., 0], centre=more[..., 1:])

    def residuals(model: Extended) -> Array:
        coordinates = kinematics.coordinates_of(lens(model.more).straightened(images))
        return replace(problem, coordinates=coordinates).residuals(model.body)

    prior = np.append(0.0, np.full(N_LENS - 1, (problem.noise_px / CENTRE_STD) ** 2))
    start = levenberg_marquardt(kinematics, problem.residuals, problem.prior_weights(len(kinematics.parameters)))
    found, more = _adjusted(start, np.zeros(N_LENS), residuals, problem, prior)
    straight = replace(problem, coordinates=kinematics.coordinates_of(lens(more).straightened(images)))
    return found, lens(more), straight
