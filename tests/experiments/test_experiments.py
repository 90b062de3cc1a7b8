"""The paper's experiments: figures known beforehand, claims judged, progress that grows."""

import numpy as np
import pytest

from viewimit.experiments.paper import common as claims
from viewimit.experiments.paper import fig7, fig9, fig10
from viewimit.experiments.paper.common import Claims
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings


def by_name(result):
    return {claim.name: claim for claim in result.claims}


@pytest.fixture(scope="module")
def seventh():
    told = []
    result = fig7.run(claims.PAPER, lambda share, partial: told.append((share, partial)), step_deg=2.0, study=(2, 2))
    return result, told


def test_fig7_has_one_minimum_beside_the_demonstrator(seventh):
    surface = seventh[0].surfaces["epipolar"]
    assert len(surface.minima) == 1 and surface.basin == 1.0
    assert np.abs(np.degrees(surface.minima.theta[0]) - (45, -90)).max() < 1.1
    assert surface.E_demo == pytest.approx(1.587, abs=5e-4) and surface.landscape.E.max() == pytest.approx(803, abs=1)
    assert surface.convexity.positive_definite
    assert all(claim.holds in (True, None) for claim in seventh[0].claims)
    assert sum(claim.holds is True for claim in seventh[0].claims) == 4


def test_fig7_other_demonstrators_have_their_lowest_minimum_near_them(seventh):
    study = seventh[0].studies["epipolar"]
    assert (study.on_grid >= study.minima).all() and (study.minima >= 1).all()
    assert (np.abs(study.bias_deg).max(0) < (3.2, 2.4)).all()


@pytest.mark.slow
def test_fig7_other_demonstrators_have_the_bias_that_is_known():
    """Over 30 others a single minimum for 28, mean bias 1.2°/0.6°, at most 3°/2°: a prototype's, on another grid."""
    study = fig7.run(claims.PAPER, step_deg=2.0).studies["epipolar"]
    assert len(study.minima) == 30
    assert abs((study.minima - study.on_limit == 1).sum() - 28) <= 1
    np.testing.assert_allclose(np.abs(study.bias_deg).mean(0), [1.2, 0.6], atol=0.15)
    assert (np.abs(study.bias_deg).max(0) < (3.2, 2.4)).all()
    assert (study.on_grid >= study.minima).all()


def test_fig7_progress_grows_to_one_and_its_parts_with_it(seventh):
    result, told = seventh
    shares = [share for share, _ in told]
    assert shares == sorted(shares) and shares[-1] == pytest.approx(1)
    rows = [sum(len(study.minima) for study in partial.studies.values()) for _, partial in told]
    assert rows == sorted(rows) and rows[-1] == 4 * len(result.studies)
    assert told[0][1].claims  # what is there can be judged at once


def test_fig7_needs_two_joints():
    with pytest.raises(ValueError, match="two moving joints"):
        fig7.run(Settings.paper(joints=(2, 4, 6)))


@pytest.fixture(scope="module")
def ninth():
    told = []
    result = fig9.run(claims.PAPER, lambda share, partial: told.append((share, partial)), (1, 2), 500)
    return result, told


def test_fig9_the_law_as_printed_does_not_arrive_the_others_do(ninth):
    result, _ = ninth
    assert all(run.motions_until(3) is None for run in result.of("gradient"))
    assert all(run.motions_until(3) is not None for run in result.of("gradient-retuned"))
    assert all(run.motions_until(1) is not None and run.status == "settled" for run in result.of("broyden"))
    found = by_name(result)
    assert found["Fig. 9: gradient, came within 3°"].holds is False
    assert found["Fig. 9: gradient, smallest E"].holds is None
    assert found["Fig. 9: gradient-retuned, came within 3°"].holds is True
    assert claims.verdict(result.claims) == "4 of 5 hold; the law as printed does not"
    assert found["Fig. 9: broyden, smallest E"].holds is True


def test_fig9_a_run_is_the_sessions_own(ninth):
    run = ninth[0].of("broyden")[0]
    session = Session(Settings.paper(transfer="epipolar", servo="broyden", start_deg=run.start_deg))
    session.run()
    np.testing.assert_array_equal(run.E, [moment.E for moment in session.history])
    errors = [np.abs(np.degrees(moment.theta) - (45, -90)).max() for moment in session.history]
    np.testing.assert_allclose(run.error_deg, errors)
    assert run.motions_until(3) == next(k for k, error in enumerate(errors) if error <= 3)


def test_fig9_of_seven_joints_starts_about_the_demonstrator_and_shows_the_settings_own_servo():
    settings = Settings.paper(joints=tuple(range(1, 8)), points=16, transfer="projective", servo="likelihood")
    result = fig9.run(settings, starts=(1, 2), max_motions=25, laws=("likelihood",))
    assert result.laws == ("gradient", "gradient-retuned", "likelihood")
    np.testing.assert_allclose([run.start_deg for run in result.runs], result.starts_deg)
    assert len(result.runs) == 3
    offsets = np.abs(np.array(result.starts_deg[1:]) - result.settings.demonstrator_deg)
    assert (offsets <= fig9.OFFSET_DEG + 1e-9).all() and (offsets.max(1) > 10).all()
    assert all(run.motions_until(0.5) is not None for run in result.runs[1:])


@pytest.fixture(scope="module")
def tenth():
    return {name: fig10.run(claims.PAPER, motion=name) for name in ("sinusoid", "circle")}


@pytest.mark.parametrize("name", ["sinusoid", "circle"])
def test_fig10_overlaps_in_the_image_and_in_the_posture(tenth, name):
    result = tenth[name]
    assert all(claim.holds in (True, None) for claim in result.claims)
    run = result.runs[fig10.CONVERGED]
    assert np.median(run.image_px) < 1 and np.median(run.joint_deg) < 1
    assert np.median(result.runs[fig10.BODY].image_px) < 0.5 * np.median(run.image_px)


def test_fig10_a_transfer_of_the_same_posture_has_the_figures_that_are_known(tenth):
    """A prototype's: 0.21 px in the image and 2.7 mm at the hand, on another motion."""
    run = tenth["sinusoid"].runs[fig10.SAME]
    assert np.median(run.image_px) < 0.21 and 1e3 * np.median(run.hand_m) == pytest.approx(2.7, abs=0.3)


def test_fig10_a_transfer_fitted_before_convergence_is_far_off(tenth):
    for result in tenth.values():
        converged, before = result.runs[fig10.CONVERGED], result.runs[fig10.BEFORE]
        assert np.median(before.hand_m) > 50 * np.median(converged.hand_m)
        assert by_name(result)["Fig. 10: before against converged, hand"].holds is True


def test_fig10_follows_a_recorded_motion_like_any_other_and_judges_it_not(tenth):
    named = tenth["sinusoid"]
    recorded = fig10.run(claims.PAPER, motion=named.motion)
    np.testing.assert_array_equal(recorded.runs[fig10.BODY].theta, named.runs[fig10.BODY].theta)
    assert all(claim.holds is None for claim in recorded.claims)
    assert "may be as rough as it likes" in by_name(recorded)["Fig. 10: converged, image"].tolerance


def test_fig10_without_points_is_told():
    with pytest.raises(ValueError, match="too few points"):
        fig10.run(Settings.paper(missing=1.0), max_motions=2)


OTHERS = ({"transfer": "linear"}, {"scene": "iiwa"}, {"points": 16}, {"noise_px": 0.1}, {"demonstrator_deg": (40, -90)})


def test_other_settings_are_judged_by_what_the_paper_claims_in_general():
    def of(**changes):
        made = Claims(Settings.paper(**{"transfer": "epipolar", **changes}))
        return [made.limit(what) for what in ("minimum", "minima", "near", "joints")]

    assert of() == of(demonstrator_deg=(45, -90), servo="gradient", seed=3, start_deg=(1, -1)) == [4, 1, 3, 1]
    assert all(of(**change) == [4, 1, 4, None] for change in OTHERS)


def test_a_toed_in_head_misses_what_the_paper_claims():
    settings = Settings.paper(scene="panda-verged", rectify="off")
    found = by_name(fig7.run(settings, step_deg=3.0, study=(1, 1)))
    assert found["Fig. 7: smallest E"].holds is False
    assert found["Fig. 7: smallest E"].tolerance == "4° of demonstrator"
