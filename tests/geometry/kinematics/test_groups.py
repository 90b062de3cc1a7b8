"""Which joints move which points is told by images between which one joint was turned, and by nothing else."""

import numpy as np
import pytest
from turning_body import TurningBody

from viewimit.geometry.kinematics.clusters import Groups, moved_points

ON = [0, 0, 1, 1, 1, 2, 2, 2, 2]


def expected(on, joints):
    return np.arange(joints) < np.array(on)[:, None]


def test_probes_tell_which_joints_move_each_point():
    body = TurningBody(np.random.default_rng(0), ON, 2)
    moved, told = moved_points(body.seen(body.probes()), 0.0)
    assert told.all()
    np.testing.assert_array_equal(moved, expected(ON, 2))


def test_images_between_which_several_joints_were_turned_tell_nothing():
    body = TurningBody(np.random.default_rng(0), ON, 2)
    assert moved_points(body.seen(np.array([[0, 0], [0.3, 0.2], [0.5, -0.3]])), 0.0) is None


def test_a_point_that_was_hidden_at_a_probe_is_told_by_the_others_order_of_joints():
    """Unseen at the second probe, a point that the first one moved may be moved by the second, or not; one that the
    second moved is moved by the first, as all others that it moved were; and one that the first did not move is not
    moved by the second."""
    body = TurningBody(np.random.default_rng(0), ON, 2)
    whole = np.ones((3, len(ON)), bool)
    whole[2, 3] = False  # the first joint moves it, the second was not asked
    whole[2, 1] = False  # the first joint does not move it, the second was not asked
    whole[0, 6] = False  # the second joint moves it, the first was not asked
    moved, told = moved_points(body.seen(body.probes(), whole), 0.0)
    assert not told[3] and told[np.arange(len(ON)) != 3].all()
    np.testing.assert_array_equal(moved[[1, 6]], [[False, False], [True, True]])


def test_a_joint_that_was_not_asked_may_move_a_point_as_it_moves_no_other():
    """All points between both joints are hidden at the first probe: that the joints move both or none of the others
    tells nothing of them, nor which joint is the inner one."""
    on = [0, 0, 1, 1, 2, 2, 2, 2, 2]
    body = TurningBody(np.random.default_rng(0), on, 2)
    whole = np.ones((3, len(on)), bool)
    whole[0, [2, 3, 8]] = False  # the second joint moves the last one
    told = moved_points(body.seen(body.probes(), whole), 0.0)[1]
    np.testing.assert_array_equal(np.flatnonzero(~told), [2, 3, 8])


@pytest.mark.parametrize("deviations, told, moves", [(2.0, True, False), (3.5, False, False), (6.0, True, True)])
def test_noise_leaves_open_what_it_may_have_hidden(deviations, told, moves):
    """A point that moves by so many standard deviations of a difference of two images: some may be noise or not."""
    body, noise_px = TurningBody(np.random.default_rng(0), ON, 2), 0.1
    seen = body.seen(body.probes())
    seen.images[:, 0] = seen.images[0, 0]
    seen.images[1:, 0, 0] += deviations * np.sqrt(2) * noise_px
    moved, found = moved_points(seen, noise_px)
    assert found[0] == told and moved[0, 0] == moves and found[1:].all()


def test_what_moves_more_points_is_nearer_to_the_base_however_the_joints_are_numbered():
    moved = expected(ON, 2)
    assert Groups.of(moved).joints == ((), (0,), (0, 1))
    assert Groups.of(moved[:, ::-1]).joints == ((), (1,), (1, 0))
