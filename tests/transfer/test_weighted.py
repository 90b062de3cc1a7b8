"""Near the demonstrator's posture the weighted fit is exact, knows the noise that it leaves, and reaches the bound."""

import numpy as np
import pytest

from viewimit.evaluation import conflict
from viewimit.experiments.bench.bound import bound
from viewimit.geometry.rectification import rectification_of
from viewimit.servo.minimise import minimise
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World
from viewimit.transfer import weighted
from viewimit.transfer.weighted import Weighted
from viewimit.views import FourViews

THERE = np.radians([45.0, -90.0])


@pytest.fixture(scope="module")
def world():
    return World(load_scene("panda-toed"), 16)


@pytest.fixture(scope="module")
def rectification(world):
    rng = np.random.default_rng(0)
    own = [world.own_images(theta)[0] for theta in rng.uniform(world.scene.lower, world.scene.upper, (6, 2))]
    matches = np.concatenate([world.demo_images(THERE)[0], *own])
    return rectification_of(matches[:, :2], matches[:, 2:])


def own_at(world, theta):
    return world.own_images(tuple(np.moveaxis(theta, -1, 0)))[0]


def noisy(views, rng, demo_px, own_px):
    return FourViews(
        views.demo + demo_px * rng.standard_normal(views.demo.shape),
        views.own + own_px * rng.standard_normal(views.own.shape),
        views.visible,
    )


def found_near(world, views, rectification):
    by = Weighted.like(views, rectification)
    low, high = THERE - 0.3, THERE + 0.3
    return minimise(lambda theta: by.residual(views.with_own(own_at(world, theta))), THERE[None], low, high).theta


def test_E_is_zero_in_the_demonstrators_posture_and_there_only(world, rectification):
    views = world.look(THERE, THERE)
    around = THERE + np.radians(np.stack(np.meshgrid(*[np.arange(-10, 11, 2.0)] * 2, indexing="ij"), -1))
    E = conflict(Weighted.like(views, rectification).residual(views.with_own(own_at(world, around))))
    assert E[5, 5] < 1e-18
    assert np.delete(E.ravel(), 60).min() > 1e-3


def test_images_of_a_batch_are_answered_as_each_of_them(world, rectification):
    views = world.look(THERE, THERE)
    by = Weighted.like(views, rectification)
    own = own_at(world, THERE + np.random.default_rng(1).uniform(-0.2, 0.2, (2, 3, 2)))
    together = by.residual(views.with_own(own))
    for index in np.ndindex(2, 3):
        np.testing.assert_allclose(together[index], by.residual(views.with_own(own[index])), atol=1e-7)


def test_what_noise_leaves_is_that_noise_but_for_the_fifteen_parameters_of_G(world, rectification, monkeypatch):
    monkeypatch.setattr(weighted, "OWN_SHARE", 1.0)
    exact, rng, px = world.look(THERE, THERE), np.random.default_rng(2), 0.1
    by = Weighted.like(exact, rectification)
    squares = [np.square(by.residual(noisy(exact, rng, px, px))).sum() for _ in range(100)]
    assert np.mean(squares) == pytest.approx(px**2 * (4 * 16 - 15), rel=0.06)


def test_where_only_the_demonstrator_is_noisy_it_reaches_the_cramer_rao_bound(world, rectification, monkeypatch):
    monkeypatch.setattr(weighted, "OWN_SHARE", 0.0)
    exact, rng, px = world.look(THERE, THERE), np.random.default_rng(3), 0.05
    errors = [found_near(world, noisy(exact, rng, px, 0.0), rectification) - THERE for _ in range(60)]
    least = bound(world, THERE, px)
    rms = np.sqrt(np.mean(np.square(errors), 0))
    assert (rms < 1.25 * least).all() and (rms > 0.75 * least).all()
    np.testing.assert_allclose(bound(world, THERE, 3 * px), 3 * least)
