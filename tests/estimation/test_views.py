"""Tracked points as they come: what is seen, what is refused, what a selection keeps."""

import numpy as np
import pytest

from viewimit.estimation.views import FourViews


def images(count=6, batch=()):
    return list(np.random.default_rng(0).uniform(0, 600, (4,) + batch + (count, 2)))


def test_a_masked_point_is_invisible():
    l, r, L, R = images()
    hidden = np.zeros((6, 2), bool)
    hidden[2, 1] = True
    masked = FourViews.from_images(l, np.ma.array(r, mask=hidden), L, R)
    assert not masked.visible[2, 1] and masked.visible.sum() == 23


def test_one_demonstrator_beside_a_batch_of_own_images():
    l, r, _, _ = images()
    _, _, L, R = images(batch=(3,))
    views = FourViews.from_images(l, r, L, R)
    assert views.demo.shape == views.own.shape == (3, 6, 4)
    assert views.with_own(views.own[0]).own.shape == (6, 4)


def test_a_batch_whose_postures_show_different_points_is_never_merged_into_one_body():
    l, r, L, R = images(12, (3,))
    R[1, 4] = np.nan
    views = FourViews.from_images(l, r, L, R)
    for unfit in (lambda: views.used, lambda: views.matches, lambda: views.select(views.usable)):
        with pytest.raises(ValueError, match="for all postures|different points: fit each posture by itself"):
            unfit()
    of_all = views.select(views.usable.all(0))
    assert of_all.used is of_all and of_all.demo.shape == of_all.own.shape == (3, 11, 4)


def test_opencvs_arrays_are_points_of_one_posture():
    l, r, L, R = images()
    views = FourViews.from_images(l[:, None], r[:, None].astype("f4"), L, np.ma.array(R[:, None], mask=False))
    assert views.own.shape == views.demo.shape == (6, 4)
    np.testing.assert_array_equal(views.own, FourViews.from_images(l, r, L, R).own)


def test_wrong_shapes_are_refused_with_the_view():
    l, r, L, R = images()
    with pytest.raises(ValueError, match="own_left: need points of shape"):
        FourViews.from_images(l, r, L[:, :1], R)
    with pytest.raises(ValueError, match="different numbers of points.*own_right: 5"):
        FourViews.from_images(l, r, L, R[:5])
