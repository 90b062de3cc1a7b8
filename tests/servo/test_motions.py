"""Where the trust region is sent when it looks for more: within the limits, wherever it stands."""

import numpy as np
import pytest

from viewimit.servo.observation import Observation
from viewimit.servo.trust_region.motions import sample_line

LOWER, UPPER = np.array([-0.25, -1.25]), np.array([1.25, 0.75])
SEEN = Observation(np.zeros((0, 4)), np.zeros((0, 2), bool), 0.0, np.zeros(2), LOWER, UPPER, motion=0)
PLACES = [(0.0, 0.0), *[(x, y) for x in (-0.25, 0.5, 1.25) for y in (-1.25, 0.75)]]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("place", PLACES, ids=str)
@pytest.mark.parametrize("way", [(1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (0.6, 0.8), (-0.6, 0.8)], ids=str)
def test_a_line_through_a_place_leads_from_limit_to_limit_though_no_joint_but_one_turns(place, way):
    place, way = np.array(place), np.array(way)
    found = sample_line(SEEN, place, way, 200)
    assert (found >= LOWER - 1e-12).all() and (found <= UPPER + 1e-12).all()
    away = found - place
    np.testing.assert_allclose(away[:, 0] * way[1], away[:, 1] * way[0], atol=1e-12)  # on the line
    for end, beyond in (found[0], -way), (found[-1], way):
        further = end + 1e-6 * beyond
        assert (further < LOWER).any() or (further > UPPER).any()
