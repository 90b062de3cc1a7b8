"""The noise weight makes the noise of recovered points even, by Monte Carlo and by its definition."""

import numpy as np

from viewimit.estimation.transfers import linear_combination
from viewimit.estimation.transfers.noise import noise_weight
from viewimit.estimation.views import FourViews
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World


def test_weighed_residuals_of_noise_are_even():
    """e = own noise - B (demonstrator's noise): covariance I + BBᵀ, and the identity once weighed."""
    world = World(load_scene("panda"), 20)
    views = world.look(np.radians([45, -90]), np.radians([45, -90]))
    C = noise_weight(views)
    B = linear_combination.fit(views).matrix  # (4, 4): [L; R] of [l; r]
    rng = np.random.default_rng(0)
    demo, own = rng.normal(size=(2, 200_000, 4))
    e = own - demo @ B.T
    assert np.cov(e.T).max() > 1.5
    np.testing.assert_allclose(np.cov((e @ C).T), np.eye(4), atol=0.02)


def test_a_batch_is_weighed_one_by_one():
    world, rng = World(load_scene("iiwa")), np.random.default_rng(1)
    demo, _ = world.demo_images(np.radians([40, -60]))
    own, _ = world.own_images(rng.uniform(world.scene.lower, world.scene.upper, (3, 2)).T)
    batched = noise_weight(FourViews(demo, own, np.ones(1, bool)))
    for k in range(3):
        np.testing.assert_allclose(batched[k], noise_weight(FourViews(demo, own[k], np.ones(1, bool))), atol=1e-12)
