"""Intervals of what is no share: medians and percentiles by the bootstrap, differences of paired shares by Newcombe."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .success import CONFIDENCE, wilson

RESAMPLES, SEED = 2000, 0


@dataclass(frozen=True)
class Interval:
    """value, and what it lies between with CONFIDENCE."""

    value: float
    low: float
    high: float


def of_median(values: NDArray) -> Interval:
    """(n,), n ≥ 1."""
    return of_percentile(values, 50.0)


def of_percentile(values: NDArray, percent: float) -> Interval:
    """(n,), n ≥ 1; percent: 0 to 100. Of resamples, the interval between their own percentiles (Efron 1979)."""
    return _bootstrap(values, lambda drawn: np.percentile(drawn, percent, axis=-1))


def _bootstrap(values: NDArray, of: Callable[[NDArray], NDArray]) -> Interval:
    chosen = np.random.default_rng(SEED).integers(len(values), size=(RESAMPLES, len(values)))
    tail = 50.0 * (1 - CONFIDENCE)
    low, high = np.percentile(of(values[chosen]), (tail, 100 - tail))
    return Interval(float(of(values)), float(low), float(high))


def paired_difference(first: NDArray, second: NDArray) -> Interval:
    """The share of `first` less that of `second`, (n,) bool each, of the same n draws: Newcombe's score interval for
    paired data (Statistics in Medicine 17, 1998, method 10)."""
    n = len(first)
    both, neither = int((first & second).sum()), int((~first & ~second).sum())
    only_first, only_second = int((first & ~second).sum()), int((~first & second).sum())
    p, q = (both + only_first) / n, (both + only_second) / n
    (p_low, p_high), (q_low, q_high) = wilson(both + only_first, n), wilson(both + only_second, n)
    margins = float(both + only_first) * (only_second + neither) * (both + only_second) * (only_first + neither)
    product = float(both * neither - only_first * only_second)
    if product > 0:
        product = max(product - n / 2, 0.0)  # a correction for continuity, where they agree
    phi = product / margins**0.5 if margins else 0.0
    below = (p - p_low) ** 2 - 2 * phi * (p - p_low) * (q_high - q) + (q_high - q) ** 2
    above = (p_high - p) ** 2 - 2 * phi * (p_high - p) * (q - q_low) + (q - q_low) ** 2
    return Interval(p - q, p - q - below**0.5, p - q + above**0.5)
