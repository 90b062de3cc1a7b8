"""What a tracker writes of points that it has lost is no point."""

import numpy as np
import pytest

from viewimit.sensing.frames import FAR_OUTLIER, is_far_outlier, is_missing_value


def test_a_point_is_lost_at_both_coordinates_of_a_mark_only():
    image = np.array([[(0, 0), (-1, -1), (-0.0, 0)], [(0, -1), (0, 12), (1e-9, 0)]])
    assert is_missing_value(image).tolist() == [[True] * 3, [False] * 3]


@pytest.mark.parametrize("times, beyond", [(0.9 * FAR_OUTLIER, False), (1.1 * FAR_OUTLIER, True)])
def test_a_point_is_astray_beyond_so_many_times_what_the_others_lie_apart(times, beyond):
    """Wherever they are, and however large they are seen."""
    turns = np.linspace(0, 2 * np.pi, 8, endpoint=False)
    ring = np.stack([np.cos(turns), np.sin(turns)], -1)
    for scale, centre in ((1.0, (0, 0)), (80.0, (320, 240))):
        image = scale * np.concatenate([ring, ring, [(times, 0)]]) + centre
        assert is_far_outlier(image).tolist() == [False] * 16 + [beyond]


def test_no_point_is_astray_where_half_are_in_one_place():
    assert not is_far_outlier(np.array([(3.0, 4)] * 4 + [(500, 2), (7, 9)])).any()
