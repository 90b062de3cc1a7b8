"""Which of the postures visited is the best, where other points are seen at each."""

import numpy as np

from viewimit.servo.observation import Visit
from viewimit.servo.trust_region.gaussian_process import GaussianProcessImages
from viewimit.servo.trust_region.image_models import ImageData
from viewimit.servo.trust_region.options import TrustRegionOptions
from viewimit.servo.trust_region.subproblem import evaluate_visits

POINTS, FEW, MANY = 14, 7, 12
OPTIONS = TrustRegionOptions()
FAR = np.radians((40.0, 0.0))  # what was seen there tells next to nothing here


def visit(away, count):
    """The first so many of the points are seen."""
    seen = np.repeat((np.arange(POINTS) < count)[:, None], 2, 1)
    return Visit.of(away, np.zeros((POINTS, 4)), seen)


def test_what_seven_points_contradict_counts_for_more_than_what_twelve_do():
    """3 coordinates each, of which a homography of space and two joints fit 17 at any posture: 4 of 21 are left, and 19
    of 36. An E that is half as large is no evidence of a better posture then, but one a tenth as large is."""
    visits = visit(np.zeros(2), FEW), visit(FAR, MANY)

    def residuals(share):
        def residual(own, transfer=None, noise_reference=None, rig=0):
            known = np.isfinite(own).all(-1)
            size = share if known.sum() == FEW else 1.0
            return np.full((int(known.sum()), 4), np.sqrt(size))

        return residual

    for share, best in ((0.5, 1), (0.1, 0)):
        measured = evaluate_visits(ImageData(visits, 0.0), residuals(share), None, 0, OPTIONS)
        assert measured.count.tolist() == [FEW, MANY] and measured.best == best


def test_under_noise_a_point_that_is_not_seen_tells_e_only_if_it_is_told_as_well_as_one_that_is():
    """0.3 px off, its prediction weighed as much as images with noise of 0.08 px, and on pictures led 1° astray. Far
    away, where E is large, it leads on."""
    away = np.radians([(0, 0), (15, 0), (15, -15), (8, -8), (3, -20)])
    visits = tuple(visit(where, POINTS) for where in away) + (visit(np.radians((-4.0, 4.0)), MANY),)

    def residual_of(size_px):
        def residual(own, transfer=None, noise_reference=None, rig=0):
            known = np.isfinite(own).all(-1).reshape(-1, POINTS).all(0)
            return np.full((*own.shape[:-2], int(known.sum()), 4), size_px)

        return residual

    spread = GaussianProcessImages.fit(list(visits), len(visits) - 1, 0.08).prediction_std(
        visits[-1].displacement[None]
    )[0, -1]
    assert 0.08 < spread < OPTIONS.max_prediction_std_px
    near, far = residual_of(0.1), residual_of(1.0)  # E of 0.02 and of 2 px²
    assert evaluate_visits(ImageData(visits, 0.08), near, None, 0, OPTIONS).count.tolist() == [POINTS] * len(away) + [
        MANY
    ]
    assert evaluate_visits(ImageData(visits, 0.08), far, None, 0, OPTIONS).count.tolist() == [POINTS] * len(visits)
    assert evaluate_visits(ImageData(visits, 0.0), near, None, 0, OPTIONS).count.tolist() == [POINTS] * len(visits)
