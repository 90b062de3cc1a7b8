"""Which of the demonstrator's points are taken for each other, one pair or two: found without a motion.

The images that a learner predicts at postures all over its range are held against the demonstrator's as they are and
with pairs exchanged. An permute that leaves far less conflict than none, each at its best posture, is likely; what is
left of E once the learner has gone there decides.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from ...estimation.residuals import NoiseReference, ResidualFunction, conflict
from ...estimation.views import Pairs, permute
from ..least_squares import minimise

GRID, GRID_OF_TWO = 12, 8  # postures a joint, for one permute and for two; with many joints as many at random
PROMISING, REFINED = 6, 3  # first exchanges of two that are looked at; postures from which the least is searched
TOGETHER = 24  # exchanges that are asked about in one batch
DECISIVE = 0.1  # of the conflict without an permute


def exchanged(images: NDArray, pairs: Pairs) -> NDArray:
    """(..., N, k) with the rows of each pair exchanged."""
    return images[..., permute(np.arange(images.shape[-2]), pairs), :] if pairs else images


@dataclass(frozen=True)
class PermutedResiduals:
    """The conflict if the pairs of the demonstrator's points are exchanged, which is that of exchanged own ones."""

    residuals: ResidualFunction
    pairs: Pairs

    def __call__(
        self, own: NDArray, transfer: str | None = None, noise_reference: NoiseReference | None = None, rig: int = 0
    ) -> NDArray:
        if noise_reference is not None and noise_reference.own is not None:
            noise_reference = replace(noise_reference, own=exchanged(noise_reference.own, self.pairs))
        return self.residuals(exchanged(own, self.pairs), transfer, noise_reference, rig)

    def with_partially_visible(self) -> ResidualFunction:
        return PermutedResiduals(self.residuals.with_partially_visible(), self.pairs)


def with_exchanged(residuals: ResidualFunction, pairs: Pairs) -> ResidualFunction:
    """The same if there are none."""
    return PermutedResiduals(residuals, pairs) if pairs else residuals


def likely_exchange(
    predict: Callable[[NDArray], NDArray], residuals: ResidualFunction, low: NDArray, high: NDArray, small: float
) -> Pairs:
    """None, one or two pairs. predict: displacements (..., m) rad → own images (..., N, 4) px, NaN of points that are
    not known; low, high: (m,) rad; small: px², an E that explains itself."""

    def least(pairs: Pairs, postures: NDArray, E: NDArray) -> float:
        """px², near the most promising postures."""
        residual_at = lambda theta: residuals(exchanged(predict(theta), pairs))
        return minimise(residual_at, postures[np.argsort(E)[:REFINED]], low, high).E

    def over(postures: NDArray, hypotheses: Sequence[Pairs]) -> NDArray:
        """(hypotheses, postures) px²"""
        images = np.ascontiguousarray(predict(postures).transpose(1, 2, 0))  # postures last in memory
        blocks = [hypotheses[k : k + TOGETHER] for k in range(0, len(hypotheses), TOGETHER)]

        def ask(block: Sequence[Pairs]) -> NDArray:
            together = np.stack([images[permute(np.arange(len(images)), pairs)] for pairs in block], 2)
            return conflict(residuals(together.transpose(2, 3, 0, 1)))

        return np.concatenate([ask(block) for block in blocks])

    postures = _postures(low, high, GRID)
    known = np.flatnonzero(np.isfinite(predict(postures)).all((0, 2))).tolist()
    without = least((), postures, over(postures, [()])[0]) if len(known) >= 2 else np.nan
    if not small <= without < np.inf:
        return ()
    single: list[Pairs] = [(pair,) for pair in combinations(known, 2)]
    E = over(postures, single)
    order = np.argsort(E.min(1))
    one = single[order[0]]
    E_one = least(one, postures, E[order[0]])
    if E_one < small:
        return one
    postures = _postures(low, high, GRID_OF_TWO)
    double = [(*single[k], *other) for k in order[:PROMISING] for other in single if not {*single[k][0]} & {*other[0]}]
    E = over(postures, double)
    k = int(E.min(1).argmin())
    two, E_two = double[k], least(double[k], postures, E[k])
    if E_two < DECISIVE * min(E_one, without):
        return two
    return one if E_one < DECISIVE * without else ()


def _postures(low: NDArray, high: NDArray, count: int) -> NDArray:
    """(n, m) rad: a grid of `count` a joint, with many joints as many at random as with two."""
    if len(low) > 2:
        return np.random.default_rng(count).uniform(low, high, (count**2, len(low)))
    return np.stack(np.meshgrid(*np.linspace(low, high, count).T, indexing="ij"), -1).reshape(-1, len(low))
