"""What is known about a posture is known of points whose motion was seen, not of those that seem to stand still."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from viewimit.servo.least_squares import minimise
from viewimit.servo.observation import Visit
from viewimit.servo.trust_region.convergence import certify
from viewimit.servo.trust_region.gaussian_process import GaussianProcessImages
from viewimit.servo.trust_region.local_model import EstimationData, local_model

POINTS = 9
PLACES = np.radians([(0, 0), (15, 0), (0, 15), (10, 10), (-10, 5), (3, -8), (0.5, 0.5)])


def known_with(times_seen: int) -> tuple[EstimationData, np.ndarray]:
    """The first joint moves all points alike, and what they have in common is no conflict: it is not told. The first
    point is seen at so many of the last visits, the others always."""
    rng = np.random.default_rng(2)
    y, J = rng.uniform(0, 240, (POINTS, 4)), rng.normal(0, 100, (POINTS, 4, 2))
    J[..., 0] = 50.0
    seen = np.ones((len(PLACES), POINTS, 2), bool)
    seen[: len(PLACES) - times_seen, 0] = False
    visits = tuple(Visit(d, np.where(np.repeat(s, 2, -1), y + J @ d, np.nan), s) for d, s in zip(PLACES, seen))
    best, place = len(PLACES) - 1, PLACES[-1]
    goal = y + J @ place

    def residual_of(own):
        known = np.isfinite(own).all((*range(own.ndim - 2), -1))
        e = own[..., known, :] - goal[known]
        return e - e.mean(-2, keepdims=True)

    model = GaussianProcessImages.fit(list(visits), best, 0.0)
    observed = SimpleNamespace(noise_px=0.0, motion=0, seed=0, lower=np.full(2, -9.0), upper=np.full(2, 9.0))
    return EstimationData(visits, best, 0.0, np.ones(POINTS, bool), model, observed, residual_of), place


@pytest.mark.parametrize("times_seen, looks_told", [(len(PLACES), False), (1, True)])
def test_a_point_whose_motion_was_not_seen_tells_nothing(times_seen, looks_told):
    known, place = known_with(times_seen)
    found = minimise(lambda theta: known.residuals(known.model.predict(theta)), place[None], place - 0.1, place + 0.1)
    here = local_model(known, found, place)
    assert (found.hessian[0, 0] > 10) == looks_told == (here.hessian_all_points[0, 0] > 10)
    assert here.n_points == POINTS - looks_told and here.hessian[0, 0] < 0.5 < here.hessian[1, 1]
    certificate = certify(here)
    assert certificate.observable.tolist() == [False, True] and certificate.needs_more_data == looks_told


@pytest.mark.parametrize("reach_deg, hides", [(1.5, True), (30.0, False)])
def test_what_noise_hides_near_by_can_be_learned_from_farther_away(reach_deg, hides):
    """Slopes from visits that are as near as noise is large tell nothing, though the points tell all joints."""
    rng, noise_px = np.random.default_rng(4), 0.5
    y, J = rng.uniform(0, 240, (POINTS, 4)), rng.normal(0, 20, (POINTS, 4, 2))
    places = PLACES / PLACES.max() * np.radians(reach_deg)
    images = [y + J @ d + noise_px * rng.standard_normal(y.shape) for d in places]
    visits = tuple(Visit(d, own, np.ones((POINTS, 2), bool)) for d, own in zip(places, images))
    observed = SimpleNamespace(noise_px=noise_px, motion=0, seed=0, lower=np.full(2, -9.0), upper=np.full(2, 9.0))
    model, place = GaussianProcessImages.fit(list(visits), len(visits) - 1, noise_px), places[-1]
    residual_of = lambda own: (own - images[-1]) - (own - images[-1]).mean(-2, keepdims=True)
    found = minimise(lambda theta: residual_of(model.predict(theta)), place[None], place - 0.1, place + 0.1)
    known = EstimationData(visits, len(visits) - 1, 0.5, np.ones(POINTS, bool), model, observed, residual_of)
    certificate = certify(local_model(known, found, place))
    assert certificate.observable.all() != hides == certificate.needs_more_data and (
        not hides or certificate.verification_step.any()
    )


def test_a_point_by_which_E_was_not_measured_adds_nothing_to_what_noise_moves():
    """It may be predicted anywhere: on pictures one that was 30 px off made 0.7° to 11°."""
    known, place = known_with(len(PLACES))
    known = replace(
        known, points=np.arange(POINTS) > 0, observation=SimpleNamespace(**vars(known.observation) | {"noise_px": 0.1})
    )
    found = minimise(lambda theta: known.residuals(known.model.predict(theta)), place[None], place - 0.1, place + 0.1)
    astray = lambda own: known.residuals(own + 40.0 * (np.arange(POINTS) == 0)[:, None] * (1, -1, 1, 1))
    both = known.residuals, astray
    right, wrong = (local_model(replace(known, residuals=one, residuals_per_rig=(one,)), found, place) for one in both)
    np.testing.assert_array_equal(wrong.grad_samples_jacobian, right.grad_samples_jacobian)
    np.testing.assert_array_equal(wrong.grad_samples_images, right.grad_samples_images)
    np.testing.assert_array_equal(wrong.hessian, right.hessian)
    assert not wrong.grad_bias_per_rig.any()
