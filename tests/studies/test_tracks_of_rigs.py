"""Tracks of stereo rigs: what is drawn is what a rig sees, and `evaluate` leaves images as predictions are best."""

import numpy as np
import pytest
from tracks import CASES, HEIGHT, NOISE_PX, WIDTH, Case, draw, main, run

from viewimit.estimation.views import extents
from viewimit.geometry.fundamental import fit_fundamental, sampson_distance


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_points_held_out_are_seen_by_the_same_rig(case):
    """All in the pictures, and, toed in, where one fundamental matrix has those of all frames exactly."""
    seen, elsewhere = draw(case, np.random.default_rng(0))
    assert seen.demo.shape[1] == case.points and seen.complete and elsewhere.complete
    exact = np.concatenate([elsewhere.demo, elsewhere.own]).reshape(-1, 4)
    assert (exact > -2).all() and (exact < np.array([WIDTH, HEIGHT, WIDTH, HEIGHT]) + 2).all()
    if case.toe_in_deg:
        F = fit_fundamental(exact[:, :2], exact[:, 2:])
        assert np.abs(sampson_distance(F, exact[:, :2], exact[:, 2:])).max() < 1e-6
        noisy = np.concatenate([seen.demo, seen.own]).reshape(-1, 4)
        away = sampson_distance(F, noisy[:, :2], noisy[:, 2:])
        assert NOISE_PX[0] / 2 < np.sqrt(np.mean(away**2)) < 2 * NOISE_PX[1]
    if case.board:
        flat = extents(elsewhere.demo)
        assert (flat[:, 1] > 10 * flat[:, 2]).all()


def test_evaluate_leaves_images_so_that_points_held_out_are_predicted_best():
    rectified, toed = run(10, 2, [Case(40), Case(40, 5.0)])
    assert rectified.rectified.count == 0 and toed.rectified.count == 10
    assert rectified.error_px == rectified.raw_px
    assert toed.error_px["projective"] < toed.raw_px["projective"] / 4
    assert rectified.error_px["projective"] < rectified.always_px["projective"]


def test_the_command_prints_shares_and_errors(capsys):
    main(["--runs", "2", "--case", "rectified, 12"])
    out = capsys.readouterr().out
    assert out.startswith("2 random tracks of a stereo rig a case, seed 0\n")
    assert "rectified, 12 points: rectified 0 % (0–66), matches alone would" in out and "  projective" in out
