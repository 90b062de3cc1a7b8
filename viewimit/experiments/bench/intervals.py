"""Shares, medians and differences of runs, with their intervals for a confidence of 95 %."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any

import numpy as np
from numpy.typing import NDArray

CONFIDENCE = 0.95
RESAMPLES, BOOTSTRAP_SEED = 2000, 0
CHUNK = 1_000_000  # numbers that are resampled at once


def rms(values: Any) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


@dataclass(frozen=True)
class Share:
    """A share of runs, with Wilson's score interval."""

    count: int
    runs: int
    share: float
    low: float
    high: float

    @classmethod
    def of(cls, happened: Iterable[bool]) -> "Share":
        """Count the true ones."""
        happened = list(happened)
        count, runs = sum(map(bool, happened)), len(happened)
        return cls(count, runs, count / runs, *wilson(count, runs))

    def __str__(self) -> str:
        """Such as 97 % (93–99), the interval rounded outwards; 0 and 100 % stand for none and all only."""
        text = f"{self.share:.0%}"
        if text == "100%" and self.count < self.runs:
            text = ">99%"
        elif text == "0%" and self.count > 0:
            text = "<1%"
        return f"{text[:-1]} % ({math.floor(100 * self.low)}–{math.ceil(100 * self.high)})"

    @property
    def with_tenths(self) -> str:
        """Such as 0.5 % (0.2–1.2), for small shares."""
        low, high = math.floor(1000 * self.low) / 10, math.ceil(1000 * self.high) / 10
        return f"{self.share:.1%} ({low:g}–{high:g})".replace("%", " %")


def share_of(happened: Sequence[bool] | NDArray[np.bool_]) -> Share | None:
    """Return the share of the true ones, None of nothing."""
    return Share.of(happened) if len(happened) else None


def wilson(count: int, runs: int) -> tuple[float, float]:
    """Return Wilson's score interval (1927) of a share, for CONFIDENCE."""
    z = NormalDist().inv_cdf((1 + CONFIDENCE) / 2)
    share, shrink = count / runs, 1 + z * z / runs
    middle = (share + z * z / (2 * runs)) / shrink
    half = z / shrink * math.sqrt(share * (1 - share) / runs + (z / (2 * runs)) ** 2)
    return middle - half if count else 0.0, middle + half if count < runs else 1.0


@dataclass(frozen=True)
class Interval:
    """An estimate and its interval for CONFIDENCE."""

    value: float
    low: float
    high: float

    def text(self, digits: int, unit: str = "") -> str:
        """Such as 0.02° (0.01–0.03), the interval rounded outwards."""
        scale = 10**digits
        low, high = math.floor(self.low * scale) / scale, math.ceil(self.high * scale) / scale
        dash = "–" if low >= 0 else " to "
        return f"{self.value:.{digits}f}{unit} ({low:.{digits}f}{dash}{high:.{digits}f})"

    @property
    def percentage_points(self) -> str:
        """A difference of shares, such as +8 % (+2 to +15), the interval rounded outwards."""
        return f"{100 * self.value:+.0f} % ({math.floor(100 * self.low):+d} to {math.ceil(100 * self.high):+d})"


def of_median(values: NDArray[np.float64]) -> Interval:
    """Return the median of values (n,), n ≥ 1, with its bootstrap interval."""
    return of_percentile(values, 50.0)


def of_percentile(values: NDArray[np.float64], percent: float) -> Interval:
    """Return a percentile of values (n,), n ≥ 1, with its bootstrap interval (percentile method, Efron 1979)."""
    rng, left, found = np.random.default_rng(BOOTSTRAP_SEED), RESAMPLES, []
    while left:  # in pieces, as 10,000 runs would need 300 MB
        rows = min(left, max(CHUNK // len(values), 1))
        found.append(np.percentile(values[rng.integers(len(values), size=(rows, len(values)))], percent, axis=-1))
        left -= rows
    tail = 50.0 * (1 - CONFIDENCE)
    low, high = np.percentile(np.concatenate(found), (tail, 100 - tail))
    return Interval(float(np.percentile(values, percent)), float(low), float(high))


def paired_difference(first: NDArray[np.bool_], second: NDArray[np.bool_]) -> Interval:
    """Return the difference of two shares of the same n draws, (n,) each.

    The interval is Newcombe's score interval for paired data (Statistics in Medicine 17, 1998, method 10).
    """
    n = len(first)
    both, neither = int((first & second).sum()), int((~first & ~second).sum())
    only_first, only_second = int((first & ~second).sum()), int((~first & second).sum())
    p, q = (both + only_first) / n, (both + only_second) / n
    (p_low, p_high), (q_low, q_high) = wilson(both + only_first, n), wilson(both + only_second, n)
    margins = float(both + only_first) * (only_second + neither) * (both + only_second) * (only_first + neither)
    product = float(both * neither - only_first * only_second)
    if product > 0:
        product = max(product - n / 2, 0.0)  # correction for continuity
    phi = product / margins**0.5 if margins else 0.0
    below = (p - p_low) ** 2 - 2 * phi * (p - p_low) * (q_high - q) + (q_high - q) ** 2
    above = (p_high - p) ** 2 - 2 * phi * (p_high - p) * (q - q_low) + (q - q_low) ** 2
    return Interval(p - q, p - q - below**0.5, p - q + above**0.5)
