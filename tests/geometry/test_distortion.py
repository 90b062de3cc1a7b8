"""Radial distortion and its inverse, by the equation that it solves and by bisection."""

import numpy as np
import pytest

from viewimit.geometry.distortion import LensDistortion, RadialDistortion

LENSES = [(-0.3, 0.1), (0.16, -0.5), (0.5, -0.3), (1.0, -0.5), (0.3, -0.1), (0.2, -0.05), (5.0, 5.0), (-0.1, 0.0),
          (-2.0, 2.0), (0.05, 0.0), (0.1, -0.25)]  # fmt: skip


def halved(by: RadialDistortion, seen: float) -> float:
    """r by bisection, of a distorted radius within `max_distorted_radius`."""
    low, high = 0.0, min(by.max_radius, 100.0)
    for _ in range(200):
        middle = (low + high) / 2
        low, high = (middle, high) if middle * (1 + by.k1 * middle**2 + by.k2 * middle**4) < seen else (low, middle)
    return low


@pytest.mark.parametrize("k1, k2", [(10.01, 0.0), (0.0, -10.01), (np.nan, 0.0), (0.0, np.inf)])
def test_coefficients_that_no_lens_has_are_refused(k1, k2):
    with pytest.raises(ValueError, match="is none of a lens: both are within ±10, in focal lengths"):
        RadialDistortion(k1, k2)


@pytest.mark.parametrize("k1, k2", LENSES)
def test_the_inverse_restores_the_radius(k1, k2):
    by = RadialDistortion(k1, k2)
    r = np.linspace(0, 0.999 * min(by.max_radius, 4.0), 60)
    seen = r * (1 + k1 * r**2 + k2 * r**4)
    found = seen * by.inverse_factor(seen**2)
    assert found == pytest.approx(r, rel=1e-6)  # digits are lost as the square root towards the rim
    assert found[::7] == pytest.approx([halved(by, each) for each in seen[::7]], rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("k1, k2", LENSES)
def test_the_undistorted_radius_increases_with_the_distorted_one(k1, k2):
    by = RadialDistortion(k1, k2)
    seen = np.linspace(0, 3 * min(by.max_distorted_radius, 4.0), 500)
    assert (np.diff(seen * by.inverse_factor(seen**2)) > 0).all()


@pytest.mark.parametrize(
    "k",
    [(-0.3, 0.1, 0.001, -0.002, 0.0), (-0.2, 0.05, 0, 0, -0.01), (0.1, -0.3, 0.003, 0.001, 0.4), (0, 0, 0.01, 0, 0)],
)
def test_five_coefficients_are_opencvs(k):
    cv2 = pytest.importorskip("cv2")
    pinhole = np.random.default_rng(0).uniform(-0.5, 0.5, (300, 2))
    seen, _ = cv2.projectPoints(
        np.column_stack([pinhole, np.ones(300)]), np.zeros(3), np.zeros(3), np.eye(3), np.array(k)
    )
    np.testing.assert_allclose(LensDistortion.of(*k).undistorted(seen[:, 0]), pinhole, atol=1e-9)


def test_beyond_the_fold_there_is_no_point():
    by = LensDistortion.of(-0.3, 0.0, 0.001, 0.0)
    found = by.undistorted(np.array([[0.3, 0.0], [0.9, 0.0], [np.nan, 0.0]]))
    assert np.isfinite(found[0]).all() and np.isnan(found[1:]).all()
