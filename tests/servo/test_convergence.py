"""A claim needs evidence: E as it was measured, in every direction, by more than noise and the predictions' errors."""

import math
from dataclasses import replace

import numpy as np
import pytest

from viewimit.servo.trust_region.convergence import certify, curvature_directions
from viewimit.servo.trust_region.local_model import LocalModel
from viewimit.servo.trust_region.options import TrustRegionOptions

POINTS, OPEN = 10, np.full(2, 9.0)
OPTIONS = TrustRegionOptions()
FLAT, STEEP = 60.0, 600.0  # px²/rad²: as in the default scene


def model_of(away_deg, curvatures=(FLAT, STEEP), true=None, **changes):
    """Visits away from the best, E measured as the `true` curvatures make it, by default those predicted."""
    away, predicted = np.radians(np.reshape(away_deg, (-1, 2))), np.diag(curvatures).astype(float)
    rise = 0.5 * np.einsum("ka,a,ka->k", away, np.array(curvatures if true is None else true, float), away)
    here = LocalModel(
        hessian=predicted,
        hessian_all_points=predicted,
        E=1e-9,
        n_points=POINTS,
        n_visible=POINTS,
        newton_step=np.zeros(2),
        grad_samples_images=np.zeros((1, 2)),
        grad_samples_jacobian=np.zeros((1, 2)),
        grad_bias_per_rig=np.zeros((0, 2)),
        image_gram=np.diag([2e4, 2e4]),
        offsets=away,
        increase=rise,
        hessians=np.repeat(predicted[None], len(away), 0),
        hessian_single=predicted,
        lower=-OPEN,
        upper=OPEN,
        noise_px=0.0,
    )
    return replace(here, **{"hessian_single": changes.get("hessian", predicted), **changes})


BOTH = (2, 0), (0, 2)


@pytest.mark.parametrize(
    "joints, seen, claim", [(2, 6, "settled"), (2, 7, "converged"), (7, 8, "settled"), (7, 9, "converged")]
)
def test_points_that_a_homography_of_space_and_the_joints_fit_by_themselves_allow_no_claim(joints, seen, claim):
    """3 coordinates a point against 15 numbers and the joints: 18 and 17, 21 and 17; 24 and 22, 27 and 22."""
    away, hessian = np.radians(2) * np.eye(joints), 600.0 * np.eye(joints)
    here = replace(
        model_of(BOTH),
        hessian=hessian,
        hessian_all_points=hessian,
        newton_step=np.zeros(joints),
        grad_samples_images=np.zeros((1, joints)),
        grad_samples_jacobian=np.zeros((1, joints)),
        grad_bias_per_rig=np.zeros((0, joints)),
        image_gram=2e4 * np.eye(joints),
        offsets=away,
        increase=0.5 * np.einsum("ka,ab,kb->k", away, hessian, away),
        hessians=np.repeat(hessian[None], joints, 0),
        hessian_single=hessian,
        lower=np.full(joints, -9.0),
        upper=np.full(joints, 9.0),
        n_visible=seen,
    )
    assert certify(here).status == claim


def test_visits_that_show_a_rise_along_every_direction_allow_the_claim():
    found = certify(model_of(BOTH))
    assert (
        found.verified and found.observable.all() and not found.verification_step.any() and found.status == "converged"
    )


@pytest.mark.parametrize("away_deg, asked", [([], 0), ([(0, 2)], 0), ([(2, 0)], 1), ([(1, 3), (0, 2)], 0)])
def test_without_a_visit_along_it_a_direction_is_asked_by_a_motion_the_flattest_first(away_deg, asked):
    """Nor is a visit evidence at which another direction makes most of the rise."""
    found = certify(model_of(away_deg))
    assert found.status == "settled" and np.linalg.norm(found.verification_step) == pytest.approx(
        OPTIONS.verification_step
    )
    assert np.abs(found.verification_step).argmax() == asked


def test_trusted_kinematics_are_evidence_of_a_rise_that_no_visit_shows():
    found = certify(model_of([], trusted=True))
    assert found.status == "converged" and not found.verification_step.any()
    assert certify(model_of([])).status == "settled"


def test_a_visit_that_shows_no_rise_speaks_against_trusted_kinematics():
    found = certify(model_of([(2, 0), (0, 2)], true=(0, STEEP), trusted=True))
    assert found.status == "unobservable" and found.unobservable_joints == [0]


def test_a_rise_that_the_other_directions_make_is_no_evidence_of_a_flat_one():
    """Two thirds of what is predicted there are the first joint's, which tells nothing; more than half is measured, as
    the second's curvature is half as large again as predicted."""
    here = model_of([(6, 1.36), (0, 2)], true=(0, 1.5 * STEEP))
    predicted = 0.5 * here.offsets[0] @ here.hessian @ here.offsets[0]
    own = 0.5 * FLAT * np.radians(6) ** 2
    assert own == pytest.approx(2 / 3 * predicted, rel=0.02) and here.increase[0] >= 0.5 * predicted
    found = certify(here)
    assert found.status == "settled" and np.abs(found.verification_step).argmax() == 0


@pytest.mark.parametrize("far_deg", [0.9, np.degrees(OPTIONS.max_evidence) + 0.1])
def test_what_is_too_near_or_too_far_is_no_evidence(far_deg):
    assert not certify(model_of([(far_deg, 0), (0, 2)])).verified


@pytest.mark.parametrize("share, claim", [(0.6, "converged"), (0.4, "settled"), (0.001, "unobservable")])
def test_a_curvature_that_was_only_predicted_is_no_evidence(share, claim):
    """Along the first joint E rises by a share of what is predicted; where it does not rise the joint is not told."""
    found = certify(model_of(BOTH, true=(share * FLAT, STEEP)))
    assert found.status == claim and found.observable.tolist() == [claim != "unobservable", True]
    assert np.isfinite(found.std_error).tolist() == found.observable.tolist()


def test_thresholds_scale_with_the_camera():
    """With pixels half as large all px² are four times as many, and nothing else changes."""
    for true in ((FLAT, STEEP), (0.4 * FLAT, STEEP), (0.001 * FLAT, STEEP)):
        here = model_of(BOTH, true=true)
        names = "hessian", "E", "image_gram", "increase", "hessians", "hessian_single"
        finer = replace(here, noise_px=2 * here.noise_px, **{name: 4 * getattr(here, name) for name in names})
        assert certify(finer).status == certify(here).status
        np.testing.assert_allclose(certify(finer).std_error, certify(here).std_error)


def test_a_joint_that_a_pixel_turns_by_20_degrees_is_not_told():
    flattest = 1 / (POINTS * OPTIONS.max_std_per_px**2)
    for curvature, told in ((0.9 * flattest, False), (1.1 * flattest, True)):
        here = model_of(BOTH, (curvature, STEEP), image_gram=np.diag([1e3, 1e3]))
        assert certify(here).observable.tolist() == [told, True]


@pytest.mark.filterwarnings("error")
def test_where_noise_explains_all_curvature_nothing_is_told_and_nothing_overflows():
    here = replace(model_of(BOTH, hessian=np.zeros((2, 2))), noise_px=0.1, grad_samples_images=np.ones((3, 2)))
    found = certify(here)
    assert found.status == "unobservable" and not found.observable.any() and np.isinf(found.std_error).all()


def test_noise_hides_rises_and_asks_for_longer_motions():
    here = replace(model_of([(6, 0), (0, 6)]), noise_px=0.05)
    assert certify(here).verified
    loud = certify(replace(here, noise_px=1.0))
    assert not loud.verified and np.linalg.norm(loud.verification_step) >= OPTIONS.verification_step_noisy
    assert certify(model_of([], noise_px=0.01)).verification_step.any()


def test_the_expected_error_is_of_what_is_left_of_E_if_that_is_more_than_noise():
    quiet = model_of(BOTH)
    freedom = quiet.degrees_of_freedom
    loud = replace(quiet, E=0.5 * freedom / POINTS * 0.2**2)  # as residuals of 0.2 px make it
    np.testing.assert_allclose(certify(loud).std_error, 0.2 * certify(quiet).std_per_px)
    np.testing.assert_allclose(certify(replace(loud, noise_px=0.3)).std_error, 0.3 * certify(quiet).std_per_px)


def test_directions_are_the_eigenvectors_the_flattest_first():
    matrix = np.cov(np.random.default_rng(1).normal(size=(7, 20)))
    found, (values, vectors) = curvature_directions(matrix), np.linalg.eigh(matrix)
    np.testing.assert_allclose(matrix @ found, found * values, atol=1e-12)
    np.testing.assert_allclose(np.abs((found * vectors).sum(0)), 1)


def test_what_other_heads_would_move_the_least_by_is_expected_as_well():
    here = model_of(BOTH)
    away = np.radians(((0.3, 0.0), (0.4, 0.2)))  # by each of two
    told = certify(replace(here, grad_bias_per_rig=away * (FLAT, STEEP)))
    without = certify(here).std_error
    np.testing.assert_allclose(told.std_error, np.sqrt(without**2 + np.radians((0.5, 0.2)) ** 2))


@pytest.mark.parametrize("joints", [1, 2, 7])
def test_the_simultaneous_error_holds_the_largest_of_all_joints_as_often_as_two_sigma_holds_one(joints):
    """Šidák: of independent errors, all are within 2 s with the probability that a single one is within 2 σ."""
    here = model_of(BOTH)
    found = replace(certify(here), std_error=np.full(joints, np.radians(0.5)))
    bound = 2 * found.simultaneous_std_error / np.radians(0.5)
    within = lambda sigmas: math.erf(sigmas / math.sqrt(2))
    assert within(bound) ** joints == pytest.approx(within(2.0))
    assert found.simultaneous_std_error == pytest.approx(np.radians(0.5)) or joints > 1
