"""`viewimit scene` writes what `--robot` takes; `bench robots` says which robots arrive."""

import json
import re

import pytest
from urdfs import arm, gripper, joint, link, write

from viewimit.simulation.scene import load_scene


@pytest.fixture
def urdf(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return write(tmp_path, *arm(*gripper("lower"))).relative_to(tmp_path)


def run_of(told):
    return {name: value for name, value in told.items() if name not in ("options", "settings")}


def test_the_written_file_is_the_scene_that_is_made(ask, ask_json, urdf, tmp_path):
    status, out, err = ask("scene", urdf, "--out", "elsewhere.TOML")
    assert (status, out) == (0, "") and "written to elsewhere.TOML" in err and "moving 2 (lift)" in err
    assert load_scene("elsewhere.TOML") == load_scene(urdf)
    (tmp_path / "deeper").mkdir()
    ask("scene", urdf, "--tip", "upper", "--out", "deeper/mine.toml")
    scene = load_scene("deeper/mine.toml")
    assert scene.robot == "deeper/../small.urdf#tip=upper" and scene.moving_joints == (1, 2)
    made = ask_json("imitate", "--robot", urdf, "--tip", "upper")
    assert made[0] == 0 and made[1]["settings"]["scene"] == "small.urdf#tip=upper"
    assert run_of(made[1]) == run_of(ask_json("imitate", "--scene", "deeper/mine.toml")[1])
    assert run_of(made[1]) == run_of(ask_json("imitate", "--scene", "small.urdf#tip=upper")[1])


@pytest.mark.parametrize("joints", ["1,3", "1,2,3", "all"])
def test_given_joints_are_those_of_the_file(ask, ask_json, urdf, joints):
    ask("scene", urdf, "--joints", joints, "--out", "mine.toml")
    _, of_file = ask_json("imitate", "--scene", "mine.toml", "--n-points", 16)
    _, made = ask_json("imitate", "--robot", urdf, "--joints", joints, "--n-points", 16)
    assert run_of(of_file) == run_of(made)
    assert len(made["joints"]) == (2 if joints == "1,3" else 3)


@pytest.mark.parametrize("words", ["scene small.urdf", "imitate --max-motions 0 --robot small.urdf"])
@pytest.mark.parametrize("joints, moving", [("1,3", "yaw elbow"), ("2", "lift"), ("all", "yaw lift elbow")])
def test_the_chosen_joints_move(ask, urdf, words, joints, moving):
    _, _, err = ask(*words.split(), "--joints", joints)
    (said,) = re.findall(r"^small.urdf: moving (.*)$", err, re.MULTILINE)
    assert re.findall(r"\((\w+)\)", said) == moving.split()


def test_every_field_is_commented(ask, urdf):
    status, out, _ = ask("scene", urdf)
    assert status == 0 and out.startswith("# Made from a URDF by `viewimit scene`")
    for line in (
        "#   2 lift: -114.59° … 114.59°",
        "# Their ranges in this scene, degrees\nrange_deg = [[-45, 45], [-45, 45]]",
    ):
        assert line in out
    assert re.search(r"^  \[3, .*\],  # moved by elbow$", out, re.MULTILINE) and "]  # base" not in out
    assert all(len(line) <= 130 for line in out.splitlines() if line.startswith("#"))


def test_json_is_one_object_with_the_scene(ask_json, urdf):
    status, told = ask_json("scene", urdf, "--joints", "2,3")
    assert status == 0 and told["scene"]["moving_joints"] == [2, 3] and told["options"]["joints"] == [2, 3]
    json.dumps(told, allow_nan=False)


def test_missing_meshes_are_reported_without_failure(ask, tmp_path):
    lost = '<visual><geometry><mesh filename="package://nowhere/hand.stl"/></geometry></visual>'
    path = write(tmp_path, *arm(joint("roll", "lower", "hand", axis="0 0 1", xyz="0 0 0.3"), link("hand", visual=lost)))
    status, out, err = ask("imitate", "--robot", path)
    assert status == 0 and "converged" in out and "nowhere/hand.stl" in err
    assert err.count("\n") == 3


@pytest.mark.parametrize(
    "words, message",
    [
        ("scene panda", "URDF: panda is no .urdf file"),
        ("scene lost.urdf", "URDF: lost.urdf: cannot be read: No such file"),
        ("scene small.urdf --out a.json", "--out: a.json must end in .toml"),
        ("scene small.urdf --joints 1,9", "--joints: joints 1, 9 must ascend, within 1 … 3"),
        ("scene small.urdf --tip nose", "URDF: small.urdf: no link 'nose'; its links are base,"),
        ("imitate --robot small.urdf --tip nose", "--robot: small.urdf: no link 'nose'"),
        ("imitate --robot small.urdf --tip shoulder", "--robot: small.urdf: from base to shoulder 1 joint can turn"),
        (
            "imitate --robot small.urdf --base upper --tip lower",
            "--robot: small.urdf: from upper to lower 1 joint can turn",
        ),
        ("imitate --robot panda --tip nose", "--robot: .*--tip .* of a .urdf file"),
        ("imitate --tip nose", "--robot: .*--tip .* of a .urdf file"),
        ("imitate --robot small.urdf.xacro", "--robot: small.urdf.xacro is xacro"),
        ("serve --robot small.sdf", "--robot: small.sdf is SDF"),
        ("bench robots", "the following arguments are required: FOLDER"),
        ("bench robots nowhere", "FOLDER: nowhere: no .urdf file there"),
        ("bench success nowhere", "PATH: nowhere: No such file or directory"),
    ],
)
def test_bad_input_is_one_line_and_exits_with_2(ask, urdf, words, message):
    status, out, err = ask(*words.split())
    assert status == 2 and out == "" and err.count("\n") == 1
    assert re.search(message, err), err


def test_bench_robots_reports_on_each_file(ask, ask_json, tmp_path):
    write(tmp_path, *arm(), name="a/good.urdf")
    write(tmp_path, joint("a", "base", "one"), name="b/one.urdf")
    status, out, _ = ask("bench", "robots", tmp_path, "--runs", 2)
    assert status == 0 and "good.urdf" in out and "two are needed" in out.splitlines()[-1]
    told = ask_json("bench", "robots", tmp_path, "--runs", 2)[1]["robots"]
    (row,) = told["rows"]
    assert row["within"]["0.5"]["count"] == row["claimed"]["count"] == 2 and len(told["refused"]) == 1
