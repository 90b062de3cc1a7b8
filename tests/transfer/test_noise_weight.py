"""The noise weight makes the noise of recovered points even, by Monte Carlo and by its definition."""

import numpy as np

from viewimit.estimation.noise import affine_whitening
from viewimit.estimation.transfers import linear
from viewimit.estimation.views import FourViews
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World


def test_weighed_residuals_of_noise_are_even():
    """e = own noise - B (demonstrator's noise): covariance I + BBᵀ, and the identity once weighed."""
    world = World(load_scene("panda"), 20)
    views = world.look(np.radians([45, -90]), np.radians([45, -90]))
    C = affine_whitening(views)
    B = linear.fit(views).matrix  # (4, 4): [L; R] of [l; r]
    rng = np.random.default_rng(0)
    demo, own = rng.normal(size=(2, 200_000, 4))
    e = own - demo @ B.T
    assert np.cov(e.T).max() > 1.5
    np.testing.assert_allclose(np.cov((e @ C).T), np.eye(4), atol=0.02)


def test_a_batch_is_weighed_one_by_one():
    world, rng = World(load_scene("iiwa")), np.random.default_rng(1)
    demo, _ = world.demo_images(np.radians([40, -60]))
    own, _ = world.own_images(rng.uniform(world.scene.lower, world.scene.upper, (3, 2)).T)
    batched = affine_whitening(FourViews(demo, own, np.ones(1, bool)))
    for k in range(3):
        np.testing.assert_allclose(batched[k], affine_whitening(FourViews(demo, own[k], np.ones(1, bool))), atol=1e-12)
