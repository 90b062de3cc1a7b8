"""What the commands offer for heads that are not two equal, parallel cameras."""

import json

import numpy as np
import pytest

from viewimit.commands.cli import main
from viewimit.estimation.views import VIEWS
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World

BENT = """extends = "panda-toed"
[head.left]
focal = [228, 234]
distortion = [-0.08, 0.01]
[head.right]
focal = [228, 234]
centre = [320, 120]
distortion = [-0.08, 0.01]
"""
LENS = "228,234,320,120"


@pytest.fixture
def bent(tmp_path):
    path = tmp_path / "bent.toml"
    path.write_text(BENT)
    return path


def told(capsys, *words):
    status = main([*words, "--json"])
    return status, json.loads(capsys.readouterr().out)


def tracked(path, scene):
    """Both arms in the demonstrator's posture, as a person would have tracked them."""
    world = World(load_scene(scene), 16)
    lines = ["frame,view,point,x,y,confidence"]
    for frame, theta in enumerate(np.radians([[45.0, -90.0], [20.0, -60.0], [70.0, -120.0]])):
        views = world.look(theta, theta)
        images = np.concatenate([views.demo, views.own], 1).reshape(-1, 4, 2)
        for view, points in zip(VIEWS, images.swapaxes(0, 1)):
            lines += [f"{frame},{view},p{k},{x},{y},1" for k, (x, y) in enumerate(points.tolist())]
    path.write_text("\n".join(lines) + "\n")
    return str(path)


def test_imitate_rectifies_unless_it_is_told_not_to(capsys):
    asked = "imitate", "--scene", "panda-toed", "--start", "25,-45", "--max-motions", "40"
    status, found = told(capsys, *asked)
    assert status == 0 and found["error_deg"] < 0.1 and found["settings"]["rectify"] == "auto"
    status, found = told(capsys, *asked, "--rectify", "off")
    assert status == 1 and found["error_deg"] > 3


def test_evaluate_rectifies_a_persons_own_points_by_all_their_frames(tmp_path, capsys):
    points = tracked(tmp_path / "points.csv", "panda-toed")
    _, found = told(capsys, "evaluate", points, "--transfer", "projective")
    _, raw = told(capsys, "evaluate", points, "--transfer", "projective", "--rectify", "off")
    assert max(frame["E"] for frame in found["frames"]) < 1e-4 < 0.02 < max(frame["E"] for frame in raw["frames"])
    assert np.shape(found["rectification"]["left"]) == (3, 3) and raw["rectification"] is None
    parallel = tracked(tmp_path / "parallel.csv", "panda")
    assert told(capsys, "evaluate", parallel)[1]["rectification"] is None


def test_evaluate_takes_the_lenses_distortion_out_first(bent, tmp_path, capsys):
    points = tracked(tmp_path / "points.csv", bent)
    asked = "evaluate", points, "--transfer", "projective"
    _, raw = told(capsys, *asked)
    _, found = told(capsys, *asked, "--undistort", "-0.08,0.01", "--lens", LENS)
    assert max(frame["E"] for frame in found["frames"]) < 1e-4 < max(frame["E"] for frame in raw["frames"])


@pytest.mark.parametrize(
    "words, message",
    [
        ("--undistort -0.08,0.01", "--undistort and --lens go together"),
        ("--lens 228,234,320,120", "--undistort and --lens go together"),
        ("--undistort -0.9,0 --lens 60,60,320,120", "folds its image; a point of the left camera is 1.88 from"),
        ("--undistort 1e308,0 --lens 228,234,320,120", "a distortion of k1 1e+308, k2 0 is none of a lens: both are"),
        ("--undistort 0,-11 --lens 228,234,320,120", "within ±10, in focal lengths, not in pixels"),
        ("--undistort inf,0 --lens 228,234,320,120", "such as -0.05,0.01, got 'inf,0'"),
        ("--undistort 3", "such as -0.05,0.01, got '3'"),
        ("--undistort 0.1,0 --lens 0,1,2,3", "focal lengths must be more than 0, got '0,1,2,3'"),
        ("--lens 500,500,320,240,-0.1,0 --lens 228,234,320,120,-0.1,0", "--lens"),
        ("--lens-left 228,234,320,120,-0.1,0", "--lens-right"),
        ("--lens 228,234,320,120,-0.1,0 --undistort -0.1,0", "both give a distortion"),
        ("--lens nowhere.yaml", "nowhere.yaml"),
        ("--rectify always", "invalid choice: 'always'"),
    ],
)
def test_a_wrong_option_is_named(words, message, tmp_path, capsys):
    points = tracked(tmp_path / "points.csv", "panda")
    try:
        status = main(["evaluate", points, *words.split()])
    except SystemExit as end:
        status = end.code
    assert status == 2 and message in capsys.readouterr().err
