"""Numbers in drawings: written as one format would write them, whatever was drawn before in this process."""

import numpy as np
import pytest

from viewimit.drawing import svg


@pytest.mark.parametrize("nothing", [-0.0, 0.0, -0.04])
def test_nothing_has_one_way_to_be_written(nothing):
    assert svg.filled("%s", np.array([nothing])) == "0.0"
    assert svg.filled("%s %s", np.array([nothing, 1e6])) == "0.0 1000000.0"


def test_numbers_are_the_nearest_tenths_near_and_far_and_not_a_number_too():
    values = np.random.default_rng(0).uniform(-5000, 5000, 500)
    for value, written in zip(values, svg.filled("%s " * len(values), values).split()):
        assert written.partition(".")[2].isdigit() and len(written.partition(".")[2]) == 1
        assert abs(float(written) - value) <= 0.05 + 1e-9
    assert svg.filled("%s", np.array([np.nan])) == "nan"


@pytest.mark.parametrize("count, keep", [(5, 2), (180, 179), (181, 180), (4887, 4886), (4887, 3000), (100_000, 0)])
def test_a_long_path_is_followed_where_it_begins_and_where_it_is_now(count, keep):
    """At most `limit`, the gaps no more than a share of the way to the nearer of both."""
    limit = 180
    kept = np.array(svg.thinned_between(count, limit, keep))
    assert len(kept) <= limit and (np.diff(kept) > 0).all() and {0, keep, count - 1} <= set(kept.tolist())
    gaps, middle = np.diff(kept), (kept[1:] + kept[:-1]) / 2
    assert (gaps <= 1 + 0.35 * np.minimum(middle, np.abs(middle - keep))).all()
    assert {0, 1, keep, max(keep - 1, 0)} <= set(kept.tolist())
