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
