"""What body points tell, and the point that would tell most: against all others, and what no point can mend."""

import numpy as np
import pytest

from viewimit.analysis.observability import best_next, find_candidates, joint_uncertainty, point_information, with_point
from viewimit.geometry.affine import flatness
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.simulation.robot import BodyPoints

# on the links that joint 4 moves, all rigid to each other
RIGID = tuple((6, 0.02 * (k % 3), 0.03 * (k % 2), 0.02 * k) for k in range(8))


def of(**settings):
    session = Session(Settings.paper(**settings))
    return session.world, session.snapshot


def some(world, moment, count=8):
    found = find_candidates(world, moment.theta_demo)
    return BodyPoints(found.link[::count], found.local[::count])


def test_it_says_of_a_scene_what_its_landscape_says():
    world, moment = of()
    told = point_information(world, moment)
    views = moment.views
    spread = joint_uncertainty(world, moment.fit, views.demo, views.visible[:, :2], moment.theta_demo)
    assert (told.count, told.visible, told.unobservable) == (10, 10, [])
    np.testing.assert_allclose(told.std_per_px, spread)
    centred = views.demo - views.demo.mean(0)
    values = np.linalg.svd(centred, compute_uv=False)
    assert told.flatness == pytest.approx(values[0] / values[2]) == flatness(views.demo)


def test_too_few_points_tell_nothing_and_the_farthest_place_is_next():
    world, moment = of(body_points=RIGID[:3])
    told = point_information(world, moment)
    assert (told.count, told.std_per_px, told.unobservable) == (3, None, []) and np.isinf(told.flatness)
    places = some(world, moment)
    proposal = best_next(world, moment, places)
    frames = world.link_frames(moment.theta_demo, world.T_world_demo)
    at = lambda points: np.array([frames[link] @ [*local, 1] for link, local in zip(points.link, points.local)])
    apart = np.linalg.norm(at(places)[:, None] - at(world.body), axis=-1).min(1)
    assert np.array_equal(proposal.point.local[0], places.local[apart.argmax()])


@pytest.mark.parametrize("settings", [{}, {"transfer": "projective"}, {"body_points": RIGID}, {"scene": "panda-flat"}])
def test_no_other_place_makes_the_worst_joint_cost_less(settings):
    world, moment = of(**settings)
    places = some(world, moment)
    proposal = best_next(world, moment, places)
    worst = [point_information(with_point(world, places, k), moment).std_per_px.max() for k in range(len(places))]
    assert proposal.after.std_per_px.max() == min(worst)
    assert proposal.after.count == proposal.before.count + 1
    if "body_points" in settings:
        assert proposal.after.std_per_px.max() < 0.1 * proposal.before.std_per_px.max()
