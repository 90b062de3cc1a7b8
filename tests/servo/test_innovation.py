"""A rehearsal holds as long as images are as it foretells them, and not once points have moved."""

import numpy as np
import pytest

from viewimit.loop.self_calibration import spread_postures
from viewimit.servo.observation import Visit
from viewimit.servo.trust_region.localisation import MAX_SHIFT_PX, is_consistent
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World

WORLD = World(load_scene("panda"))
LOW, HIGH = WORLD.scene.lower, WORLD.scene.upper


def visits(postures, noise_px=0.0, missing=0.0, seed=0, moved=0.0):
    """moved: (N, 4) px, of the images."""
    rng, found = np.random.default_rng(seed), []
    for theta in postures:
        own, _ = WORLD.own_images(theta)
        seen = rng.random((len(own), 2)) >= missing
        found.append(Visit.of(theta, own + moved + noise_px * rng.normal(size=own.shape), seen))
    return tuple(found)


def somewhere(count, seed=5):
    return np.random.default_rng(seed).uniform(LOW, HIGH, (count, 2))


@pytest.mark.parametrize("noise_px, missing", [(0.0, 0.0), (0.25, 0.0), (0.0, 0.1), (0.25, 0.1)])
@pytest.mark.parametrize("count", [12, 20])
def test_the_same_body_is_as_foretold(count, noise_px, missing):
    rehearsed = visits(spread_postures(LOW, HIGH, count, np.random.default_rng(0)), noise_px, missing)
    now = [visits([theta], noise_px, missing, seed=k) for k, theta in enumerate(somewhere(40))]
    held = [is_consistent(rehearsed, here, noise_px) for here in now]
    assert sum(held) >= 38


@pytest.mark.parametrize("noise_px", [0.0, 0.1])
def test_one_point_that_has_moved_is_noticed(noise_px):
    """By 4 px, a point of the base, which no posture moves."""
    rehearsed = visits(spread_postures(LOW, HIGH, 12, np.random.default_rng(0)), noise_px)
    moved = np.zeros((10, 4))
    moved[0] = 4.0
    for k, theta in enumerate(somewhere(20)):
        assert not is_consistent(rehearsed, visits([theta], noise_px, seed=k, moved=moved), noise_px)


@pytest.mark.parametrize("share, held", [(0.9, True), (1.1, False)])
def test_images_that_have_shifted_as_a_whole_are_taken_up_to_a_limit(share, held):
    rehearsed = visits(spread_postures(LOW, HIGH, 20, np.random.default_rng(0)))
    shift = np.tile((share * MAX_SHIFT_PX, 0.0, share * MAX_SHIFT_PX, 0.0), (10, 1))
    assert {is_consistent(rehearsed, visits([theta], moved=shift), 0.0) for theta in somewhere(10)} == {held}


def test_points_never_seen_or_not_seen_now_say_nothing():
    rehearsed = visits(spread_postures(LOW, HIGH, 12, np.random.default_rng(0)))
    unseen = tuple(Visit.of(v.displacement, v.own, v.seen & (np.arange(10) > 1)[:, None]) for v in rehearsed)
    (here,) = visits(somewhere(1))
    odd = here.own.copy()
    odd[0] += 50.0
    assert is_consistent(unseen, (Visit.of(here.displacement, odd, here.seen),), 0.0)
    assert not is_consistent(rehearsed, (Visit.of(here.displacement, odd, here.seen),), 0.0)
    hidden = Visit.of(here.displacement, odd, here.seen & (np.arange(10) > 0)[:, None])
    assert is_consistent(rehearsed, (hidden,), 0.0)
