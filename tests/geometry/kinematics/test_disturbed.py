"""Kinematics of an arm that stops short of where it is sent, and of images that a lens bends, from these alone."""

from dataclasses import replace

import numpy as np
import pytest
from turning_body import TurningBody

from viewimit.geometry.kinematics.disturbed import fit_lens, fit_shortfall
from viewimit.geometry.kinematics.own_body import exact_body

ON = np.repeat([0, 1, 2], 6)
NOISE_PX = 0.05
CENTRE, FOCAL = np.array([150.0, 110.0, 170.0, 110.0]), np.array([300.0, 280.0, 420.0, 280.0])  # of `turning_body.seen`


def sent_to(rng, body):
    return np.vstack([body.probes(), rng.uniform(-0.6, 0.6, (6, 2))])


def where(sent, share):
    """By a plain loop."""
    found = [sent[0]]
    for to in sent[1:]:
        found.append(found[-1] + (1 - share) * (to - found[-1]))
    return np.array(found)


def seen_at(rng, body, displacements):
    return body.observations(displacements, noise=NOISE_PX * rng.standard_normal((len(displacements), len(ON), 4)))


@pytest.mark.parametrize("share", [0.1, 0.3, -0.15])
@pytest.mark.parametrize("seed", range(3))
def test_how_short_an_arm_stops_is_found_and_its_images_predicted_where_it_is(share, seed):
    rng = np.random.default_rng(seed)
    body = TurningBody(rng, ON, 2)
    sent = sent_to(rng, body)
    there = where(sent, share)
    seen = replace(seen_at(rng, body, there), displacement=sent)
    assert exact_body(seen, NOISE_PX) is None
    kinematics, shortfall = fit_shortfall(seen, NOISE_PX)
    assert shortfall.share == pytest.approx(share, abs=0.003)
    np.testing.assert_allclose(shortfall.reached(sent), there, atol=0.003)
    # A share that is off by 0.003 turns the arm by 0.0018 rad at most, which moves points by a pixel.
    new = rng.uniform(-0.3, 0.3, 2)
    assert np.abs(kinematics.predict(new) - body.images(new)).max() < 1.0
    again, same = fit_shortfall(seen, NOISE_PX, previous=(kinematics, shortfall))
    assert same.share == pytest.approx(shortfall.share, abs=1e-4)


def bent(images, k1):
    """By the radial distortion of OpenCV, of either image about its own centre."""
    on_plane = ((images - CENTRE) / FOCAL).reshape(*images.shape[:-1], 2, 2)
    squared = (on_plane**2).sum(-1, keepdims=True)
    return (on_plane * (1 + k1 * squared)).reshape(images.shape) * FOCAL + CENTRE


@pytest.mark.parametrize("k1", [-0.1, 0.1])
@pytest.mark.parametrize("seed", range(3))
def test_images_that_a_lens_bends_are_straight_where_the_kinematics_predict_them(k1, seed):
    rng = np.random.default_rng(seed)
    body = TurningBody(rng, ON, 2)
    displacements = np.vstack([body.probes(), rng.uniform(-0.6, 0.6, (20, 2))])
    straight = np.array([body.images(one) for one in displacements])
    noise = NOISE_PX * rng.standard_normal(straight.shape)
    seen = replace(body.observations(displacements), images=bent(straight, k1) + noise)
    found = fit_lens(seen, NOISE_PX, np.arange(2) < np.array(ON)[:, None], np.ones(len(ON), bool))
    assert found is not None
    kinematics, lens = found
    assert np.sign(lens.bend) == -np.sign(k1) and kinematics.unknown.sum() < 3
    # In new postures the kinematics predict images that a lens has bent as those are.
    for new in rng.uniform(-0.5, 0.5, (5, 2)):
        error = kinematics.predict(new) - lens.straightened(bent(body.images(new), k1)[None])[0]
        assert np.sqrt(np.nanmean(error**2)) < 3 * NOISE_PX
