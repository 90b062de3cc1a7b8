"""Two probes of 15° foretell the images of every posture, exactly, of bodies that turn and slide; of others nothing."""

import numpy as np
import pytest
from turning_body import TurningBody

from viewimit import Session, Settings
from viewimit.geometry.kinematics.adjustment import fit_kinematics
from viewimit.geometry.kinematics.clusters import Seen
from viewimit.geometry.kinematics.covariance import Information

ON = [0, 0, 1, 1, 1, 2, 2, 2, 2]


def furthest(found, body, displacements, points=slice(None)):
    """px"""
    return max(np.abs(found.predict(d) - body.images(d))[points].max() for d in displacements)


@pytest.mark.parametrize("seed", range(5))
def test_one_probe_a_joint_foretells_images_anywhere(seed):
    rng = np.random.default_rng(seed)
    body = TurningBody(rng, ON, 2)
    found = fit_kinematics(body.seen(body.probes()), 0.0)
    assert furthest(found, body, rng.uniform(-1.2, 1.2, (20, 2))) < 1e-5


def test_joints_may_slide_or_be_many():
    rng = np.random.default_rng(3)
    sliding = TurningBody(rng, ON, 2, sliding=(1,))
    found = fit_kinematics(sliding.seen(sliding.probes()), 0.0)
    assert furthest(found, sliding, rng.uniform(-1, 1, (20, 2))) < 1e-4
    five = TurningBody(rng, [0, 0, *np.repeat([1, 2, 3, 4, 5], 5)], 5)
    found = fit_kinematics(five.seen(five.probes()), 0.0)
    assert furthest(found, five, rng.uniform(-0.5, 0.5, (20, 5))) < 1e-3


def test_a_body_whose_points_do_not_turn_together_has_no_kinematics():
    body = TurningBody(np.random.default_rng(0), ON, 2, slip=0.05)
    more = np.vstack([body.probes(), [0.6, -0.5], [-0.4, 0.8]])
    assert fit_kinematics(body.seen(more), 0.0) is None


@pytest.mark.parametrize("count", range(4))
def test_hardly_any_points_tell_none(count):
    """Of all but so many nothing is seen, at any visit."""
    body = TurningBody(np.random.default_rng(0), ON, 2)
    for begins in (0, 5):
        whole = np.tile((np.arange(len(ON)) >= begins) & (np.arange(len(ON)) < begins + count), (3, 1))
        for noise_px in (0.0, 0.2):
            assert fit_kinematics(body.seen(body.probes(), whole), noise_px) is None


def test_too_few_points_or_visits_tell_none():
    body = TurningBody(np.random.default_rng(0), [0, 1, 2], 2)
    assert fit_kinematics(body.seen(body.probes()), 0.0) is None
    body = TurningBody(np.random.default_rng(0), ON, 2)
    assert fit_kinematics(body.seen(body.probes()[:2]), 0.0) is None


def test_a_point_that_is_hidden_at_some_visits_is_foretold_from_a_single_sight_of_it():
    rng = np.random.default_rng(4)
    body = TurningBody(rng, ON, 2)
    whole = np.ones((4, len(ON)), bool)
    whole[1:3, 7] = False  # seen at the start and at the end, far from each other: which joints move it is not asked
    seen = body.seen(np.vstack([body.probes(), [0.7, -0.6]]), whole)
    found = fit_kinematics(seen, 0.0)
    assert not found.unknown.any()
    assert furthest(found, body, rng.uniform(-1, 1, (20, 2))) < 1e-4
    whole[3, 7] = False  # seen once
    found = fit_kinematics(body.seen(np.vstack([body.probes(), [0.7, -0.6]]), whole), 0.0)
    assert found.unknown.tolist() == [k == 7 for k in range(len(ON))]
    assert np.isnan(found.predict(np.zeros(2))[7]).all()


def test_a_point_that_moves_as_no_other_does_is_foretold_once_its_images_tell_so():
    """The only one between both joints, hidden where the first one is asked: as long as its images leave that open it
    is not known; then it is, though no other point is moved by that joint alone."""
    rng = np.random.default_rng(4)
    on = [0, 0, 0, 1, 2, 2, 2, 2, 2, 2]
    body = TurningBody(rng, on, 2)
    visits = np.vstack([body.probes(), [0.7, -0.6], [-0.5, 0.3]])
    whole = np.ones((len(visits), len(on)), bool)
    whole[0, 3] = False
    open_yet, told = (fit_kinematics(body.seen(visits[:k], whole[:k]), 0.0) for k in (3, len(visits)))
    assert open_yet.unknown.tolist() == [k == 3 for k in range(len(on))] and not told.unknown.any()
    assert furthest(told, body, rng.uniform(-1, 1, (20, 2))) < 1e-4


def test_what_foretold_the_last_visit_is_kept_as_it_is():
    body = TurningBody(np.random.default_rng(5), ON, 2)
    before = fit_kinematics(body.seen(body.probes()), 0.0)
    assert fit_kinematics(body.seen(np.vstack([body.probes(), [0.5, 0.5]])), 0.0, before=before) is before


def test_spread_by_noise_is_as_its_covariance_has_it():
    """Fitted 60 times to images with noise; each coordinate's variance has 59 degrees of freedom, and the mean of their
    ratios over 36 coordinates, hardly independent, is within 1 by 5 √(2/59)."""
    rng, noise_px = np.random.default_rng(6), 0.02
    body = TurningBody(rng, ON, 2)
    visits = np.vstack([body.probes(), rng.uniform(-0.7, 0.7, (4, 2))])
    before, asked = fit_kinematics(body.seen(visits), 0.0), np.array([0.4, -0.3])
    found = []
    for _ in range(60):
        noise = noise_px * rng.standard_normal((len(visits), len(ON), 4))
        found.append(fit_kinematics(body.seen(visits, noise=noise), noise_px, before=before).predict(asked))
    exact = body.seen(visits)
    parameters, shape = Information.of(before, exact).columns(1e-4)
    columns = [
        type(before)(before.parameters + p, before.shape + s, before.moved, before.reference, before.frame).predict(
            asked
        )
        for p, s in zip(parameters, shape)
    ]
    variance = ((np.array(columns) - before.predict(asked)) ** 2).sum(0) * (noise_px / 1e-4) ** 2
    ratio = np.var(found, axis=0, ddof=1) / variance
    assert np.mean(ratio[:, [0, 2]]) == pytest.approx(1, abs=5 * np.sqrt(2 / 59))


@pytest.mark.parametrize("scene", ["panda", "panda-toed", "panda-verged", "iiwa"])
def test_the_simulated_robots_are_foretold_over_their_whole_range(scene):
    session = Session(Settings.paper(scene=scene))
    lower, upper = session.embodiment.lower, session.embodiment.upper
    look = lambda theta: session.observer.four_views(session.settings, theta, session.snapshot.theta_demo, 0).own
    begin = (lower + upper) / 2
    probes = begin + np.vstack([np.zeros(2), [0.26, 0], [0.26, -0.26]])
    own = np.array([look(theta) for theta in probes])
    seen = Seen(probes, own, np.ones(own.shape[:2], bool))
    found = fit_kinematics(seen, 0.0, session.snapshot.rectification)
    asked = np.random.default_rng(0).uniform(lower, upper, (20, 2))
    off = [np.abs(found.predict(theta) - look(theta)).max() for theta in asked]
    assert max(off) < 1e-3
