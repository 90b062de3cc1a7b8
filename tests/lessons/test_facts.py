"""Facts and records of the lessons against other ways to compute them."""

import numpy as np
import oracles
import pytest
from viewimit.app.lab.lessons import facts, records, sign
from viewimit.app.lab.lessons.circle import follow_circle
from viewimit.app.lab.lessons.situation import Situation, move_eyes
from viewimit.app.lab.lessons.source import shipped
from viewimit.app.lab.lessons.step_data import step_data

from viewimit import Settings
from viewimit.analysis.landscape import conflict_at
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World

SIGMAS = 4.0  # of a sample's scatter


def situation(demonstrator=(62, -118), start=(25, -45), **fields):
    settings = {"demonstrator_deg": demonstrator, "start_deg": start, **fields}
    return Situation(Settings.paper(**settings))


def test_a_dolly_zoom_keeps_the_arms_size_in_the_images():
    scene = load_scene("panda")
    theta = np.radians(scene.posture_deg)[scene.moving]

    def spread(of):
        world = World(of, 10)
        images = np.concatenate([world.demo_images(theta)[0], world.own_images(theta)[0]], 1)
        return images.std(0, ddof=0)

    far = move_eyes(scene, "distance", 10.0)
    # It keeps the mean square over the images; each one alone changes with perspective and direction.
    assert (spread(far) ** 2).sum() == pytest.approx((spread(scene) ** 2).sum(), rel=1e-9)
    assert move_eyes(scene, "baseline", 25).head.baseline == 0.25
    with pytest.raises(ValueError, match="there are distance, baseline"):
        move_eyes(scene, "height", 1)


def test_a_claim_s_probability_is_the_share_of_normal_errors_within_a_degree():
    class Errors:
        std_error = np.radians([0.8, 1.7])

    drawn = np.random.default_rng(1).normal(0, [0.8, 1.7], (200_000, 2))
    share = (np.abs(drawn) <= 1).all(1).mean()
    assert records.claim_probability(Errors) == pytest.approx(share, abs=SIGMAS * np.sqrt(0.25 / len(drawn)))
    Errors.std_error = np.array([np.inf, 0.0])
    assert records.claim_probability(Errors) == 0.0


def test_the_smallest_E_is_lower_than_all_around():
    one = situation()
    found, start = records.minima(one), one.start
    ring = found.theta[0][:, None] + np.radians(0.01) * np.array([np.cos(a := np.linspace(0, 6.3, 40)), np.sin(a)])
    E = conflict_at(one.world, start.fit, start.views.demo, start.views.visible[:, :2], ring)[0]
    assert (E > found.E[0]).all() and found.E[0] <= np.nanmin(records.landscape(one, 1.0).E)


@pytest.mark.slow
def test_exact_cameras_have_no_bias():
    """The projective transfer is exact for pinhole cameras: to the search's smallest step, at any distance."""
    found = records.biases(situation((45, -90), (45, -90)))
    assert max(found["degrees"]["projective"]) < 1e-3
    assert found["times"][0] == 1.0 and len(found["degrees"]["epipolar"]) == len(found["times"])


def test_clouds_shrink_with_the_square_root_of_the_images():
    one = situation((45, -90), (25, -25), transfer="linear", noise_px=0.5)
    shrinks = facts.FACTS["times the cloud shrinks"].of(one)
    # Each of two variances of n draws has a relative standard error of √(2/n); their ratio's root half of √2 times it.
    assert shrinks == pytest.approx(5.0, rel=SIGMAS / np.sqrt(records.RUNS))
    assert np.array(records.clouds_record(one)["averaged"]).shape == (records.RUNS, 2)


def test_a_pixel_costs_what_the_curvature_says():
    """With noise in the own images only, the cloud's scatter is the standard error that J of the residuals gives."""
    one = situation((45, -90), (25, -25), transfer="linear")
    noise_px, draws = 0.02, 2_000  # small: the residuals are linear
    cloud = records.sample_estimates(
        one.world, one.start.fit, one.start.theta_demo, noise_px, 1, draws, np.random.default_rng(2), noisy_demo=False
    )
    # (JᵀJ)⁻¹ is of independent residuals of 1 px. The fit takes up a part of the noise, and residuals are left: less.
    assert (cloud.std(0) / noise_px <= records.costs(one) * (1 + SIGMAS / np.sqrt(2 * draws))).all()


def test_the_demonstrator_is_carried_and_the_eyes_follow():
    one = situation()
    there = oracles.carried_to(one, 0.5, 0.25)
    assert np.subtract(there.scene.demonstrator.position, one.scene.demonstrator.position) == pytest.approx(
        [0.5, 0.25, 0]
    )
    gaze = "gaze_demonstrator"
    assert np.subtract(getattr(there.scene.head, gaze), getattr(one.scene.head, gaze)) == pytest.approx([0.5, 0.25, 0])
    assert np.array_equal(there.start.views.own, one.start.views.own) and there.start.usable.all()
    assert oracles.carried_to(one, 0, 0).start.E == pytest.approx(one.start.E, rel=1e-9)


def test_rectified_matches_lie_in_equal_rows():
    one = situation((45, -90), (25, -25), scene="panda-toed")
    made = records.rectification_record(one)
    for images in (one.start.views.demo, one.start.views.own):
        rows = []
        for side, points in (("left", images[:, :2]), ("right", images[:, 2:])):
            mapped = np.concatenate([points, np.ones((len(points), 1))], 1) @ np.reshape(made[side], (3, 3)).T
            rows.append(mapped[:, 1] / mapped[:, 2])
        assert rows[0] == pytest.approx(rows[1], abs=1e-3)  # px; without noise, 8 digits of H leave some 1e-5
        assert np.abs(images[:, 1] - images[:, 3]).max() > 1  # as they are seen, they do not


def test_the_learner_finds_the_swapped_points():
    one = situation((45, -90), (25, -25), transfer="projective", swapped=0.2)
    pairs = records.true_pairs(one)
    clean = situation((45, -90), (25, -25), transfer="projective")
    order = np.arange(10)
    for i, j in pairs:
        order[[i, j]] = order[[j, i]]
    assert len(pairs) == 1 and np.array_equal(one.start.views.demo, clean.start.views.demo[order])
    assert records.run(one, "likelihood").snapshot.exchanged == pairs


def test_a_hand_that_copies_the_circle_draws_it():
    made = follow_circle(situation((45, -90), (30, -70)))
    assert made.right.radius_m == pytest.approx(0.08, rel=1e-3)  # the circle of `hand_circle`
    assert made.right.draws == "the circle" and made.right.loop_m == pytest.approx([0.16, 0.16], rel=0.02)
    hand = made.early.side[:, -1] - made.early.demo_side[:, -1]
    # Both joints turn the arm in one plane, so that the hands' distance in space is the one from the side.
    assert np.linalg.norm(hand, axis=1) == pytest.approx(made.early.run.hand_m, abs=1e-6)


@pytest.mark.slow
def test_ten_runs_of_which_five_are_right():
    made = sign.runs_record()
    assert len(made) == 10 and sum(one["holds"] for one in made) == 5
    for one, signed in zip(made, sign.signed_runs()):
        last = signed.session.snapshot
        off = np.degrees(np.abs(last.theta - last.theta_demo))
        assert one["offDeg"] == pytest.approx(off, rel=1e-3) and one["holds"] == (off.max() <= 1)
        assert (one["certificate"] is None) == (str(last.status) != "converged")
        arrows = np.reshape(one["own"], (-1, 4)) - np.reshape(one["recovered"], (-1, 4))
        assert (arrows**2).sum() / (2 * len(arrows)) == pytest.approx(
            one["E"][-1], rel=0.05, abs=1e-3
        )  # px² of 5 digits
        assert len(one["because"].split()) <= 25


def test_a_claim_is_evidence_and_a_small_E_is_none():
    noisy, hand, lines, five, _, one_picture, _, _, ten, _ = made = sign.runs_record()
    claims = [one for one in made if one["claim"]["status"] == "converged"]
    assert len(claims) == 3 and all(one["holds"] and one["certificate"] > 0.9 for one in claims)
    assert sum(one["holds"] and one not in claims for one in made) == 2  # no claim, though right
    assert max(hand["E"][-1], five["E"][-1]) < 1e-5 < 1 < noisy["E"][-1]  # wrong, wrong, right
    assert five["E"][-1] < ten["E"][-1] and lines["E"][-1] < made[6]["E"][-1]  # as `because` says
    assert one_picture["claim"]["expectedOffDeg"] > 1 > noisy["claim"]["expectedOffDeg"]


def test_the_learner_s_certificate_bets_better_than_half_always():
    (step,) = (one for one in shipped()["sign"].step if one.id == "sign")
    made = step_data(shipped()["sign"], step)[1]["records"]["runs"]  # as they are in the package
    holds = [one["holds"] for one in made]
    bets = [0.5 if one["certificate"] is None else one["certificate"] for one in made]
    assert oracles.brier([0.5] * 10, holds) == 0.25
    assert oracles.brier(bets, holds) < 0.25
    assert oracles.brier(holds, holds) == 0.0
