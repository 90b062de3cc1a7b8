"""Leave-one-out errors are those of fits made one by one, and rectify what they should: toed-in rigs, no others."""

import numpy as np
import pytest
from tracks import Case, draw

from viewimit.analysis.leave_one_out import leave_one_out
from viewimit.estimation.outliers import find_outliers
from viewimit.estimation.rectification import fit_transfer
from viewimit.estimation.transfers import TRANSFERS
from viewimit.estimation.views import FourViews
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World

DRAWS = 20


def arms(scene, points, frames, rng, noise_px=0.0, alike=True):
    """Both arms in random postures, the same in each frame or not."""
    world = World(load_scene(scene), points)
    low, high = world.scene.lower, world.scene.upper
    thetas = rng.uniform(low, high, (frames, len(low)))
    seen = [world.look(theta, theta if alike else rng.uniform(low, high)) for theta in thetas]
    demo, own = (np.array([getattr(views, body) for views in seen]) for body in ("demo", "own"))
    noise = noise_px * rng.standard_normal((2, *demo.shape))
    return FourViews(demo + noise[0], own + noise[1], np.ones(demo.shape, bool))


def with_missing(views, share, rng):
    return FourViews(views.demo, views.own, rng.random(views.visible.shape) >= share)


def one_by_one(views, transfer):
    """px rms over all points, of one fit each."""
    squares = []
    for demo, own, usable in zip(views.demo, views.own, views.usable):
        for point in np.flatnonzero(usable):
            others = usable & (np.arange(len(usable)) != point)
            fitted = TRANSFERS[transfer](FourViews(demo[others], own[others], np.ones((others.sum(), 4), bool)))
            predicted = fitted.recover(demo[[point], :2], demo[[point], 2:])[0]
            squares += [((own[point] - predicted)[side] ** 2).sum() for side in (slice(2), slice(2, 4))]
    return np.sqrt(np.mean(squares))


@pytest.mark.parametrize("transfer", TRANSFERS)
@pytest.mark.parametrize("missing", [0.0, 0.1])
def test_errors_are_those_of_fits_made_one_by_one(transfer, missing):
    rng = np.random.default_rng(1)
    views = with_missing(arms("panda", 16, 4, rng, noise_px=0.3), missing, rng)
    found = leave_one_out(views)
    assert found.error_px[transfer] == pytest.approx(one_by_one(views, transfer), rel=1e-6)
    assert (found.predictions, found.of_predictions) == (views.usable.sum(), views.usable.sum())
    assert (found.frames, found.of_frames, found.sampled) == (4, 4, False)


def test_without_noise_the_projective_transfer_predicts_points_exactly_and_affine_ones_do_not():
    found = leave_one_out(arms("panda", 16, 3, np.random.default_rng(2)))
    assert found.error_px["projective"] < 0.05 < 0.5 < min(found.error_px[name] for name in ("linear", "epipolar"))
    assert found.rectification is None and found.rectified_px is None  # rows are equal


def held_out(seen, elsewhere, by):
    fitted = fit_transfer(TRANSFERS["projective"], seen, by)
    return float(np.sqrt(np.square(fitted.residual(elsewhere)).sum(-1).mean() / 2))


RIGS = [(12, 5.0)]
MORE_RIGS = [(20, 5.0), (12, 20.0), (20, 2.0), (20, 20.0), (40, 2.0), (40, 5.0), (40, 20.0)]


@pytest.mark.parametrize(
    "points, toe_in_deg", [*RIGS, *(pytest.param(*rig, marks=pytest.mark.slow) for rig in MORE_RIGS)]
)
def test_a_toed_in_rig_is_rectified_and_predicts_better_so(points, toe_in_deg):
    for k in range(DRAWS):
        seen, elsewhere = draw(Case(points, toe_in_deg), np.random.default_rng([12, k]))
        by = leave_one_out(find_outliers(seen).corrected(seen)).rectification
        assert by is not None
        assert held_out(seen, elsewhere, by) < held_out(seen, elsewhere, None)


@pytest.mark.parametrize("seen", [0, 5, 6])
def test_six_usable_points_are_the_fewest(seen):
    views = arms("panda", 16, 2, np.random.default_rng(8))
    views.visible[:, seen:, 3] = False
    found = leave_one_out(views)
    assert found.predictions == (2 * seen if seen > 5 else 0) and bool(found.error_px) == (seen > 5)


def test_points_in_one_plane_predict_nothing():
    views = arms("panda", 16, 2, np.random.default_rng(9))
    views.demo[0] = views.demo[0] @ np.diag([1, 1, 1, 0]) * [1, 1, 0, 0]
    assert (found := leave_one_out(views)).predictions == 16 and found.frames == 1 and not found.sampled
