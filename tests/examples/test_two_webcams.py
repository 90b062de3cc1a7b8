"""The recording of two webcams: its markers are where its truth says, and E falls as the arms agree."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

cv2 = pytest.importorskip("cv2")
FOLDER = Path(__file__).parents[2] / "examples" / "two_webcams"
TRUTH = json.loads((FOLDER / "truth.json").read_text("utf-8"))


@pytest.fixture(scope="module")
def points(tmp_path_factory):
    from viewimit.commands.cli import main

    out = tmp_path_factory.mktemp("points") / "points.csv"
    assert main(["detect", str(FOLDER), "--aruco", TRUTH["dictionary"], "--out", str(out)]) == 0
    return out


def test_the_detector_finds_markers_where_they_were(points):
    with points.open() as table:
        rows = list(csv.DictReader(table))
    away = [
        np.subtract(
            (float(row["x"]), float(row["y"])),
            TRUTH["frames"][int(row["frame"])]["markers_px"][row["view"]][int(row["point"])],
        )
        for row in rows
    ]
    assert len(away) > 12 * 4 * len(TRUTH["frames"])
    assert np.sqrt(np.mean(np.square(away))) < 0.25  # px; a side of a marker is about 25 px
    assert np.abs(away).max() < 2


def test_E_is_least_where_the_arms_agree(points, ask_json):
    status, told = ask_json("evaluate", points, "--transfer", "projective")
    E = np.array([frame["E"] for frame in told["frames"]])
    learner, demonstrator = np.array([frame["learner_deg"] for frame in TRUTH["frames"]]), TRUTH["demonstrator_deg"]
    error = np.abs(learner - demonstrator).max(1)
    assert status == 0 and error[-1] < 0.5 and error[:3].min() > 20
    assert E[error < 1].max() < 0.5 < 5 < E[error > 10].min()
    commanded = np.array([frame["commanded_deg"] for frame in TRUTH["frames"]])
    sag = np.abs(learner - commanded).max(1)
    assert (sag > 0.01).all() and sag.max() < 0.3  # an arm with mass and motors


@pytest.mark.slow
def test_the_recording_is_made_again_by_its_script(tmp_path):
    pytest.importorskip("pybullet")
    from viewimit.assets.build_recording import main

    main(tmp_path)
    again = json.loads((tmp_path / "truth.json").read_text("utf-8"))
    assert again["demonstrator_deg"] == TRUTH["demonstrator_deg"]
    for name in ("commanded_deg", "learner_deg"):
        for here, there in zip(again["frames"], TRUTH["frames"], strict=True):
            np.testing.assert_allclose(here[name], there[name], atol=0.05)  # another OpenCV decodes otherwise
