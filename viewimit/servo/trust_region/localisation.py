"""Localisation: is the arm where it was sent, and is the body as it was when it was calibrated?

`is_consistent` is an innovation test: are new images consistent with the images recorded during the calibration? A
Gaussian process predicts them, up to a scale of each coordinate's variance. The scale follows from the leave-one-out
errors of the recorded images (Rasmussen and Williams 2006, section 5.4.2); a point of the base hardly moves, so its
scale is small. A shift that all points of an image share is subtracted first, as no transfer depends on it.

`contradicts_command` detects an arm that is not at the commanded posture, as with quantised steps or at a mechanical
stop: an image repeats that should have changed. From then on `localise` estimates the posture from the images. An image
that repeats is the same posture. For another one it is the maximum a posteriori estimate by Gauss-Newton steps, with a
prior of PRIOR_STD_RAD about the commanded posture.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..observation import Visit, repeat_xy
from .gaussian_process import GaussianProcessImages, gram_matrix, kernel

TOL_PX = 0.3  # error of a coordinate that is always accepted
MAX_SHIFT_PX = 10.0  # that all points of an image share: beyond it, old and new images together give a wrong Jacobian
GATE_SIGMA = 6.0  # standard deviations of an innovation beyond which it is inconsistent

SAME_IMAGE_SIGMA = 2.0  # standard deviations of a coordinate, rms, up to which images are the same
CHANGE_FACTOR = 2.0  # of that bound: predicted change of an image beyond which its repetition is a contradiction
MIN_OFFSET_RAD = np.radians(0.1)  # of a joint, below which an offset is not worth new probes
MIN_STD_PX = 1e-3  # replaces a smaller noise
PRIOR_STD_RAD = np.radians(0.3)  # of the posture about the commanded one
MAX_ITER = 4  # Gauss-Newton steps


def is_consistent(calibration: Sequence[Visit], visits: Sequence[Visit], noise_px: float) -> bool:
    """Test whether every visit shows what the calibration predicts.

    Parameters
    ----------
    calibration, visits : sequence of Visit
        Recorded earlier, and since then.
    noise_px : float
        Standard deviation of an image coordinate.
    """
    displacements = np.array([visit.displacement for visit in calibration])
    centre = displacements.mean(0)
    offsets = displacements - centre
    seen = repeat_xy(np.array([visit.seen for visit in calibration])).reshape(len(offsets), -1).T  # (4N, K)
    own = np.array([visit.own for visit in calibration]).reshape(len(offsets), -1).T
    mean = np.where(seen, own, 0.0).sum(1) / np.maximum(seen.sum(1), 1)
    K = np.where(seen[:, :, None] & seen[:, None, :], gram_matrix(offsets, noise_px), np.eye(len(offsets)))
    inverse = np.linalg.inv(K)
    weights = np.einsum("ckl,cl->ck", inverse, np.where(seen, own - mean[:, None], 0.0))
    left_out = np.where(seen, weights**2 / np.diagonal(inverse, axis1=1, axis2=2), 0.0)
    scale, is_often_seen = left_out.max(1), (2 * seen.sum(1) > len(offsets)).reshape(-1, 4).all(1)
    for visit in visits:
        here = visit.displacement - centre
        k = np.where(seen, kernel(here, offsets), 0.0)
        variance = kernel(here, here[None])[0] - np.einsum("ck,ckl,cl->c", k, inverse, k)
        innovation = (visit.own.ravel() - mean - np.einsum("ck,ck->c", k, weights)).reshape(-1, 4)
        std = np.sqrt(scale * np.maximum(variance, 0.0) + 2 * noise_px**2 + TOL_PX**2).reshape(-1, 4)
        compared = visit.seen.all(1) & is_often_seen
        if compared.any() and not _passes_gate(innovation[compared], std[compared]):
            return False
    return True


def _passes_gate(innovation: NDArray[np.float64], std: NDArray[np.float64]) -> bool:
    """Whether innovations (n, 4) px agree with their standard deviations, up to a limited shift of all points."""
    shift = np.median(innovation, 0)
    return bool(np.abs(shift).max() <= MAX_SHIFT_PX and (np.abs(innovation - shift) <= GATE_SIGMA * std).all())


def contradicts_command(visits: Sequence[Visit], here: Visit, noise_px: float) -> bool:
    """Test whether an earlier image repeats although the commanded motion should have changed it.

    here: displaced by the command; noise_px: standard deviation of an image coordinate.
    """
    if len(visits) <= len(here.displacement):
        return False
    displacement = np.array([visit.displacement for visit in visits])
    elsewhere = np.abs(displacement - here.displacement).max(1) > MIN_OFFSET_RAD
    repeated = displacement[_shows_same_image(visits, here, noise_px) & elsewhere]
    if not len(repeated):
        return False
    model = GaussianProcessImages.fit(visits, len(visits) - 1, noise_px)
    model_std = model.prediction_std(here.displacement[None])[0] / (SAME_IMAGE_SIGMA * CHANGE_FACTOR)
    std = np.maximum(model_std, max(noise_px, MIN_STD_PX))
    change = (model.predict(repeated) - model.predict(here.displacement)) / (SAME_IMAGE_SIGMA * std[:, None])
    change = np.abs(np.nan_to_num(change[:, here.seen.all(-1)])).reshape(len(repeated), -1)
    most_change = np.median(change, 1) > 1  # a few wrong points at other visits can predict any change
    return bool((most_change & (np.sqrt((change**2).mean(1)) > CHANGE_FACTOR)).any())


def localise(visits: Sequence[Visit], commanded: Visit, noise_px: float) -> tuple[Visit, bool]:
    """Estimate the posture of an image; return it as a visit, and whether the arm was at that posture before.

    commanded: displaced by the command; noise_px: standard deviation of an image coordinate.
    """
    same = _shows_same_image(visits, commanded, noise_px).nonzero()[0]
    if len(same):
        return Visit(visits[same[-1]].displacement, commanded.own, commanded.seen), True
    model, start = GaussianProcessImages.fit(visits, len(visits) - 1, noise_px), commanded.displacement
    weight = repeat_xy(commanded.seen) / np.hypot(model.prediction_std(start[None])[0], MIN_STD_PX)[:, None]
    theta, prior = start, np.eye(len(start)) / PRIOR_STD_RAD**2
    for _ in range(MAX_ITER):
        residuals = np.nan_to_num(weight * (model.predict(theta) - commanded.own)).ravel()
        J = np.nan_to_num(weight * model.jacobian(theta)).reshape(len(start), -1)
        theta = theta - np.linalg.solve(J @ J.T + prior, J @ residuals + prior @ (theta - start))
    return Visit(theta, commanded.own, commanded.seen), False


def _shows_same_image(visits: Sequence[Visit], here: Visit, noise_px: float) -> NDArray[np.bool_]:
    """(n,) bool: visits whose images equal those here up to noise, in the coordinates seen in both."""
    own, seen = np.array([visit.own for visit in visits]), np.array([visit.seen for visit in visits])
    both = repeat_xy(seen & here.seen)
    square, count = np.where(both, own - here.own, 0.0) ** 2, both.sum((1, 2))
    bound = (SAME_IMAGE_SIGMA * max(noise_px, MIN_STD_PX)) ** 2
    return (count > 0) & (square.sum((1, 2)) <= bound * count)
