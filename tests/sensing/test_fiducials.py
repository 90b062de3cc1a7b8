"""Square markers that OpenCV has drawn: found at their places, identified, and left out if ambiguous."""

import numpy as np
import pytest

cv2 = pytest.importorskip("cv2")

from tags import picture_of  # noqa: E402

from viewimit.estimation.views import VIEW_NAMES, VIEWS, view_of  # noqa: E402
from viewimit.sensing.detection import Fiducials, dictionary_names  # noqa: E402

AT = {k: np.array([90.0 + 120 * (k % 8), 90 + 120 * (k // 8)]) + np.sin([k, 2 * k]) for k in range(40)}


@pytest.mark.parametrize("name", ["4x4_50", "DICT_5X5_100", "apriltag_36h11", "ARUCO_ORIGINAL"])
@pytest.mark.parametrize("turn, rms_px", [(0.0, 0.27), (0.05, 0.12), (0.4, 0.12), (2.0, 0.12)])
def test_middles_are_found_to_a_fraction_of_a_pixel_without_bias(name, turn, rms_px):
    """Worst where edges lie along the pixels' own."""
    fiducials = Fiducials(name)
    found = fiducials.detect(picture_of(fiducials.dictionary, AT, turn=turn))
    assert len(found) >= 38
    away = np.array([found[k] - AT[k] for k in found])
    assert np.sqrt((away**2).mean()) < rms_px and np.abs(away.mean(0)).max() < 0.08


def test_an_unknown_dictionary_is_refused_with_a_list_of_names():
    assert {"4X4_50", "APRILTAG_36H11"} <= set(dictionary_names()) and len(set(dictionary_names())) == len(
        dictionary_names()
    )
    with pytest.raises(ValueError, match="no dictionary '4x4'; there are 4X4_100, .*4X4_50"):
        Fiducials("4x4")


def test_evaluate_reads_the_markers_that_detect_writes(ask, ask_json, tmp_path):
    points = np.random.default_rng(1).uniform((-0.4, -0.3, 2.0), (0.4, 0.3, 2.6), (16, 3))
    dictionary, seen = Fiducials("APRILTAG_36h11").dictionary, {}
    for view, (eye, by) in zip(VIEWS, ((-0.05, 0.0), (0.05, 0.0), (-0.05, 0.1), (0.05, 0.1))):
        x, y, z = (points - (eye + by, by / 2, 0)).T
        seen[view] = dict(enumerate(np.stack([1280 + 2400 * x / z, 960 + 2400 * y / z], -1)))
        cv2.imwrite(str(tmp_path / f"{VIEW_NAMES[view]}.png"), picture_of(dictionary, seen[view], shape=(1920, 2560)))
    files = [tmp_path / f"{name}.png" for name in VIEW_NAMES.values()]
    out = tmp_path / "points.csv"
    status, told = ask_json("detect", *files, "--aruco", "APRILTAG_36h11", "--out", out)
    assert status == 0 and told["markers"] <= 16 and told["views"]["own_left"]["points_a_frame"] >= 10
    status, told = ask_json("evaluate", out)
    (frame,) = told["frames"]
    assert status == 0 and len(frame["usable"]) >= 10
    for view in VIEWS:
        found = np.array(frame["seen"][VIEW_NAMES[view]])
        np.testing.assert_allclose(found, [seen[view][int(name)] for name in frame["usable"]], atol=0.3)
    before = files[0].read_bytes()
    status, _, err = ask("detect", *files, "--aruco", "APRILTAG_36h11", "--out", files[0])
    assert status == 2 and "must end in .csv" in err and files[0].read_bytes() == before
    status, _, err = ask("detect", files[0], "--aruco", "9X9", "--out", out)
    assert status == 2 and "--aruco: no dictionary '9X9'; there are" in err and err.count("\n") == 1
    middle = ask_json("detect", *files, "--aruco", "APRILTAG_36h11", "--middle", 0.2, "--out", out)[1]
    assert 0 < middle["views"]["demo_left"]["points_a_frame"] < 16
    rows = [line.split(",") for line in out.read_text().splitlines()[1:]]
    for _, view, number, x, y, _ in rows:
        np.testing.assert_allclose((float(x), float(y)), seen[view_of(view)][int(number)], atol=0.3)


def test_films_of_unlike_rates_are_no_pair(ask, tmp_path):
    files = [tmp_path / f"{name}.avi" for name in VIEW_NAMES.values()]
    for path, rate in zip(files, (30, 25, 30, 30.1)):
        film = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), rate, (400, 300))
        film.write(picture_of(Fiducials("4x4_50").dictionary, {3: (200, 150)}, shape=(300, 400)))
        film.release()
    _, _, err = ask("detect", *files, "--aruco", "4X4_50", "--out", tmp_path / "points.csv")
    assert "demonstrator have 30 frames a second in demo_left and 25 in demo_right" in err and "learner" not in err


def test_a_view_without_markers_is_named_and_hues_are_not_looked_for_unasked(ask, tmp_path):
    dictionary, out = Fiducials("4x4_50").dictionary, tmp_path / "points.csv"
    empty, full = tmp_path / "empty_l.png", tmp_path / "full_r.png"
    cv2.imwrite(str(empty), np.full((200, 300, 3), 90, np.uint8))
    cv2.imwrite(str(full), picture_of(dictionary, {3: (200, 200)}, shape=(400, 600)))
    status, out_text, err = ask("detect", empty, full, "--aruco", "4X4_50", "--out", out)
    assert status == 1 and "demo_right  1 frames, 1.0 of 1 points" in out_text
    sizes = "pictures of different sizes, 300 x 200 px in demo_left, 600 x 400 px in demo_right"
    assert err.splitlines() == [
        f"viewimit detect: {sizes}: points are in pixels of each",
        "viewimit detect: no marker of 4X4_50 in any frame of view demo_left",
    ]
    assert (
        "no marker of panda in any frame of view demo_left, demo_right" in ask("detect", empty, full, "--out", out)[2]
    )
    status, _, err = ask("detect", full, "--aruco", "", "--out", out)
    assert status == 2 and "--aruco: no dictionary ''; there are" in err
    status, _, err = ask("detect", full, "--aruco", "4X4_50", "--markers", "iiwa", "--out", out)
    assert status == 2 and "--markers: not allowed with argument --aruco" in err
