"""Axes: ticks are round and inside, labels do not overlap, what has no place is left out."""

import numpy as np
import pytest

from viewimit.drawing.plots import LABEL_SPACING, Axes, angle_ticks, linear_ticks, spread_heights


@pytest.mark.parametrize("low, high", [(0, 640), (-3.2, 4.1), (291.3, 297.9), (0.01, 0.052), (-1e4, 3e4)])
def test_linear_ticks_are_round_and_inside(low, high):
    values = np.array([value for value, _ in linear_ticks(low, high)])
    assert 2 <= len(values) <= 5 and low <= values[0] and values[-1] <= high + 1e-9
    step = np.diff(values)[0]
    assert np.diff(values) == pytest.approx(step) and values / step == pytest.approx(np.round(values / step))
    assert f"{step:.0e}"[0] in "125"
    said = [float(words.replace("−", "-")) for _, words in linear_ticks(low, high)]
    assert said == pytest.approx(values)


def test_angles_are_marked_at_compared_of_what_people_know():
    assert angle_ticks(-180, 0) == [(-180, "−180°"), (-135, "−135°"), (-90, "−90°"), (-45, "−45°"), (0, "0°")]
    assert [value for value, _ in angle_ticks(-20, 20)] == [-15, 0, 15]


def test_labels_keep_apart_and_inside():
    placed = spread_heights([10, 11, 50, 99, 100], 0, 100)
    assert min(np.diff(placed)) >= LABEL_SPACING and placed[-1] <= 100 and placed[0] == 10 and placed[2] == 50
    assert spread_heights([], 0, 100) == []


def test_a_scale_may_run_downwards_as_pixels_do():
    axes = Axes((0, 0, 100, 50), (0, 640), (240, 0))
    np.testing.assert_allclose(axes.place([0, 640], [0, 240]), [[0, 0], [100, 50]])
