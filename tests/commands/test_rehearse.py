"""rehearse keeps a file, and imitate --calibration begins with it."""

import shlex
from pathlib import Path

import numpy as np
import pytest

IIWA = Path(__file__).parents[2] / "assets/robots/iiwa/iiwa.urdf"


@pytest.fixture
def body(tmp_path, ask):
    path = tmp_path / "body.npz"
    assert ask("rehearse", "--postures", 12, "--out", path)[0] == 0
    return path


def test_imitate_makes_few_motions_of_its_own_and_tells_how_many_were_rehearsed(ask, ask_json, body):
    run = "imitate", "--demonstrator", "45,-90", "--start", "80,-20"
    status, told = ask_json(*run, "--calibration", body)
    assert status == 0 and told["converged"] and told["error_deg"] < 0.5 and told["std_error_deg"] is not None
    assert told["rehearsed"] == 12 and told["rehearsal_holds"] is True
    assert told["motions"] == len(told["history"]) - 1 <= 6 and told["options"]["calibration"] == str(body)
    alone = ask_json(*run)[1]
    assert alone["motions"] > told["motions"] and "rehearsed" not in alone


@pytest.mark.parametrize(
    "words",
    [
        (),
        ("--scene", "iiwa"),
        ("--n-points", 16, "--joints", "2,3,4"),
        ("--undistort", "0.02,0"),
        ("--robot", IIWA, "--joints", "2,4", "--tip", "lbr_iiwa_link_6"),
    ],
)
def test_the_command_that_is_told_begins_with_the_rehearsal(ask, ask_json, tmp_path, words):
    status, out, _ = ask("rehearse", "--postures", 12, "--out", tmp_path / "a body.npz", *words)
    told = next(line for line in out.splitlines() if line.startswith("imitate with  "))
    program, *command = shlex.split(told.removeprefix("imitate with  "))
    assert status == 0 and program == "viewimit"
    assert ask_json(*command, "--max-motions", 1)[1]["rehearsed"] == 12


def test_rehearse_tells_where_it_was_and_repeats_itself(tmp_path, ask_json, body):
    status, told = ask_json("rehearse", "--postures", 12, "--out", tmp_path / "again.npz")
    assert status == 0 and told["rehearsed"] == 12 == len(told["points_seen"])
    postures = np.array(told["postures_deg"])
    assert postures.shape == (12, 2) and (postures >= (0, -180)).all() and (postures <= (90, 0)).all()
    with np.load(body) as one, np.load(tmp_path / "again.npz") as other:
        assert all(np.array_equal(one[name], other[name], equal_nan=name == "own_px") for name in one.files)
    other = ask_json("rehearse", "--postures", 12, "--seed", 8, "--out", tmp_path / "other.npz")[1]
    assert other["postures_deg"] != told["postures_deg"]
    near = ask_json("rehearse", "--within", 10, "--start", "40,-90", "--out", tmp_path / "near.npz")[1]
    assert np.abs(np.array(near["postures_deg"]) - (40, -90)).max() <= 10 + 1e-6


@pytest.mark.parametrize(
    "words, named",
    [
        (("--n-points", 16), "rehearsed with points 10, here it is 16"),
        (("--robot", "iiwa"), "rehearsed with robot panda"),
        (("--servo", "broyden"), "broyden learns from its own steps alone; --servo likelihood"),
    ],
)
def test_a_rehearsal_of_no_use_is_refused(ask, body, words, named):
    status, out, err = ask("imitate", "--calibration", body, *words)
    assert status == 2 and not out and "--calibration" in err and named in err
