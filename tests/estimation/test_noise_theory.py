"""Over random affine rigs, E of rank 3 at the true posture has the χ² distribution that theory predicts.

With equal noise of σ px in [l r L R], of n = N - 1 centred rows in eight columns a matrix of rank 3 takes
3(n + 8 - 3), so that Σe² = 2N·E is σ² times χ² with f = 8n - 3(n + 5) = 5(N - 4) degrees of freedom, of mean f and
variance 2f. Of n draws of χ²_f the mean has the standard deviation √(2f/n), and the variance, as χ² has the kurtosis
3 + 12/f, 2f times √(2/(n - 1) + 12/(fn)). Five of these are allowed at each rig, and four to the mean over all.
"""

import numpy as np

from viewimit.estimation.transfers import rank3
from viewimit.estimation.views import FourViews

PX = 0.005  # so little that squares of the noise have no part
DRAWS, RIGS = 200, 12
SINGLE, TOGETHER = 5.0, 4.0  # standard deviations


def affine_views(rng):
    """A body and an affine image of it, as one pair of affine cameras sees both."""
    count = int(rng.integers(6, 30))
    points, cameras = rng.normal(size=(count, 3)), rng.normal(0, 100, (3, 4))
    turned = np.linalg.qr(rng.normal(size=(3, 3)))[0] + 0.2 * rng.normal(size=(3, 3))
    demo, own = points @ cameras + rng.normal(0, 50, 4), points @ turned @ cameras + rng.normal(0, 50, 4)
    return FourViews(demo, own, np.ones((count, 4), bool))


def drawn_squares(views, residual_of, rng):
    """Σe²/σ² of noise drawn DRAWS times."""
    found = []
    for _ in range(DRAWS):
        demo, own = PX * rng.standard_normal((2, *views.demo.shape))
        noisy = FourViews(views.demo + demo, views.own + own, views.visible)
        found.append(np.square(residual_of(noisy)).sum() / PX**2)
    return np.array(found)


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


def test_E_of_rank_3_is_chi_square_with_five_degrees_of_freedom_per_point_beyond_four():
    offs = []
    for k in range(RIGS):
        rng = np.random.default_rng([3, k])
        views = affine_views(rng)
        squares = drawn_squares(views, lambda noisy: rank3.fit(noisy).residual(noisy), rng)
        offs.append(mean_off(squares, 5 * (len(views.demo) - 4)))
    assert_together(offs)
