"""What claims are worth is measured on bodies whose joints are told, and on some whose joints are not."""

from dataclasses import replace

import numpy as np
import pytest
from axle_markers import stretched
from scipy.stats import kstest

from viewimit.experiments.bench import calibration, draws
from viewimit.experiments.bench.benchmark import Context
from viewimit.experiments.bench.calibration import CASES, Case, Ending, calibration_table, outcome, run, run_once
from viewimit.experiments.bench.draws import SurfaceEyes, draw_marked_arm, surface_points
from viewimit.servo import ServoStatus
from viewimit.simulation.scene import load_scene

NAMED = {case.name: case for case in CASES}


def test_no_joint_is_claimed_that_all_points_are_rigid_to():
    forearm = Case("forearm", 12, (calibration.RIGID[0],))
    observable, rigid = run([CASES[0], forearm], runs=2, seed=5, context=Context.in_processes(1))
    assert observable.claimed.count == 2 and observable.falsely.count == 0 and observable.unended.count == 0
    assert rigid.claimed.count == 0 and rigid.unobservable.count == 2 and rigid.falsely is None


def test_points_are_on_the_links_surface_and_hidden_where_it_is_turned_away():
    scene, rng = load_scene("panda"), np.random.default_rng(0)
    body, normals = surface_points(scene.robot, (2, 3), 40, rng)
    assert set(body.link) <= {2, 3} and np.allclose(np.linalg.norm(normals, axis=1), 1)
    theta = np.radians((45, -90))
    _, all_seen = SurfaceEyes(scene, body, None).own_images(theta)
    _, seen = SurfaceEyes(scene, body, normals).own_images(theta)
    _, turned = SurfaceEyes(scene, body, -normals).own_images(theta)
    assert all_seen.all() and 0 < seen.sum() < seen.size and (seen ^ turned).all()


@pytest.mark.parametrize(
    "error, expected, falsely, covered",
    [(0.9, 0.1, 0, 0), (1.1, 0.3, 1, 0), (1.1, 0.4, 0, 0), (1.1, 0.6, 0, 1), (0.1, np.nan, 0, 0)],
)
def test_a_claim_is_false_that_is_far_off_and_farther_than_it_expects(error, expected, falsely, covered):
    found = outcome(
        "one",
        [
            Ending(ServoStatus.CONVERGED, 7, True, error, expected),
            Ending(ServoStatus.NO_PROGRESS, 9, True, 50.0, np.inf),
        ],
    )
    assert (found.falsely.count, found.covered.count, found.claimed.count) == (falsely, covered, 1)
    assert found.falsely.runs == 1 and found.motions_median == 8


@pytest.mark.parametrize("k", [1, 18, 20])
def test_along_a_valley_without_evidence_no_run_goes_on_for_ever(k):
    """What a step had not kept was promised again, from the same place, for 300 motions."""
    ending = run_once(NAMED["5 points"], [3, k])
    assert ending.ended and not ending.claimed


@pytest.mark.parametrize("k", [88, 115])
def test_a_valley_that_hardly_sinks_is_not_followed_from_end_to_end(k):
    """Motions of 0.3° each kept their promise, of 0.3 % of an E of 10⁻⁶ px²: 124 and 84 of them, and 300 elsewhere."""
    ending = run_once(NAMED["5 points"], [41, k])
    assert ending.status == ServoStatus.UNOBSERVABLE and ending.motions < 30


def test_a_promise_that_is_broken_makes_no_region_larger():
    """Where two postures were the best by turns, each motion from one seemed as long as the way from the other, and the
    region about both grew with every failure, for 300 motions."""
    assert run_once(NAMED["20 points, hidden by surfaces"], [31, 394]).ended


@pytest.mark.parametrize("k", [246, 416])
def test_a_line_that_is_known_or_ends_at_a_limit_is_left_for_where_nobody_was(k):
    """In the corner of the range nothing was left of it, and half-way along what had been visited nobody else was in
    sight: both runs rested 91° and 174° off."""
    ending = run_once(NAMED["20 points, hidden by surfaces"], [31, k])
    assert ending.claimed and ending.within(calibration.N_SIGMA_COVERED) and ending.error < 0.1


def test_slopes_that_only_the_probes_tell_are_looked_at_again_before_a_claim():
    """Twelve of 15 visits were within a degree of each other: their images were told, but hardly how they change, and
    16° off the run claimed to be within 3°."""
    assert not run_once(NAMED["noise 1.0 px, 1 frame"], [41, 12]).false


def test_two_postures_that_are_best_by_turns_are_not_visited_by_turns_for_ever():
    assert run_once(NAMED["20 points, hidden by surfaces"], [31, 206]).motions < calibration.MAX_MOTIONS / 6


def test_where_surfaces_hide_points_every_joint_that_can_be_told_is_found():
    """Of 30 runs a case all are that can be told; before, points that were predicted from afar led 3 in 40 astray, and
    3 in 40 stopped where too few of their own points were in sight."""
    (found,) = run([NAMED["20 points, hidden beyond the rim"]], 8, seed=0, context=Context.in_processes(1))
    assert found.within_observable.count == found.within_observable.runs == found.observable.count >= 5
    assert found.falsely is None or found.falsely.count == 0


@pytest.mark.parametrize("k", [1231, 5818])
def test_a_joint_that_moves_nothing_in_sight_is_not_taken_for_an_arm_that_does_not_obey(k):
    """What a hundredth of a degree of the other joint had moved seemed to be its doing, so that its images should have
    changed; led by images alone, the arm went to and fro for 300 motions."""
    ending = run_once(NAMED["16 points on rigid groups of links"], [51, k])
    assert ending.status == ServoStatus.UNOBSERVABLE and ending.motions < 30


@pytest.mark.parametrize("k", [10, 69, 75])
def test_points_that_one_camera_alone_sees_tell_a_joint_that_the_others_leave_open(k):
    """Of these no point of the base was in sight of both cameras: 24°, 87° and 84° off before."""
    ending = run_once(NAMED["20 points, hidden beyond the rim"], [41, k])
    assert ending.observable and ending.error < 0.01 and ending.within(calibration.N_SIGMA_COVERED)


@pytest.mark.parametrize("k", [187, 207])
def test_points_seen_too_rarely_to_tell_how_they_move_tell_no_joint(k):
    """That they were taken to stand still looked like a conflict with every posture but one, 1.9° and 18° off."""
    assert not run_once(NAMED["20 points, hidden beyond the rim"], [2026, k]).false


def mirror_images(marked):
    """Places (2 n, 3) m of the markers on the stretched arm, and where their mirror images are: those of the other one
    of a pair across the arm's plane, each one's own in that plane."""
    frames = stretched(load_scene(marked.scene))[marked.body.link]
    places = np.einsum("nij,nj->ni", frames[:, :3, :3], marked.body.local) + frames[:, :3, 3]
    across = marked.arm.pair_axis == draws.Y
    other = places.reshape(-1, 2, 3)[:, ::-1].reshape(-1, 3) if across else places
    return places, other * (1, -1, 1)


def test_symmetric_markers_are_exactly_so_or_2_to_10_mm_away_from_it():
    exact, arms = 0, set()
    for seed in range(60):
        marked = draw_marked_arm(np.random.default_rng(seed), True)
        arms.add(marked.arm)
        places, mirrored = mirror_images(marked)
        apart = np.linalg.norm(places - mirrored, axis=1)
        exact += (exactly := apart.max() < 1e-9)
        assert exactly or (0.001 < np.sqrt(np.mean(apart**2)) and apart.max() < 2 * 0.010)
        side = np.abs(places[:, draws.Y])
        np.testing.assert_allclose(
            side, 0.07 if marked.arm.pair_axis == draws.Y else 0.0, atol=1e-9 if exactly else 0.010
        )
    assert 15 < exact < 45 and arms == set(draws.ARMS)


def test_markers_between_the_sides_are_not_symmetric():
    for seed in range(10):
        places, mirrored = mirror_images(draw_marked_arm(np.random.default_rng(seed), False))
        assert np.abs(places - mirrored)[:, draws.Y].max() > 0.03 and np.abs(places[:, draws.Y]).max() < 0.07


def test_an_arms_limits_allow_each_posture_and_its_mirror_image():
    for arm in draws.ARMS:
        scene = load_scene(arm.scene)
        np.testing.assert_array_equal(scene.lower, -scene.upper)


def test_of_symmetric_markers_no_claim_is_of_the_mirrored_posture():
    both, between = (NAMED[f"markers {where}, 0.05 px"] for where in ("on both sides", "between the sides"))
    for found in run([both, between], 8, seed=2, context=Context.in_processes(1)):
        assert found.claimed.count >= 4 and found.falsely.count == found.unended.count == 0


def test_the_bound_of_each_run_says_which_ones_could_be_claimed():
    ends = [
        ("converged", 0.2),
        ("no-progress", 0.9),
        ("converged", 1.0),
        ("no-progress", 1.1),
        ("unobservable", np.inf),
    ]
    found = outcome("one", [Ending(ServoStatus(status), 7, True, 0.5, 0.5, bound) for status, bound in ends])
    assert (found.claimed_within_bound.count, found.claimed_within_bound.runs) == (2, 3)
    assert found.no_progress.count == 2 and found.observable.count == 4 and found.bound_deg_median == 1.0
    assert (
        outcome("one", [Ending(ServoStatus.UNOBSERVABLE, 7, True, 50.0, np.inf, np.inf)]).claimed_within_bound is None
    )


def test_the_bound_is_that_of_the_averaged_frames():
    case = Case("one", noise_px=0.25, frames=25)
    one, averaged = (run_once(replace(case, frames=frames), [1, 0]).bound for frames in (1, 25))
    assert 0 < averaged < 1 and one == pytest.approx(5 * averaged)
    assert run_once(CASES[0], [1, 0]).bound == 0
    assert run_once(Case("forearm", 12, (calibration.RIGID[0],)), [5, 0]).bound == np.inf


def test_a_demonstrator_is_moved_along_the_line_of_sight():
    scenes = [load_scene(draws.distant_scene(distance, 0.2)) for distance in (0.6, 6.0)]
    usual = load_scene(draws.DISTANT_SCENE)
    for scene, distance in zip(scenes, (0.6, 6.0)):
        head, base, gaze = scene.head.position, scene.demonstrator.position, scene.head.gaze_demonstrator
        away = np.subtract(base, head)[:2]
        assert np.hypot(*away) == pytest.approx(distance) and scene.head.baseline == 0.2
        usual_away = np.subtract(usual.demonstrator.position, usual.head.position)[:2]
        assert np.linalg.det([away, usual_away]) == pytest.approx(0, abs=1e-12)
        shift = np.subtract(base, usual.demonstrator.position)
        np.testing.assert_allclose(np.subtract(gaze, usual.head.gaze_demonstrator), shift, atol=1e-12)


def test_distances_and_baselines_are_drawn_evenly_on_a_logarithmic_scale():
    rng = np.random.default_rng(0)
    scenes = [load_scene(draws.draw_distant_scene(rng)) for _ in range(300)]
    away = [np.hypot(*np.subtract(scene.demonstrator.position, scene.head.position)[:2]) for scene in scenes]
    for found, (low, high) in (
        (away, draws.DISTANCE_M),
        ([scene.head.baseline for scene in scenes], draws.DISTANT_BASELINE_M),
    ):
        assert kstest(np.log(found), "uniform", (np.log(low), np.log(high / low))).pvalue > 0.01


def test_behind_a_demonstrator_near_or_far_runs_end_in_true_claims():
    (found,) = run(
        [NAMED["demonstrator at 0.6 to 6 m, baseline 5 to 60 cm, 0.25 px"]],
        12,
        seed=41,
        context=Context.in_processes(1),
    )
    assert found.no_progress.count == 0 and found.falsely.count == 0
    assert found.claimed_within_bound.count == found.claimed_within_bound.runs
    assert found.covered.count >= 11


def test_a_row_of_the_table_has_a_cell_under_each_heading():
    table = calibration_table(
        run(
            [CASES[0], NAMED["demonstrator at 0.6 to 6 m, baseline 5 to 60 cm, 0.25 px"]],
            1,
            context=Context.in_processes(1),
        )
    )
    heads, *rows = table.splitlines()
    assert {len(row) for row in rows} == {len(heads)} and "if bound ≤1°" in heads and "no progress" in heads


def test_points_swapped_in_vain_are_swapped_back_before_a_reason_is_looked_for():
    """Far from the demonstrator swapped points lower E, but explain no posture: neither does any body like the own."""
    ending = run_once(NAMED["markers between the sides, 0.25 px"], [7, 11])
    assert ending.claimed and not ending.false
