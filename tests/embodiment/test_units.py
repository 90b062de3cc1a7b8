"""A run ends the same whatever unit its eyes measure in: pixels, other units of length, or focal lengths."""

import runpy
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings, strategies

from viewimit import FourViews, Session
from viewimit.estimation.noise import rounding_std
from viewimit.geometry.rectification import Rectification

FakeRobot = runpy.run_path(str(Path(__file__).parents[2] / "examples" / "fake_robot.py"))["FakeRobot"]
FOCAL_PX = 1100.0
SCALES = 0.01, 1 / FOCAL_PX, 37.0  # of pixels: hundreds of them, normalised coordinates, and a finer grid


class ScaledEyes(FakeRobot):
    """The same images in another unit. whole: rounded to whole pixels before."""

    def __init__(self, scale, noise_px, seed, whole=False):
        rng = np.random.default_rng(seed)
        super().__init__(np.degrees(rng.uniform(self.lower, self.upper)))
        self.scale, self.noise, self.rng, self.whole = scale, noise_px, rng, whole

    def look(self):
        seen = super().look()
        demo, own = (images + self.noise * self.rng.standard_normal(images.shape) for images in (seen.demo, seen.own))
        if self.whole:
            demo, own = demo.round(), own.round()
        return FourViews(self.scale * demo, self.scale * own, seen.visible)


def end(scale, noise_px, seed, whole=False, **changes):
    robot = ScaledEyes(scale, noise_px, seed, whole)
    return Session.of(robot, robot, seed=seed, **changes).run(120)


@given(
    scale=strategies.sampled_from(SCALES),
    noise_px=strategies.sampled_from([0.0, 0.1, 0.5]),
    seed=strategies.integers(0, 2**16),
)
@settings(max_examples=3)
def test_a_run_ends_the_same_in_any_unit(scale, noise_px, seed):
    """Rounding differs, and by a condition of 10⁴ what it leaves of an angle stays under 10⁻⁷ rad."""
    in_px, scaled = (end(one, noise_px, seed) for one in (1.0, scale))
    assert (scaled.status, scaled.motions) == (in_px.status, in_px.motions)
    np.testing.assert_allclose(scaled.theta, in_px.theta, atol=1e-6)
    np.testing.assert_allclose(scaled.E / scale**2, in_px.E, rtol=1e-3, atol=1e-9)
    for name in ("expected", "spread"):
        of_px, of_scaled = (getattr(one.last.certificate, name, np.zeros(1)) for one in (in_px, scaled))
        np.testing.assert_allclose(of_scaled * (scale if name == "spread" else 1), of_px, rtol=1e-3, atol=1e-6)


@pytest.mark.parametrize("servo", ["broyden", "kalman", "gauss-newton"])
def test_so_it_does_by_other_laws_but_for_their_priors_in_pixels(servo):
    in_px, scaled = (end(scale, 0.1, 4, servo=servo) for scale in (1.0, 0.01))
    assert scaled.status == in_px.status == "settled"
    np.testing.assert_allclose(scaled.theta, in_px.theta, atol=np.radians(0.01))


@pytest.mark.parametrize("scale", [1.0, 0.1, 0.01])
def test_a_grid_of_pixels_is_found_in_decimal_parts(scale):
    points = np.random.default_rng(3).uniform(0, 400, (20, 4)).round() * scale
    assert rounding_std(points, np.ones((20, 2), bool)) == pytest.approx(scale / np.sqrt(12))
    fine = np.random.default_rng(3).uniform(0, 400, (20, 4)) * scale
    assert rounding_std(fine, np.ones((20, 2), bool)) == 0.0


def test_a_rectification_in_other_units_maps_the_same_points():
    rng = np.random.default_rng(2)
    turned = Rectification(
        *(np.eye(3) + rng.uniform(-1, 1, (2, 3, 3)) * [[0.1, 0.1, 5], [0.1, 0.1, 5], [1e-4, 1e-4, 0]])
    )
    images = rng.uniform(0, 640, (9, 4))
    scaled = turned.in_units(0.01)
    np.testing.assert_allclose(0.01 * scaled.apply(images / 0.01), turned.apply(images), rtol=1e-9)
    assert turned.in_units(0.01) is scaled
