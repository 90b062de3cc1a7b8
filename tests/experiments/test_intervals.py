"""Intervals are those of the books, and cover what they say."""

import numpy as np
import pytest

from viewimit.experiments.bench.intervals import Share, of_median, of_percentile, paired_difference, wilson


@pytest.mark.parametrize("runs", [1, 7, 200, 3000])
def test_intervals_are_wilsons(runs):
    stats = pytest.importorskip("scipy.stats")
    for count in sorted({0, 1, runs // 3, runs - 1, runs}):
        expected = stats.binomtest(count, runs).proportion_ci(confidence_level=0.95, method="wilson")
        share = Share.of([True] * count + [False] * (runs - count))
        assert (share.count, share.runs, share.share) == (count, runs, count / runs)
        assert (share.low, share.high) == pytest.approx((expected.low, expected.high), rel=1e-9, abs=1e-15)


def test_the_bootstrap_of_a_median_covers_it_as_often_as_it_says():
    """Of 120 samples of 60 the interval holds the true median in 91 to 99 of 100."""
    drawn = np.random.default_rng(1).exponential(size=(120, 60))
    inside = [found.low <= np.log(2) <= found.high for found in map(of_median, drawn)]
    assert 0.91 < np.mean(inside) < 0.99
    assert of_percentile(np.full(5, 3.0), 95).high == 3.0


@pytest.mark.parametrize("agree", [0.0, 0.6])
def test_newcombes_interval_of_a_paired_difference_covers_it(agree):
    """Both laws arrive for the same reason in a share of the draws; p - q = 0.3."""
    rng, inside = np.random.default_rng(2), []
    for _ in range(1000):
        shared, apart = rng.uniform(size=60), rng.uniform(size=60)
        first, second = shared < 0.8, np.where(rng.uniform(size=60) < agree, shared, apart) < 0.5
        found, back = paired_difference(first, second), paired_difference(second, first)
        assert -1 <= found.low <= found.value <= found.high <= 1
        assert (back.low, back.high) == pytest.approx((-found.high, -found.low))
        inside.append(found.low <= 0.3 <= found.high)
    assert 0.93 < np.mean(inside) < 0.985


def test_without_any_failure_the_interval_is_as_wide_as_those_of_its_shares():
    all_of, none = np.ones(40, bool), np.zeros(40, bool)
    found, (low, _) = paired_difference(all_of, none), wilson(40, 40)
    assert found.value == found.high == 1 and found.low == pytest.approx(1 - np.hypot(1 - low, 1 - low))
