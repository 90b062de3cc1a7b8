"""`viewimit scene` writes what `--robot` takes; `bench robots` says which robots arrive."""

import pytest
from urdfs import arm, gripper, joint, write

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


def test_bench_robots_reports_on_each_file(ask, ask_json, tmp_path):
    write(tmp_path, *arm(), name="a/good.urdf")
    write(tmp_path, joint("a", "base", "one"), name="b/one.urdf")
    status, out, _ = ask("bench", "robots", tmp_path, "--runs", 1)
    assert status == 0 and "good.urdf" in out and "two are needed" in out.splitlines()[-1]
    told = ask_json("bench", "robots", tmp_path, "--runs", 2)[1]["robots"]
    (row,) = told["rows"]
    assert row["within"]["0.5"]["count"] == row["claimed"]["count"] == 2 and len(told["refused"]) == 1
