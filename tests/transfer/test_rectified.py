"""Between rectified images a transfer that wants parallel axes is exact for every head; it speaks in px as seen."""

import numpy as np
import pytest

from viewimit.estimation.rectification import fit_transfer
from viewimit.estimation.residuals import conflict
from viewimit.estimation.transfers import TRANSFERS
from viewimit.estimation.views import FourViews
from viewimit.geometry.rectification import Rectification, fit_rectification
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World

SAME = Rectification(np.eye(3), np.eye(3))


@pytest.fixture(scope="module")
def world():
    return World(load_scene("panda-toed"))


def views_and_rectification(world, offset_deg=(0, 0)):
    theta = np.radians([45.0, -90.0])
    views = world.look(theta, theta + np.radians(offset_deg))
    pooled = np.concatenate([views.demo, views.own, world.own_images(theta - 0.3)[0]])
    return views, fit_rectification(pooled[:, :2], pooled[:, 2:])


def test_in_the_demonstrators_posture_the_projective_transfer_leaves_nothing(world):
    views, rectification = views_and_rectification(world)
    raw, rectified = (fit_transfer(TRANSFERS["projective"], views, by).conflict(views) for by in (None, rectification))
    assert rectified < 1e-4 < 0.1 < raw


@pytest.mark.parametrize("name", TRANSFERS)
def test_between_images_that_stay_as_they_are_every_transfer_is_what_it_was(world, name):
    views, _ = views_and_rectification(world, (20, -30))
    plain, same = fit_transfer(TRANSFERS[name], views, None), fit_transfer(TRANSFERS[name], views, SAME)
    np.testing.assert_allclose(same.residual(views), plain.residual(views), atol=1e-9)
    assert float(same.conflict(views)) == pytest.approx(float(plain.conflict(views)), rel=1e-9)
    assert float(same.condition) == float(plain.condition) and same.is_whitened == plain.is_whitened


@pytest.mark.parametrize("name", TRANSFERS)
def test_a_batch_is_answered_as_each_of_it_and_E_is_that_of_its_residuals(world, name):
    views, rectification = views_and_rectification(world)
    theta = np.radians([45.0, -90.0]) + np.random.default_rng(0).uniform(-0.5, 0.5, (2, 3, 2))
    own = world.own_images(tuple(np.moveaxis(theta, -1, 0)))[0]
    batch = FourViews(views.demo, own, np.ones(1, bool))
    together = fit_transfer(TRANSFERS[name], batch, rectification)
    E = together.conflict(batch)
    np.testing.assert_allclose(E, conflict(together.residual(batch)), rtol=1e-8)
    for index in np.ndindex(2, 3):
        one = batch.with_own(own[index])
        assert E[index] == pytest.approx(
            float(fit_transfer(TRANSFERS[name], one, rectification).conflict(one)), rel=1e-8
        )


def test_what_it_recovers_and_its_residuals_are_px_as_seen(world):
    views, rectification = views_and_rectification(world)
    fitted = fit_transfer(TRANSFERS["projective"], views, rectification)
    np.testing.assert_allclose(fitted.recover(views.demo_left, views.demo_right), views.own, atol=0.05)
    larger = FourViews(3 * views.demo, 3 * views.own, views.visible)
    scaled = Rectification(
        *(np.diag([3, 3, 1]) @ H @ np.diag([1 / 3, 1 / 3, 1]) for H in (rectification.left, rectification.right))
    )
    moved = np.random.default_rng(1).normal(0, 2, views.own.shape)
    E = [
        float(fit_transfer(TRANSFERS["projective"], other, by).conflict(other))
        for other, by in (
            (views.with_own(views.own + moved), rectification),
            (larger.with_own(larger.own + 3 * moved), scaled),
        )
    ]
    assert E[1] == pytest.approx(9 * E[0], rel=1e-6)
