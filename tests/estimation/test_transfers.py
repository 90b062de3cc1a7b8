"""What holds for every transfer in `TRANSFERS`, for a plain function, and between rectified images."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from viewimit.estimation.rectification import fit_transfer
from viewimit.estimation.transfers import TRANSFERS, Transfer, transfer_method
from viewimit.estimation.transfers.transfer import conflict
from viewimit.estimation.views import FourViews
from viewimit.geometry.rectification import Rectification, fit_rectification
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World

PX = 60.0  # size of the random bodies
SEEDS = st.integers(0, 50)


class AffineMap:
    """What a user writes: `recover` only."""

    def __init__(self, views):
        demo = np.column_stack([views.demo, np.ones(len(views.demo))])
        self.matrix = np.linalg.lstsq(demo, views.own, rcond=None)[0]

    def recover(self, demo_left, demo_right):
        return np.column_stack([demo_left, demo_right, np.ones(len(demo_left))]) @ self.matrix


METHODS = {**TRANSFERS, "a plain function": transfer_method(lambda views: AffineMap(views))}
each_method = pytest.mark.parametrize("method", METHODS.values(), ids=METHODS)
each_transfer = pytest.mark.parametrize("method", TRANSFERS.values(), ids=TRANSFERS)


def affine_views(rng, count=10, batch=(), noise=0.0):
    """Four exact affine images of one random body, or of a batch of learners' postures, px."""
    body = rng.normal(size=(count, 3)) * PX
    learners = body if batch == () else rng.normal(size=batch + (count, 3)) * PX
    images = [points @ rng.normal(size=(3, 2)) + rng.uniform(0, 300, 2) for points in (body, body, learners, learners)]
    return FourViews.from_images(*(image + noise * rng.normal(size=image.shape) for image in images))


def E_of(method, views):
    return method(views).conflict(views)


# Theorems


@each_transfer
@pytest.mark.parametrize("count", [5, 6, 10, 20])
def test_E_vanishes_for_exact_affine_views(method, count):
    """Rounding leaves 1e-16 of 300 px, squared about 1e-27; ill-conditioned random cameras amplify it."""
    found = [affine_views(np.random.default_rng(seed), count) for seed in range(100)]
    E = [conflict(method(views).residual(views)) for views in found]
    assert np.median(E) < 1e-23 and max(E) < 1e-16
    assert all(0 <= E_of(method, views) < 1e-14 * (views.demo.var() + views.own.var()) for views in found)


@each_method
def test_an_affine_motion_of_the_body_is_invisible(method):
    """Affine cameras of a moved body are other affine cameras."""
    rng = np.random.default_rng(3)
    body, motion, shift = rng.normal(size=(10, 3)) * PX, rng.normal(size=(3, 3)), rng.normal(size=3) * PX
    cameras = [(rng.normal(size=(3, 2)), rng.uniform(0, 300, 2)) for _ in range(4)]
    moved = body @ motion + shift
    images = [points @ M + t for points, (M, t) in zip((body, body, moved, moved), cameras)]
    assert E_of(method, FourViews.from_images(*images)) < 1e-18


@each_method
@given(scale=st.floats(0.01, 100), seed=SEEDS)
def test_E_scales_with_the_square_of_the_image(method, scale, seed):
    views = affine_views(np.random.default_rng(seed), noise=3.0)
    scaled = FourViews(scale * views.demo, scale * views.own, views.visible)
    assert E_of(method, scaled) == pytest.approx(scale**2 * E_of(method, views), rel=1e-6)


@each_method
@given(seed=SEEDS)
def test_shifted_images_shift_recovered_points_and_keep_E(method, seed):
    rng = np.random.default_rng(seed)
    views = affine_views(rng, noise=3.0)
    shift_demo, shift_own = rng.uniform(-500, 500, (2, 4))
    shifted = FourViews(views.demo + shift_demo, views.own + shift_own, views.visible)
    before, after = method(views), method(shifted)
    np.testing.assert_allclose(
        after.recover(shifted.demo_left, shifted.demo_right),
        before.recover(views.demo_left, views.demo_right) + shift_own,
        atol=1e-6,
    )
    assert after.conflict(shifted) == pytest.approx(before.conflict(views), rel=1e-6)


@each_method
@given(seed=SEEDS, order=st.permutations(range(10)))
def test_the_order_of_the_points_does_not_matter(method, seed, order):
    views = affine_views(np.random.default_rng(seed), noise=3.0)
    reordered = views.select(np.array(order))
    before, after = method(views), method(reordered)
    assert after.conflict(reordered) == pytest.approx(before.conflict(views), rel=1e-6)
    recovered = before.recover(views.demo_left, views.demo_right)
    np.testing.assert_allclose(after.recover(reordered.demo_left, reordered.demo_right), recovered[order], atol=1e-6)


@each_method
def test_points_that_were_not_fitted_are_recovered_too(method):
    """Section 5.4: the transfer of the last convergence maps any point of [l], [r]."""
    views = affine_views(np.random.default_rng(6), count=15)
    transfer = method(views.select(np.arange(10)))
    np.testing.assert_allclose(transfer.recover(views.demo_left, views.demo_right), views.own, atol=1e-7)


@pytest.mark.parametrize("name, depends", [("epipolar", 1), ("rank3", 1), ("linear", 0), ("projective", 0)])
def test_E_depends_on_the_size_of_the_demonstrators_images_only_if_residuals_include_them(name, depends):
    """Nothing has moved: E of two places is comparable only if the arms are equally large in the images of both."""
    world, theta = World(load_scene("panda")), np.radians([45.0, -90.0])
    views = world.look(theta, theta + 0.3)
    larger = FourViews(2 * views.demo, views.own, views.visible)
    E, E_larger = (float(E_of(TRANSFERS[name], seen)) for seen in (views, larger))
    assert E > 0.1 and (abs(E_larger / E - 1) > 1e-3) == bool(depends)
    if not depends:
        assert E_larger == pytest.approx(E, rel=1e-6)


# Shapes and batches


@each_method
@pytest.mark.parametrize("batch", [(1,), (2, 3), (70,)])
def test_a_batch_equals_the_loop_over_its_postures(method, batch):
    """With one demonstrator for all postures, and with one for each; 70 postures take another path."""
    views = affine_views(np.random.default_rng(7), batch=batch, noise=1.0)
    one_demo = FourViews(views.demo.reshape(-1, 10, 4)[0], views.own, views.visible)
    for together in (views, one_demo):
        transfer = method(together)
        E, e, recovered = (
            transfer.conflict(together),
            transfer.residual(together),
            transfer.recover(together.demo_left, together.demo_right),
        )
        assert transfer.condition.shape == E.shape == batch and recovered.shape == (*batch, 10, 4)
        np.testing.assert_allclose(conflict(e), E, rtol=1e-8)
        for index in np.ndindex(batch):
            demo = together.demo if together.demo.ndim == 2 else together.demo[index]
            alone = FourViews(demo, together.own[index], together.visible[index])
            single = method(alone)
            expected = single.recover(alone.demo_left, alone.demo_right)
            np.testing.assert_allclose(recovered[index], expected, rtol=1e-8, atol=1e-7)
            np.testing.assert_allclose(e[index], single.residual(alone), rtol=1e-8, atol=1e-7)
            assert E[index] == pytest.approx(float(single.conflict(alone)), rel=1e-7)
            assert transfer.condition[index] == pytest.approx(float(single.condition), rel=1e-7)


# Input that is not fit for a transfer


@each_transfer
def test_four_points_raise(method):
    with pytest.raises(ValueError, match="need at least 5 points, got 4"):
        method(affine_views(np.random.default_rng(8), count=4))


@each_method
@given(seed=SEEDS, junk=st.sampled_from([np.nan, np.inf, -1.0, 1e9]), view=st.integers(0, 3), point=st.integers(0, 9))
def test_invisible_points_are_refused_and_their_coordinates_have_no_effect_on_used_views(
    method, seed, junk, view, point
):
    views = affine_views(np.random.default_rng(seed), noise=2.0)
    visible, images = views.visible.copy(), [views.demo.copy(), views.own.copy()]
    visible[point, view] = False
    images[view // 2][point, 2 * (view % 2) : 2 * (view % 2) + 2] = junk
    spoilt, rest = FourViews(*images, visible), views.select(np.delete(np.arange(10), point))
    if not np.isfinite(junk):
        with pytest.raises(ValueError, match=r"seen in all four views: take FourViews\.used"):
            method(spoilt)
    np.testing.assert_array_equal(method(spoilt.used).residual(spoilt.used), method(rest).residual(rest))


@each_transfer
def test_points_in_one_place_raise_nothing_and_have_an_infinite_condition(method):
    l, r, L, R = np.random.default_rng(0).uniform(0, 600, (4, 6, 2))
    views = FourViews.from_images(l, r, 0 * L, 0 * R)
    with np.errstate(all="raise"):
        fitted = method(views)
        assert np.isfinite(fitted.conflict(views)) and np.isfinite(fitted.recover(l, r)).all()
        assert np.isinf(method(FourViews.from_images(0 * l, 0 * r, L, R)).condition)


@each_method
def test_coplanar_points_are_transferred_and_flagged(method):
    """The epipolar transfer stays exact in the plane, and its condition, cond A, says nothing about the plane."""
    rng = np.random.default_rng(12)
    plane = rng.normal(size=(10, 2)) * PX
    views = FourViews.from_images(*(plane @ rng.normal(size=(2, 2)) + rng.uniform(0, 300, 2) for _ in range(4)))
    transfer = method(views)
    if not method.crosses_lines:
        assert transfer.condition > 1e8
    accuracy = 1e-9 * float(transfer.condition) if method.crosses_lines else 1e-7
    np.testing.assert_allclose(transfer.recover(views.demo_left, views.demo_right), views.own, atol=accuracy)


# Rectified images


SAME = Rectification(np.eye(3), np.eye(3))


@pytest.fixture(scope="module")
def toed_world():
    return World(load_scene("panda-toed"))


def views_and_rectification(world, offset_deg=(0, 0)):
    theta = np.radians([45.0, -90.0])
    views = world.look(theta, theta + np.radians(offset_deg))
    matches = np.concatenate([views.demo, views.own, world.own_images(theta - 0.3)[0]])
    return views, fit_rectification(matches[:, :2], matches[:, 2:])


@each_method
def test_rectification_by_the_identity_changes_nothing(toed_world, method):
    views, _ = views_and_rectification(toed_world, (20, -30))
    plain, same = fit_transfer(method, views, None), fit_transfer(method, views, SAME)
    np.testing.assert_allclose(same.residual(views), plain.residual(views), atol=1e-9)
    assert float(same.conflict(views)) == pytest.approx(float(plain.conflict(views)), rel=1e-9)
    assert float(same.condition) == float(plain.condition) and same.is_whitened == plain.is_whitened


def test_rectified_the_projective_transfer_is_exact_at_the_demonstrators_posture(toed_world):
    views, rectification = views_and_rectification(toed_world)
    raw, rectified = (fit_transfer(TRANSFERS["projective"], views, by).conflict(views) for by in (None, rectification))
    assert rectified < 1e-4 < 0.1 < raw


def test_recovered_points_and_residuals_of_rectified_views_are_px_as_seen(toed_world):
    views, rectification = views_and_rectification(toed_world)
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


# Residuals and the registry


class Constant(Transfer):
    """Recovers the same point for all."""

    def recover(self, demo_left, demo_right):
        return np.full((len(demo_left), 4), 10.0)


def test_a_residual_points_from_the_recovered_point_to_the_learners_own():
    views = FourViews(np.zeros((5, 4)), np.full((5, 4), 13.0), np.ones((5, 4), bool))
    np.testing.assert_array_equal(Constant().residual(views), np.full((5, 4), 3.0))
    assert Constant().conflict(views) == pytest.approx(18.0)  # 3 px off in x and y, in both views


def test_E_is_half_the_mean_over_points_of_the_squares_in_both_views():
    e = np.random.default_rng(0).normal(size=(3, 7, 4))
    for k in range(3):
        expected = sum(x @ x for image in (e[k, :, :2], e[k, :, 2:]) for x in image) / (2 * 7)
        assert conflict(e)[k] == pytest.approx(expected)
