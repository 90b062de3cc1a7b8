"""The command reproduce: the paper's claims beside what is found, files, and an exit status that tells a miss."""

import csv
import re
from dataclasses import replace

import numpy as np
import pytest

from viewimit.analysis import trajectory
from viewimit.experiments import EXPERIMENTS
from viewimit.experiments.paper import fig7, fig9, fig10
from viewimit.experiments.paper.common import TOLERANCES, Tolerance
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World


@pytest.fixture(autouse=True)
def coarse(monkeypatch):
    """The experiments, quick."""
    quick = {
        "fig7": lambda settings, tell: fig7.run(settings, tell, step_deg=15.0, study=(1, 1)),
        "fig9": lambda settings, tell: fig9.run(settings, tell, starts=(0, 0), max_motions=12, laws=("broyden",)),
    }
    for name, run in quick.items():
        monkeypatch.setitem(EXPERIMENTS, name, replace(EXPERIMENTS[name], run=run))


@pytest.fixture
def too_strict(monkeypatch):
    """An affine camera leaves the minimum 0.8° off the demonstrator."""
    monkeypatch.setitem(TOLERANCES, "minimum", Tolerance(0.1, "for a test", elsewhere=0.1))


def test_claims_stand_beside_what_is_found(ask):
    status, out, _ = ask("reproduce", "fig7", "fig10")
    heading, *lines = out.splitlines()
    assert status == 0 and heading.split() == ["paper", "here", "tolerance"]
    smallest = r"Fig. 7: smallest E +\(41°, −90°\) +\(45\.[78]°, −89\.7°\) +4° of demonstrator +pass$"
    assert any(re.match(smallest, line) for line in lines)
    assert any(line.startswith("Fig. 10: converged, hand") and line.endswith("pass") for line in lines)
    assert not any(line.startswith("Fig. 9") for line in lines) and lines[-1] == "8 of 8 hold"


def test_files_are_written_and_one_object_printed(ask_json, tmp_path):
    folder = tmp_path / "new" / "folder"
    status, told = ask_json("reproduce", "--out", folder)
    assert status == 0 and told["missed"] == [] and list(told["figures"]) == ["fig7", "fig9", "fig10"]
    for name, figure in told["figures"].items():
        expected = {str(folder / f"{name}.{end}") for end in ("json", "npz", "svg", "png")}
        assert figure["claims"] and expected <= set(figure["files"])
        assert all((tmp_path / path).is_file() for path in figure["files"])


def test_a_miss_is_said_and_exits_with_1(ask, ask_json, too_strict):
    status, out, _ = ask("reproduce", "fig7")
    assert status == 1 and out.endswith("\n3 of 4 hold; the place of smallest E does not\n")
    assert re.search(r"^Fig. 7: smallest E .* MISS$", out, re.MULTILINE)
    status, told = ask_json("reproduce", "fig7")
    assert status == 1 and told["missed"] == ["Fig. 7: smallest E"]
    assert told["figures"]["fig7"]["verdict"] == "3 of 4 hold; the place of smallest E does not"
    (claim,) = (claim for claim in told["figures"]["fig7"]["claims"] if claim["name"] == "Fig. 7: smallest E")
    assert claim["holds"] is False


def test_a_recorded_motion_is_imitated(ask_json, tmp_path):
    path = tmp_path / "wave.json"
    path.write_bytes(
        trajectory.encode_motion(trajectory.sinusoid(World(load_scene("panda")), np.radians([40, -80]), frames=20))
    )
    status, _ = ask_json("reproduce", "fig10", "--motion", path, "--out", tmp_path)
    with (tmp_path / "fig10-frames.csv").open() as file:
        frames = [row for row in csv.DictReader(file) if row["run"] == fig10.CONVERGED]
    assert status == 0 and len(frames) == 20 and float(frames[0]["demonstrator2_deg"]) == pytest.approx(40)
