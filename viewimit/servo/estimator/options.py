"""The options of the estimator. Angles are in radians; what is not an angle has its unit beside it."""

from dataclasses import dataclass

import numpy as np

from .pair_fit import MAX_SIGMAS


def _deg(angle: float) -> float:
    return float(np.radians(angle))


@dataclass(frozen=True)
class EstimatorOptions:
    """Tuning of `Estimator`. All prices are in radians of expected error."""

    # The rule
    max_claimed_error: float = _deg(0.75)  # expected error of the worst joint up to which to claim
    claim_worth: float = _deg(0.5)  # what a claim is worth
    error_spread: float = 0.15  # of the logarithm of an expected error, that is not known better
    price_per_motion: float = _deg(0.012)
    price_per_radian: float = 0.0015  # of way
    lengths: tuple[float, ...] = (_deg(8.0), _deg(15.0))  # of motions about the estimate
    looks: tuple[int, ...] = (1, 2, 4, 8)  # that are foreseen from one place
    next_look: float = _deg(6.0)  # way between looks about one place
    nearest: float = _deg(2.0)  # from all visits: a nearer place shows nothing new
    farthest: float = _deg(115.0)  # from all visits: a farther place shows no more

    # Motions
    exploring: int = 6  # motions a joint to lessen the expected error, at most
    exploring_unexplained: int = 4  # motions a joint while no hypothesis fits, at most
    growing: int = 4  # motions a joint while no body is known, at most
    most: int = 9  # motions a joint after the probes, all in all
    max_visits: int = 60  # that are remembered
    enough_visits: int = 40  # from which a moving demonstrator is followed without learning

    # Hypotheses
    max_sigmas: float = MAX_SIGMAS  # standard deviations; the right hypothesis contradicts by more once in a thousand
    max_limit_sigmas: float = 3.0  # expected errors beyond a joint limit, from which it excludes the posture
    max_std_per_unit: float = _deg(20.0)  # by noise of one image unit, about 1 px: a joint that turns more is open
    grid: int = 9  # postures a joint, of one or two, that the search for the demonstrator's begins with
    samples: int = 64  # postures, of three joints or more
    starts: int = 5  # of these that are refined
    search_swaps_at: tuple[int, ...] = (1, 3, 8, 16)  # visits, minus the joints, at which swapped points are looked for
    rival: float = 10.0  # times the least E: what a posture may leave that may be the demonstrator's, too
