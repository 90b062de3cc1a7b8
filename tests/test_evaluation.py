"""Eq. (6) from its definition."""

import numpy as np
import pytest
from scipy.stats import chi2, norm

from viewimit.estimation.noise import conflict_quantile
from viewimit.estimation.residuals import conflict
from viewimit.estimation.transfers import TRANSFERS
from viewimit.estimation.transfers.transfer import Transfer
from viewimit.estimation.views import FourViews
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World


class Constant(Transfer):
    """A transfer that recovers the same point for all."""

    def recover(self, demo_left, demo_right):
        return np.full((len(demo_left), 4), 10.0)


def test_residual_points_from_the_recovered_point_to_the_learners_own():
    own = np.full((5, 4), 13.0)
    views = FourViews(np.zeros((5, 4)), own, np.ones((5, 4), bool))
    np.testing.assert_array_equal(Constant().residual(views), np.full((5, 4), 3.0))


def test_conflict_is_the_mean_over_points_and_both_views():
    e = np.random.default_rng(0).normal(size=(3, 7, 4))
    for k in range(3):
        expected = sum(x @ x for image in (e[k, :, :2], e[k, :, 2:]) for x in image) / (2 * 7)
        assert conflict(e)[k] == pytest.approx(expected)
    assert conflict(np.full((5, 4), 3.0)) == pytest.approx(18.0)  # 3 px off in x and y, in both views


@pytest.mark.parametrize("transfer, depends", [("epipolar", 1), ("rank3", 1), ("linear", 0), ("projective", 0)])
def test_with_the_demonstrator_twice_as_large_in_its_images_E_changes_by_the_transfers_that_weigh_these(
    transfer, depends
):
    """Nothing has moved: two places are compared by E only where the arms are as large in the images of both."""
    world, theta = World(load_scene("panda")), np.radians([45.0, -90.0])
    views = world.look(theta, theta + 0.3)
    larger = FourViews(2 * views.demo, views.own, views.visible)
    E, E_larger = (float(TRANSFERS[transfer](seen).conflict(seen)) for seen in (views, larger))
    assert E > 0.1 and (abs(E_larger / E - 1) > 1e-3) == bool(depends)
    if not depends:
        assert E_larger == pytest.approx(E, rel=1e-6)


@pytest.mark.parametrize("deviations", [0.0, 1.0, 2.0, 3.0])
@pytest.mark.parametrize("freedom", [1, 2, 4, 10, 40, 200])
def test_E_counts_as_noise_up_to_the_quantile_of_chi_square(freedom, deviations):
    """The cube root of χ² is normal up to terms of 1/freedom: 0.06/freedom of it here, and 4 % at most."""
    points, noise_px = 12, 0.3
    quantile = chi2.ppf(norm.cdf(deviations), freedom)
    E = conflict_quantile(points, freedom, noise_px, deviations)
    assert E == pytest.approx(noise_px**2 * quantile / (2 * points), rel=min(0.06 / freedom, 0.04))


def test_noise_exceeds_that_E_as_rarely_as_the_deviations_say():
    rng, points, draws = np.random.default_rng(0), 10, 20_000
    e = 0.2 * rng.standard_normal((draws, points, 4))
    exceeded = np.mean(conflict(e) > conflict_quantile(points, 4 * points, 0.2, 2.0))
    surely = norm.sf(2.0)
    assert exceeded == pytest.approx(surely, abs=4 * np.sqrt(surely / draws))
