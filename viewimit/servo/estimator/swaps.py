"""Find swapped correspondences: which of the demonstrator's points are taken for each other, one pair or two.

The image model predicts the own images over the whole range. E is evaluated with the demonstrator's points as they are
and with pairs of them swapped, each hypothesis at its best posture. A swap that leaves far less E is likely.
No motion is needed. The E that is left when the arm has gone there decides.
"""

from collections.abc import Callable, Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from ...estimation.residuals import ResidualFunction
from ...estimation.transfers.transfer import conflict
from ...estimation.views import Pairs, permute
from ..least_squares import minimise, posture_grid

Array = NDArray[np.float64]
BATCH_SIZE = 24  # hypotheses that are evaluated at once
GRID, GRID_TWO = 12, 8  # postures per joint, for one swapped pair, and for two: there are many more hypotheses
FIRST_PAIRS = 6  # best single pairs that are extended by a second one
REFINED = 3  # best postures that are refined by least squares
GAIN = 0.1  # of E without a swap: what a swap must leave, to be accepted where E is not small


def swapped(images: Array, pairs: Pairs) -> Array:
    """Swap the points of each pair: (..., N, k) → (..., N, k)."""
    return images[..., permute(np.arange(images.shape[-2]), pairs), :] if pairs else images


def transpositions(order: NDArray[np.int_]) -> Pairs:
    """Return swaps that, one after the other, bring (N,) indices into this order, as `permute` makes them."""
    now, pairs = np.arange(len(order)), []
    for i, wanted in enumerate(order):
        j = int(np.flatnonzero(now == wanted)[0])
        if i != j:
            now[[i, j]] = now[[j, i]]
            pairs.append((i, j))
    return tuple(pairs)


def with_swaps(residuals: ResidualFunction, pairs: Pairs) -> ResidualFunction:
    """Return residuals with pairs of the demonstrator's points swapped: own points are swapped back instead."""
    return (lambda own: residuals(swapped(own, pairs[::-1]))) if pairs else residuals


def find_swaps(
    predict: Callable[[Array], Array],
    residuals: ResidualFunction,
    lower: Array,
    upper: Array,
    objective_floor: float,
    seed: int = 0,
    name_all: Callable[[], Pairs] = tuple,
) -> Pairs:
    """Find the pairs of the demonstrator's points that are swapped.

    Parameters
    ----------
    predict : callable
        Own images at displacements, (..., m) rad → (..., N, 4) px; NaN for points that it cannot predict.
    residuals : ResidualFunction
    lower, upper : (m,) arrays
        Joint limits [rad].
    objective_floor : float
        E that needs no explanation [px²].
    seed : int, optional
        Of random postures, of three joints or more.
    name_all : callable, optional
        Names all points again and returns the swaps that this takes, none if it finds nothing. It is asked where points
        are mixed up, and no single pair explains how: what seem to be two pairs may be a part of it.

    Returns
    -------
    tuple of pairs
        None, one or two pairs of indices, or those by `name_all`.
    """

    def smallest(pairs: Pairs, postures: Array, E: Array) -> float:
        """Refine the best postures of a hypothesis, and return E there."""
        residual_at = lambda theta: residuals(swapped(predict(theta), pairs))
        return minimise(residual_at, postures[np.argsort(E)[:REFINED]], lower, upper).E

    def evaluate(postures: Array, hypotheses: Sequence[Pairs]) -> Array:
        """Return E of all hypotheses at all postures, (hypotheses, postures) px²."""
        images = np.ascontiguousarray(predict(postures).transpose(1, 2, 0))  # postures last in memory
        found = []
        for k in range(0, len(hypotheses), BATCH_SIZE):
            orders = [permute(np.arange(len(images)), pairs) for pairs in hypotheses[k : k + BATCH_SIZE]]
            batch = np.stack([images[order] for order in orders], 2)
            found.append(conflict(residuals(batch.transpose(2, 3, 0, 1))))
        return np.concatenate(found)

    postures = posture_grid(lower, upper, GRID, seed)
    known = np.flatnonzero(np.isfinite(predict(postures)).all((0, 2))).tolist()
    E_none = smallest((), postures, evaluate(postures, [()])[0]) if len(known) >= 2 else np.nan
    if not objective_floor <= E_none < np.inf:
        return ()
    single: list[Pairs] = [(pair,) for pair in combinations(known, 2)]
    E = evaluate(postures, single)
    order = np.argsort(E.min(1))
    one = single[order[0]]
    E_one = smallest(one, postures, E[order[0]])
    if E_one < objective_floor:
        return one
    if mixed_up := name_all():
        return mixed_up
    postures = posture_grid(lower, upper, GRID_TWO, seed)
    first = [single[k] for k in order[:FIRST_PAIRS]]
    double = [(*pair, *other) for pair in first for other in single if not {*pair[0]} & {*other[0]}]
    E = evaluate(postures, double)
    k = int(E.min(1).argmin())
    two, E_two = double[k], smallest(double[k], postures, E[k])
    if E_two < GAIN * min(E_one, E_none):
        return two
    return one if E_one < GAIN * E_none else ()
