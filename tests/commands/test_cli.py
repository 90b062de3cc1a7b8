"""The command line: one JSON object, exit statuses, and every bad input named without a traceback."""

import csv
import importlib.util
import json
import os
import re
import socket
import subprocess
import sys
import urllib.request

import msgspec
import numpy as np
import pytest
from viewimit.assets import ROOT

import viewimit
from viewimit.analysis.landscape import landscape_over
from viewimit.analysis.results import outcome
from viewimit.commands import json_output
from viewimit.commands.json_output import rounded
from viewimit.estimation.transfers import TRANSFERS
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World

HEADING = ("version", "format", "command", "options")  # of every object
PANDA = (ROOT / "robots/panda/panda.urdf").read_text()


def test_imitate_tells_the_run_of_the_session(ask_json):
    status, told = ask_json(
        "imitate", "--demonstrator", "40,-80", "--start", "60,-130", "--transfer", "linear", "--servo", "broyden"
    )
    session = Session(Settings.paper(demonstrator_deg=(40, -80), start_deg=(60, -130), transfer="linear"))
    last = session.run().last
    assert status == 1 and told["converged"] is False and told["status"] == "settled"
    assert told["demonstrator_deg"] == pytest.approx([40, -80])
    assert told["final_deg"] == np.degrees(last.theta).round(6).tolist()
    assert told["error_deg"] == pytest.approx(np.abs(np.degrees(last.theta) - (40, -80)).max())
    assert told["E"] == rounded(last.E) and told["motions"] == last.motion == len(told["history"]) - 1
    moved = np.abs(np.diff(np.degrees([moment.theta for moment in session.history]), axis=0))
    assert told["travel_deg"] == pytest.approx(moved.max(1).sum())
    assert [joint["travel_deg"] for joint in told["joints"]] == pytest.approx(moved.sum(0).tolist())
    for told_moment, moment in zip(told["history"], session.history):
        assert told_moment["theta_deg"] == np.degrees(moment.theta).round(6).tolist()
        assert (told_moment["E"], told_moment["probe"]) == (rounded(moment.E), moment.probe)


HAND = """extends = "panda"
[points]
6 = [[7, 0.062, 0.08, 0.162], [7, -0.05, -0.031, 0.173], [7, -0.039, 0.021, 0.09], [7, -0.073, -0.054, 0.173],
  [7, 0.045, 0.051, 0.173], [7, 0.0, 0.016, 0.172]]
"""  # which keeps its shape in every pose


def test_joints_that_nothing_tells_are_named_and_nothing_is_claimed(ask_json, ask):
    status, told = ask_json("imitate", "--start", "25,-45")
    assert status == 0 and [joint["name"] for joint in told["joints"]] == ["theta2", "theta4"]
    assert all(joint["observable"] for joint in told["joints"])
    assert [joint["deg"] for joint in told["joints"]] == told["final_deg"]
    assert told["std_error_deg"] > max(joint["std_error_deg"] for joint in told["joints"])
    few = "imitate", "--scene", HAND, "--n-points", 6, "--start", "25,-45"
    status, told = ask_json(*few)
    assert status == 1 and told["status"] == "unobservable" and not told["converged"]
    for joint in told["joints"]:
        assert joint["observable"] is False and joint["std_error_deg"] is None
    assert "unobservable  theta2, theta4" in ask(*few)[1]


@pytest.mark.parametrize(
    "words",
    [
        "imitate --noise-px 0.5 --missing 0.05 --seed 3 --start 60.123456789012345,-130 --max-motions 6",
        "imitate --joints 1,2,4,6,7 --n-points 16 --demonstrator 10,44.997659963130204,-90,10,20 --max-motions 10",
    ],
)
def test_a_run_can_be_repeated_from_its_object(ask_json, words):
    _, told = ask_json(*words.split())
    assert (told["version"], told["format"], told["command"]) == (viewimit.__version__, 2, "imitate")
    settings = msgspec.convert(told["settings"], Settings)
    assert set(told["settings"]) == set(Settings.__struct_fields__)
    session = Session(settings)
    ended = session.run(told["options"]["max_motions"])
    again = json.loads(json.dumps(json_output.plain(outcome(session, ended))))
    assert again == without(told, *HEADING, "settings") and len(again["history"]) > 5


def test_no_motion_of_a_run_is_longer_than_it_may_be_nor_leads_out_of_the_workspace(ask_json):
    bound = "--start 25,-45 --max-step-deg 5 --workspace-deg 10:60,-95:-30"
    _, told = ask_json("imitate", "--demonstrator", "45,-90", *bound.split())
    theta_deg = np.array([moment["theta_deg"] for moment in told["history"]])
    assert told["converged"] and told["error_deg"] < 0.01
    assert np.abs(np.diff(theta_deg, axis=0)).max() < 5 + 1e-5  # as far as JSON has it
    assert (theta_deg >= (10, -95)).all() and (theta_deg <= (60, -30)).all()


@pytest.mark.parametrize("name", ["a.csv", "b.npz", "C.NPZ"])
def test_imitate_writes_its_history(ask_json, tmp_path, name):
    path = tmp_path / name
    _, told = ask_json("imitate", "--joints", "2,4,6", "--n-points", 16, "--out", path)
    if path.suffix == ".csv":
        with path.open(newline="") as file:
            rows = list(csv.DictReader(file))
        table = {column: [row[column] for row in rows] for column in rows[0]}
    else:
        with np.load(path) as data:
            table = dict(data)
    number = lambda column: np.array(table[column], float)
    theta, demonstrator, moved = (
        np.stack([number(f"{what}{joint}_deg") for joint in (2, 4, 6)], -1)
        for what in ("theta", "demonstrator", "moved")
    )
    np.testing.assert_allclose(theta, [moment["theta_deg"] for moment in told["history"]], atol=1e-6)
    np.testing.assert_allclose(demonstrator, [told["demonstrator_deg"]] * len(theta), atol=1e-6)
    np.testing.assert_allclose(np.diff(theta, axis=0), moved[1:], atol=1e-9)
    np.testing.assert_allclose(number("E_px2"), [moment["E"] for moment in told["history"]], rtol=1e-5)
    assert list(number("motion")) == list(range(told["motions"] + 1)) and set(number("usable")) == {16}
    assert [str(probe) for probe in table["probe"]] == [str(moment["probe"]) for moment in told["history"]]
    assert table["status"][0] == "ready" and table["status"][-1] == told["status"] == "converged"


def without(told, *names):
    return {name: value for name, value in told.items() if name not in names}


def test_a_run_that_does_not_converge_says_so_and_exits_with_1(ask):
    status, out, err = ask("imitate", "--servo", "gradient", "--max-motions", 5, "--json")
    told = json.loads(out)
    assert status == 1 and told["motions"] == 5 and told["converged"] is False
    assert "Stopped" in err and "after 5 steps" in err


def test_too_few_points_exit_with_1_and_null(ask):
    status, out, err = ask("imitate", "--missing", 1, "--json")
    told = json.loads(out)
    assert status == 1 and told["E"] is None and told["motions"] == 0
    assert "Too few points" in err
    status, out, err = ask("landscape", "--missing", 1, "--json")
    assert status == 1 and json.loads(out)["minimum_deg"] == [None, None] and "too few points" in err


@pytest.mark.parametrize("transfer, expected", [("epipolar", (1.585, 1.587, 803)), ("linear", (1.58, 1.58, 456))])
def test_landscape_prints_the_table_of_the_scene(ask_json, transfer, expected):
    status, told = ask_json("landscape", "--demonstrator", "45,-90", "--transfer", transfer)
    assert status == 0
    assert told["minimum_deg"] == pytest.approx([46, -90]) and told["local_minima"] == [told["minimum_deg"]]
    assert told["basin_fraction"] == 1
    digits = 3 if transfer == "epipolar" else 2
    assert (round(told["E_min"], digits), round(told["E_at_demonstrator"], digits), round(told["E_max"])) == expected


@pytest.fixture(scope="module")
def coarse():
    world = World(load_scene("iiwa"))
    axes = np.radians(np.linspace(0, 90, 10)), np.radians(np.linspace(-120, 0, 13))
    demo, seen = world.demo_images(np.radians((45, -90)))
    return landscape_over(world, TRANSFERS["linear"], demo, seen, axes)


def test_landscape_writes_its_data(ask, tmp_path, coarse):
    command = ("landscape", "--robot", "iiwa", "--transfer", "linear", "--step-deg", 10, "--out")
    assert ask(*command, tmp_path / "a.npz")[0] == 0
    with np.load(tmp_path / "a.npz") as data:
        np.testing.assert_allclose(data["E"], coarse.E)
        np.testing.assert_allclose(data["theta2_deg"], np.linspace(0, 90, 10))
        np.testing.assert_allclose(data["theta4_deg"], np.linspace(-120, 0, 13))
    assert ask(*command, tmp_path / "a.csv")[0] == 0
    with (tmp_path / "a.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["theta2_deg", "theta4_deg", "E_px2"]
    np.testing.assert_allclose([float(row["E_px2"]) for row in rows], coarse.E.ravel())
    assert (float(rows[14]["theta2_deg"]), float(rows[14]["theta4_deg"])) == (10, -110)


def test_a_png_without_a_renderer_says_what_to_install(ask, tmp_path, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    status, _, err = ask("landscape", "--out", tmp_path / "a.png")
    assert status == 2 and "--out" in err and "pip install 'viewimit[plot]'" in err
    assert ask("landscape", "--step-deg", 10, "--out", tmp_path / "a.svg")[0] == 0


@pytest.fixture
def files(tmp_path, monkeypatch):
    """A directory with files that are wrong, each in its own way, as the current one."""
    (tmp_path / "broken.urdf").write_text("<robot><joint")
    (tmp_path / "six.urdf").write_text(
        PANDA.replace('<joint name="panda_joint6" type="revolute"', '<joint name="panda_joint6" type="fixed"')
    )
    (tmp_path / "stiff.urdf").write_text(PANDA.replace('lower="-1.8326" upper="1.8326"', 'lower="0" upper="1"'))
    (tmp_path / "panda.toml").write_text((ROOT / "scenes/panda.toml").read_text())
    (tmp_path / "broken.toml").write_text("title = \n")
    (tmp_path / "lost.toml").write_text('extends = "panda"\nrobot = "lost.urdf"\n')
    (tmp_path / "wrong.json").write_text('{"name": 3}')
    monkeypatch.chdir(tmp_path)
    return tmp_path


BAD_INPUT = [
    ("imitate --robot r2d2", "--robot: no robot 'r2d2'; there are iiwa, panda"),
    ("imitate --robot lost.urdf", "--robot: lost.urdf: cannot be read: No such file"),
    ("imitate --robot broken.urdf", "--robot: broken.urdf: not a URDF that parses: .*line 1"),
    ("imitate --scene panda --robot six.urdf", "--robot: .*panda.toml: posture_deg has 7 .*, but six has 6 joints"),
    ("imitate --scene panda --robot stiff.urdf", "--robot: .*joint 2: range_deg 0 … 90 is more than stiff turns"),
    ("imitate --scene moon", "--scene: no scene 'moon'; there are .*panda"),
    ("imitate --robot six.urdf --tip=", "--robot: six.urdf: #tip is not read: say six.urdf#base=LINK&tip=LINK"),
    ("imitate --scene broken.toml", "--scene: broken.toml: .*line 1"),
    (
        "imitate --scene lost.toml",
        "--scene: lost.toml: its robot, lost.urdf, is not there: put it there, or name it by --robot",
    ),
    ("imitate --n-points 11", "--n-points: no layout of 11 points in this scene; it has .*10, 16, 20"),
    ("imitate --joints 2,9", "--joints: .*joints 2, 9 must ascend, within 1 … 7"),
    ("imitate --demonstrator 45,20", "--demonstrator: its joint 4 at 20° is outside its limits -180° … 0°"),
    ("imitate --start 45,-20 --workspace-deg 50:90,-30:0", "--start: the start posture is outside the workspace"),
    ("imitate --workspace-deg 0:90", "--workspace-deg: workspace_deg needs a range for each of the 2 moving joints"),
    ("imitate --workspace-deg -10:90,-90:0", "range 1, -10° … 90°, is not inside its joint's limits 0° … 90°"),
    ("imitate --max-step-deg 0", "--max-step-deg: max_step_deg must be between 0.01 and 360"),
    ("imitate --start 1,-2,3", "--start: its posture needs 2 angles, of joints 2, 4, got 3"),
    ("imitate --transfer magic", "--transfer: no transfer 'magic'; there are epipolar, linear"),
    ("imitate --transfer own", "--transfer: no transfer 'own': only a session in Python is given one"),
    ("imitate --seed -1", "--seed: seed must be between 0 and 4294967295, got -1"),
    ("landscape --joints 1,2,3", "--scene, --joints: a landscape needs two moving joints, this scene has 3"),
    ("landscape --out a.gif", "--out: a.gif: unknown extension '.gif'; there are .npz, .csv, .svg, .png, .pdf"),
    ("imitate --out a.xlsx", "--out: a.xlsx: unknown extension '.xlsx'; there are .csv, .npz"),
    ("imitate --out nowhere/a.npz", "--out: .*nowhere/a.npz: No such file or directory"),
    ("reproduce fig3", "figures: no figure 'fig3'; there are fig7, fig9, fig10 and all"),
    ("reproduce fig10 --motion dance", "--motion: no motion 'dance'; there are sinusoid, circle, or the path"),
    ("reproduce fig10 --motion wrong.json", "--motion: wrong.json: not a recorded motion: .*name"),
    ("reproduce fig10 --out broken.toml", "--out: .*broken.toml: File exists"),
    ("--scene moon", "viewimit serve: --scene: no scene 'moon'"),
]


def test_bad_input_is_named_and_exits_with_2(ask, files):
    for words, message in BAD_INPUT:
        status, out, err = ask(*words.split())
        assert status == 2 and out == "" and "Traceback" not in err, words
        assert re.search(message, err), (words, err)


def test_a_port_in_use_names_the_next_free_one(ask):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        status, out, err = ask("serve", "--port", port)
    assert status == 2 and out == ""
    assert f"port {port}" in err and "in use" in err and re.search(r"--port \d+", err)


def test_a_robot_is_a_scene_of_its_name_or_a_urdf_beside_the_scene(ask_json, files):
    (files / "own.urdf").write_text(PANDA)

    def told(*words):
        status, all_told = ask_json("imitate", *words)
        return status, without(all_told, "settings")

    shipped, own = told(), told("--scene", "panda", "--robot", "own.urdf")
    assert shipped == own
    (files / "elsewhere").mkdir()
    (files / "own.urdf").rename(files / "elsewhere/beside.urdf")
    (files / "elsewhere/panda.toml").write_text((files / "panda.toml").read_text())
    (files / "elsewhere/own.toml").write_text('extends = "panda"\nrobot = "beside.urdf"\n')
    assert told("--scene", "elsewhere/own.toml") == shipped
    _, iiwa = ask_json("landscape", "--robot", "iiwa", "--step-deg", 10)
    assert iiwa["grid"] == [10, 13]


def test_a_console_that_lacks_characters_is_told_all_the_same(tmp_path):
    code = (
        "import sys\n"
        "from viewimit.commands.cli import COMMANDS, main\n"
        "helps = [['--help'], *([name, '--help'] for name in COMMANDS)]\n"
        "runs = ['imitate', 'bench success --runs 1 --max-motions 0 --servo broyden', 'reproduce fig10',\n"
        "        'reproduce fig10 --json']\n"
        "for words in [*helps, *(run.split() for run in runs)]:\n"
        "    try:\n"
        "        status = main(words)\n"
        "    except SystemExit as exit:\n"
        "        status = exit.code\n"
        "    assert status == 0, words\n"
    )
    there = os.environ | {"PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, cwd=tmp_path, env=there, timeout=120)
    assert done.returncode == 0, done.stderr.decode()
    said = done.stdout.decode()
    assert " ?0.5" in said and "45?, -90?" in said
    figures = json.loads(said.splitlines()[-1])["figures"]
    assert "?" not in json.dumps(figures) and "°" in json.dumps(figures, ensure_ascii=False)


def test_the_module_is_the_command(tmp_path):
    said = in_a_new_process("-m", "viewimit", "--version")
    assert (said.returncode, said.stdout) == (0, f"viewimit {viewimit.__version__}\n")
    assert in_a_new_process("-m", "viewimit", "imitate", "--n-points", "11").returncode == 2


def in_a_new_process(*words):
    return subprocess.run([sys.executable, "-I", *words], capture_output=True, text=True, timeout=60)


def test_the_page_is_served_at_the_printed_address(server):
    with urllib.request.urlopen(server, timeout=10) as answer:
        assert answer.status == 200 and b"<html" in answer.read().lower()


@pytest.mark.parametrize(
    "words",
    [
        *("imitate --undistort 0.1", "imitate --joints 2:3", "nonsense", "bench calibration --nonsense 3", "rehearse"),
        *("imitate --seed 1 --seed 2", "--port 1 --port=2", "detect --demo-left a --demo-left b --out c.csv"),
        *("evaluate a.csv --lens a --lens a", "scene a.urdf --tip a --tip b", "bench success --runs 1 --runs 1"),
        *("lab --out a.html --out b.html", "class --port 1 --port 1", "markers --out a.pdf --out b.pdf"),
    ],
)
def test_an_option_that_cannot_be_is_one_line(ask, words):
    status, out, err = ask(*words.split())
    assert status == 2 and out == "" and err.count("\n") == 1 and "--help" in err
