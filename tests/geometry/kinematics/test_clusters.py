"""Images between which one joint was turned show which points this joint moves."""

import numpy as np
import pytest
from turning_body import TurningBody

from viewimit.geometry.kinematics.clusters import joints_moving_points

ON = [0, 0, 1, 1, 1, 2, 2, 2, 2]


def expected(on, joints):
    return np.arange(joints) < np.array(on)[:, None]


def test_probes_show_which_joints_move_each_point():
    body = TurningBody(np.random.default_rng(0), ON, 2)
    moved, known = joints_moving_points(body.observations(body.probes()), 0.0)
    assert known.all()
    np.testing.assert_array_equal(moved, expected(ON, 2))


def test_images_between_which_several_joints_were_turned_show_nothing():
    body = TurningBody(np.random.default_rng(0), ON, 2)
    assert joints_moving_points(body.observations(np.array([[0, 0], [0.3, 0.2], [0.5, -0.3]])), 0.0) is None


def test_the_order_of_the_joints_decides_for_a_point_hidden_at_a_probe():
    """Unseen at the second probe, a point that the first one moved may be moved by the second, or not; one that the
    second moved is moved by the first, as all others that it moved were; and one that the first did not move is not
    moved by the second."""
    body = TurningBody(np.random.default_rng(0), ON, 2)
    visible = np.ones((3, len(ON)), bool)
    visible[2, 3] = False  # the first joint moves it, the second is not known
    visible[2, 1] = False  # the first joint does not move it, the second is not known
    visible[0, 6] = False  # the second joint moves it, the first is not known
    moved, known = joints_moving_points(body.observations(body.probes(), visible), 0.0)
    assert not known[3] and known[np.arange(len(ON)) != 3].all()
    np.testing.assert_array_equal(moved[[1, 6]], [[False, False], [True, True]])


@pytest.mark.parametrize("deviations, known, moves", [(2.0, True, False), (3.5, False, False), (6.0, True, True)])
def test_a_motion_that_noise_may_hide_stays_undecided(deviations, known, moves):
    """A point moves by a number of standard deviations of a difference of two images."""
    body, noise_px = TurningBody(np.random.default_rng(0), ON, 2), 0.1
    seen = body.observations(body.probes())
    seen.images[:, 0] = seen.images[0, 0]
    seen.images[1:, 0, 0] += deviations * np.sqrt(2) * noise_px
    moved, found = joints_moving_points(seen, noise_px)
    assert found[0] == known and moved[0, 0] == moves and found[1:].all()
