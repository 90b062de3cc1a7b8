"""Whether a rehearsal still holds: the images that are seen, against those that it foretells.

A Gaussian process tells how far off its predictions may be, up to a scale for each coordinate, which is known from how
far off it is at each posture rehearsed when it is told of all the others (Rasmussen & Williams 2006, Sec. 5.4.2). A
point of the base hardly ever moves, and is foretold that well. What all points of an image share is taken off first:
no transfer minds where in an image a body is.
"""

import numpy as np
from numpy.typing import NDArray

from ..observation import Visit, by_coordinate
from .surrogate import gram, kernel

HARMLESS_PX = 0.3  # of a coordinate
PANNED_PX = 10.0  # that all points of an image share: beyond that, images of before and after teach wrong slopes
SURPRISING = 6.0  # standard deviations


def holds(rehearsed: tuple[Visit, ...], visits: tuple[Visit, ...], noise_px: float) -> bool:
    """Whether every visit saw what the rehearsal foretells. noise_px: of an image coordinate, standard deviation."""
    displacements = np.array([visit.displacement for visit in rehearsed])
    centre = displacements.mean(0)
    away = displacements - centre
    seen = by_coordinate(np.array([visit.seen for visit in rehearsed])).reshape(len(away), -1).T  # (4N, K)
    own = np.array([visit.own for visit in rehearsed]).reshape(len(away), -1).T
    mean = np.where(seen, own, 0.0).sum(1) / np.maximum(seen.sum(1), 1)
    known = np.where(seen[:, :, None] & seen[:, None, :], gram(away, noise_px), np.eye(len(away)))
    inverse = np.linalg.inv(known)
    weight = np.einsum("ckl,cl->ck", inverse, np.where(seen, own - mean[:, None], 0.0))
    left_out = np.where(seen, weight**2 / np.diagonal(inverse, axis1=1, axis2=2), 0.0)
    scale, often = left_out.max(1), (2 * seen.sum(1) > len(away)).reshape(-1, 4).all(1)
    for visit in visits:
        here = visit.displacement - centre
        k = np.where(seen, kernel(here, away), 0.0)
        variance = kernel(here, here[None])[0] - np.einsum("ck,ckl,cl->c", k, inverse, k)
        off = (visit.own.ravel() - mean - np.einsum("ck,ck->c", k, weight)).reshape(-1, 4)
        spread = np.sqrt(scale * np.maximum(variance, 0.0) + 2 * noise_px**2 + HARMLESS_PX**2).reshape(-1, 4)
        compared = visit.seen.all(1) & often
        if compared.any() and not _foreseen(off[compared], spread[compared]):
            return False
    return True


def _foreseen(off: NDArray, spread: NDArray) -> bool:
    """off, spread: (n, 4) px, of the points compared."""
    shared = np.median(off, 0)
    return bool(np.abs(shared).max() <= PANNED_PX and (np.abs(off - shared) <= SURPRISING * spread).all())
