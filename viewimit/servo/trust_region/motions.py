"""Postures that the trust region may go to: beside a posture, on a line, or far from all visits."""

import numpy as np
from numpy.typing import NDArray

from ..observation import Observation, Visit
from .convergence import ROUNDING

Postures = NDArray[np.float64]
VERIFICATION_SIDES = (1.0, -1.0, 0.5, -0.5)  # of a verification step, with noise


def offset_inside_limits(observation: Observation, place: Postures, offset: Postures) -> Postures:
    """Return place + offset, or place - offset where the limits leave more room there: (m,) rad."""
    either = np.clip(np.stack([place + offset, place - offset]), observation.lower, observation.upper)
    return either[_first_largest(np.abs(either - place).sum(1))]


def farthest_offset(visits: tuple[Visit, ...], observation: Observation, place: Postures, offset: Postures) -> Postures:
    """Return the posture on either side of a place that is farthest from all visits: (m,) rad.

    Images of many postures average noise; images of one posture again do not.
    """
    sides = place + np.outer(VERIFICATION_SIDES, offset)
    return maximin(visits, np.clip(sides, observation.lower, observation.upper))


def sample_box(observation: Observation, count: int) -> Postures:
    """Draw postures inside the joint limits: (count, m) rad."""
    rng = np.random.default_rng([observation.seed, observation.motion])
    return rng.uniform(observation.lower, observation.upper, (count, len(observation.lower)))


def posture_grid(lower: Postures, upper: Postures, count: int, seed: int) -> Postures:
    """Return `count` postures per joint, (n, m) rad; for three joints or more as many random ones as for two."""
    if len(lower) > 2:
        return np.random.default_rng([seed, count]).uniform(lower, upper, (count**2, len(lower)))
    return np.stack(np.meshgrid(*np.linspace(lower, upper, count).T, indexing="ij"), -1).reshape(-1, len(lower))


def sample_line(observation: Observation, place: Postures, direction: Postures, count: int) -> Postures:
    """Return postures on the line through a place, from limit to limit: (count, m) rad."""
    turned = direction != 0  # the other joints meet no limit
    limits = observation.lower, observation.upper
    ends = np.sort([(limit - place)[turned] / direction[turned] for limit in limits], axis=0)
    return place + np.linspace(ends[0].max(), ends[1].min(), count)[:, None] * direction


def maximin(visits: tuple[Visit, ...], candidates: Postures) -> Postures:
    """Return the candidate, of (k, m) rad, that is farthest from all visits; of equal ones the first."""
    return candidates[_first_largest(distance_to_visits(visits, candidates))]


def distance_to_visits(visits: tuple[Visit, ...], candidates: Postures, rank: int = 1) -> NDArray[np.float64]:
    """Return the distance of each candidate to its nearest visit, or to that of another rank.

    Parameters
    ----------
    visits : tuple of Visit
    candidates : (k, m) array
        Postures [rad].
    rank : int
        1 for the nearest visit, 2 for the second nearest, and so on.

    Returns
    -------
    (k,) array
        Largest joint difference [rad]; inf if there are fewer visits.
    """
    visited = np.array([visit.displacement for visit in visits])
    distances = np.sort(np.abs(candidates[:, None] - visited).max(-1), axis=1)
    return distances[:, rank - 1] if len(visits) >= rank else np.full(len(candidates), np.inf)


def _first_largest(values: NDArray[np.float64]) -> int:
    """Return the index of the largest value [rad], of equal ones the first."""
    return int((values >= values.max() - ROUNDING).argmax())
