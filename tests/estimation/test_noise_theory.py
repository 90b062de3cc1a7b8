"""Over random rigs and scenes, weighted E at the true posture has the χ² distribution that theory predicts.

Noise of σ px moves whitened residuals, to first order, by independent normal numbers of σ px each, and the fit takes
out as many combinations of these as it has parameters. So Σe² = 2N·E is σ² times χ² with f degrees of freedom, of mean
f and variance 2f:

- Exact weights: four coordinates a point less the 15 parameters of a homography of space, f = 4N - 15, for any share κ
  of the variance that own images have. Where a camera does not see a point of the demonstrator, two coordinates less.
- Affine weights, C Cᵀ = (κI + BᵀB)⁻¹: each own coordinate is an affine function of three shape coordinates,
  f = 4N - 16.
- Rank 3, equal noise in [l r L R]: of n = N - 1 centred rows in eight columns a matrix of rank 3 takes 3(n + 8 - 3), so
  that f = 8n - 3(n + 5) = 5(N - 4).

Of n draws of χ²_f the mean has the standard deviation √(2f/n), and the variance, as χ² has the kurtosis 3 + 12/f, 2f
times √(2/(n - 1) + 12/(fn)). Five of these are allowed at each of some 200 rigs, and four to the mean over all rigs.
"""

from functools import partial

import numpy as np
import pytest

from viewimit.estimation.noise import HomographyResiduals, affine_whitening
from viewimit.estimation.residuals import NoiseReference
from viewimit.estimation.transfers import linear, rank3
from viewimit.estimation.views import FourViews
from viewimit.experiments.bench.draws import draw_scene, resize, scene_text
from viewimit.geometry.rectification import fit_rectification, rectify_affine
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.simulation.world import World

PX = 0.005  # so little that squares of the noise have no part
DRAWS, RIGS = 200, 12
VISITED = 6  # further own images, by which the head is known
SINGLE, TOGETHER = 5.0, 4.0  # standard deviations


def rig_of(any_head, k):
    """Views in the demonstrator's posture, all exact, the head's geometry, and the scene."""
    rng = np.random.default_rng([int(any_head), k])
    drawn = draw_scene(rng, any_head)
    world = World(drawn.scene, drawn.points)
    resize(world, drawn.size)
    there, *visited = rng.uniform(world.scene.lower, world.scene.upper, (1 + VISITED, 2))
    views = world.look(there, there)
    matches = np.concatenate([views.demo, views.own, *(world.own_images(theta)[0] for theta in visited)])
    left, right = matches[:, :2], matches[:, 2:]
    rectification = fit_rectification(left, right)
    assert (rectification is not None) == any_head
    return views, rectification or rectify_affine(left, right), drawn, rng


def partially_visible(views, rng):
    """The same, a quarter of the demonstrator's points without one of their images."""
    visible = views.visible.copy()
    points = rng.choice(len(visible), len(visible) // 4, replace=False)
    visible[points, rng.integers(2, size=len(points))] = False
    return FourViews(np.where(np.repeat(visible[:, :2], 2, 1), views.demo, np.nan), views.own, visible)


def affine_views(rng):
    """A body and an affine image of it, as one pair of affine cameras sees both."""
    count = int(rng.integers(6, 30))
    points, cameras = rng.normal(size=(count, 3)), rng.normal(0, 100, (3, 4))
    turned = np.linalg.qr(rng.normal(size=(3, 3)))[0] + 0.2 * rng.normal(size=(3, 3))
    demo, own = points @ cameras + rng.normal(0, 50, 4), points @ turned @ cameras + rng.normal(0, 50, 4)
    return FourViews(demo, own, np.ones((count, 4), bool))


def drawn_squares(views, own_variance_ratio, residual_of, rng):
    """Σe²/σ² of noise drawn DRAWS times; κ = own_variance_ratio."""
    found = []
    for _ in range(DRAWS):
        demo, own = PX * rng.standard_normal((2, *views.demo.shape))
        noisy = FourViews(views.demo + demo, views.own + np.sqrt(own_variance_ratio) * own, views.visible)
        found.append(np.square(residual_of(noisy)).sum() / PX**2)
    return np.array(found)


def asked(now, about, noisy):
    """e of noisy views as a servo asks it, weighted about an own image."""
    ask = now.with_fields(views=noisy).predicted_residuals(noise_px=PX)
    return ask(noisy.own, noise_reference=NoiseReference(about, 1.0))


def affinely_weighted(weight, noisy):
    return linear.fit(noisy).residual(noisy) @ weight


def mean_off(squares, freedom):
    """In standard deviations of its mean, after a look at mean and spread of this one rig."""
    off = (squares.mean() - freedom) / np.sqrt(2 * freedom / DRAWS)
    spread = squares.var(ddof=1) / (2 * freedom) - 1
    assert abs(off) < SINGLE
    assert abs(spread) < SINGLE * np.sqrt(2 / (DRAWS - 1) + 12 / (freedom * DRAWS))
    return off


def assert_together(offs):
    """What is within chance at each rig, but to one side at all, is an error of the theory or of the code."""
    assert abs(np.sum(offs)) < TOGETHER * np.sqrt(len(offs))


@pytest.mark.parametrize("any_head", [False, True], ids=["parallel", "any head"])
@pytest.mark.parametrize("own_variance_ratio", [0.0, 0.01, 0.3, 1.0])
def test_whitened_E_is_chi_square_less_the_parameters_of_a_homography(any_head, own_variance_ratio):
    offs = []
    for k in range(RIGS):
        views, head, _, rng = rig_of(any_head, k)
        by = HomographyResiduals.whitened_at(views, head, own_variance_ratio)
        squares = drawn_squares(views, own_variance_ratio, by.residual, rng)
        offs.append(mean_off(squares, 4 * len(views.demo) - 15))
    assert_together(offs)


def test_a_partially_visible_point_has_half_the_degrees_of_freedom():
    offs = []
    for k in range(RIGS):
        views, head, _, rng = rig_of(True, k)
        views = partially_visible(views, rng)
        by = HomographyResiduals.whitened_at(views, head, 0.3)
        squares = drawn_squares(views, 0.3, by.residual, rng)
        offs.append(mean_off(squares, 2 * int(views.visible[:, :2].sum()) - 15))
    assert_together(offs)


@pytest.mark.parametrize("any_head", [False, True], ids=["parallel", "any head"])
def test_predicted_residuals_at_the_true_posture_have_the_variance_of_the_noise(any_head):
    """Of parallel heads the affine geometry, of four numbers, is fitted to the same noisy matches. Half of them are the
    demonstrator's, so that it takes two of these from E in the mean."""
    offs = []
    for k in range(RIGS):
        views, head, drawn, rng = rig_of(any_head, k)
        scene = scene_text(drawn.scene)
        now = Session(Settings.best(scene=scene, points=drawn.points)).snapshot
        now = now.with_fields(rectification=head if any_head else None)
        squares = drawn_squares(views, 1.0, partial(asked, now, views.own), rng)
        offs.append(mean_off(squares, 4 * len(views.demo) - (15 if any_head else 17)))
    assert_together(offs)


@pytest.mark.parametrize("own_variance_ratio", [0.01, 0.3, 1.0])
def test_affinely_whitened_E_is_chi_square_less_four_points(own_variance_ratio):
    """κ = 0 has no such weights: B has rank 3, and a combination of own coordinates no noise at all."""
    offs = []
    for k in range(RIGS):
        rng = np.random.default_rng([2, k])
        views = affine_views(rng)
        weighted = partial(affinely_weighted, affine_whitening(views, own_variance_ratio))
        squares = drawn_squares(views, own_variance_ratio, weighted, rng)
        offs.append(mean_off(squares, 4 * (len(views.demo) - 4)))
    assert_together(offs)


def test_E_of_rank_3_is_chi_square_with_five_degrees_of_freedom_per_point_beyond_four():
    offs = []
    for k in range(RIGS):
        rng = np.random.default_rng([3, k])
        views = affine_views(rng)
        squares = drawn_squares(views, 1.0, lambda noisy: rank3.fit(noisy).residual(noisy), rng)
        offs.append(mean_off(squares, 5 * (len(views.demo) - 4)))
    assert_together(offs)
