"""What an experiment writes: the result's own numbers, in every format, with a manifest that names them all."""

import csv
import json

import numpy as np
import pytest

from viewimit.experiments import files
from viewimit.experiments.paper import fig7, fig9, fig10
from viewimit.settings import Settings

COARSE = {
    "fig7": lambda: fig7.run(Settings(), step_deg=15.0, study=(2, 2)),
    "fig9": lambda: fig9.run(Settings(), starts=(1, 1), max_motions=20),
    "fig10": lambda: fig10.run(Settings(), max_motions=30),
}
TABLES = {
    "fig7": {"surface", "minima", "convexity", "demonstrators"},
    "fig9": {"motions", "arrivals"},
    "fig10": {"frames", "points"},
}
PICTURES = {"fig7": ["fig7", "fig7-convexity", "fig7-demonstrators"], "fig9": ["fig9"], "fig10": ["fig10"]}


@pytest.fixture(scope="module", params=COARSE)
def made(request, tmp_path_factory):
    name, folder = request.param, tmp_path_factory.mktemp(request.param) / "made" / "for it"
    result = COARSE[name]()
    return name, result, folder, files.write(name, result, folder)


def rows(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_every_file_is_there_and_in_the_manifest(made):
    name, _, folder, written = made
    assert {path.name for path in written} == {path.name for path in folder.iterdir()}
    manifest = json.loads((folder / f"{name}.json").read_text("utf-8"))
    assert set(manifest["files"]) == {path.name for path in written} - {f"{name}.json"}
    expected = {f"{name}-{table}.csv" for table in TABLES[name]} | {f"{name}.npz", f"{name}.json"}
    expected |= {picture + suffix for picture in PICTURES[name] for suffix in (".svg", ".png")}
    assert {path.name for path in written} == expected


def test_the_manifest_says_of_what(made):
    name, result, folder, _ = made
    manifest = json.loads((folder / f"{name}.json").read_text("utf-8"))
    assert manifest["settings"]["demonstrator_deg"] == [45, -90] and manifest["settings"]["transfer"] == "epipolar"
    assert manifest["seed"] == result.settings.seed
    assert {"python", "viewimit", "numpy"} <= set(manifest["versions"])
    assert [claim["name"] for claim in manifest["claims"]] == [claim.name for claim in result.claims] != []


def test_csv_and_npz_hold_the_same_numbers(made):
    name, result, folder, _ = made
    arrays = np.load(folder / f"{name}.npz")
    for table, columns in result.tables.items():
        found = rows(folder / f"{name}-{table}.csv")
        assert list(found[0]) == list(columns)
        for key, column in columns.items():
            np.testing.assert_array_equal(arrays[f"{table}.{key}"], column)
            assert len(found) == len(column)
            if column.dtype.kind == "f":
                values = [float(row[key] or "nan") for row in found]
                np.testing.assert_allclose(values, column, rtol=1e-9, atol=1e-12)
            else:
                assert [row[key] for row in found] == [
                    str(int(v)) if column.dtype.kind == "b" else str(v) for v in column
                ]


def test_tables_are_the_results_own_numbers(made):
    name, result, *_ = made
    tables = result.tables
    if name == "fig7":
        E = tables["surface"]["E_linear_px2"].reshape(7, 13)
        np.testing.assert_array_equal(E, result.surfaces["linear"].landscape.E)
        at_truth = (tables["surface"]["theta2_deg"] == 45) & (np.abs(tables["surface"]["theta4_deg"] + 90) < 1e-9)
        assert tables["surface"]["E_epipolar_px2"][at_truth] == pytest.approx(1.587, abs=5e-4)
        assert (tables["demonstrators"]["transfer"] == "epipolar").sum() == 4
    if name == "fig9":
        of_third = tables["motions"]["run"] == 2
        np.testing.assert_array_equal(tables["motions"]["E_px2"][of_third], result.runs[2].E)
        assert (tables["arrivals"]["law"] == [run.law for run in result.runs]).all()
    if name == "fig10":
        run = result.runs[fig10.BEFORE]
        chosen = (tables["points"]["run"] == fig10.BEFORE) & (tables["points"]["view"] == "R")
        of_point = chosen & (tables["points"]["point"] == 8)
        np.testing.assert_array_equal(tables["points"]["own_x_px"][of_point], run.own[:, 8, 2])
        np.testing.assert_array_equal(tables["points"]["desired_y_px"][of_point], run.desired[:, 8, 3])


def test_pictures_are_pictures_and_repeat_themselves(made, tmp_path):
    name, result, folder, _ = made
    for picture in PICTURES[name]:
        assert (folder / f"{picture}.png").read_bytes().startswith(b"\x89PNG")
        svg = (folder / f"{picture}.svg").read_text("utf-8")
        assert "<svg" in svg
    again = files.write(name, result, tmp_path)
    for path in again:
        assert path.read_bytes() == (folder / path.name).read_bytes() or path.suffix == ".npz", path.name


def test_without_matplotlib_the_data_are_written_all_the_same(tmp_path, monkeypatch):
    monkeypatch.setattr(files, "can_draw", lambda: False)
    written = files.write("fig9", COARSE["fig9"](), tmp_path)
    assert {path.suffix for path in written} == {".npz", ".csv", ".json"}


OTHERS = {
    "noise": Settings(scene="iiwa", demonstrator_deg=(80, -110), transfer="linear", noise_px=0.5),
    "missing": Settings(demonstrator_deg=(90, 0), missing=0.2, points=16),
}


@pytest.mark.parametrize("settings", OTHERS.values(), ids=OTHERS)
def test_other_settings_are_drawn_and_judged_by_nothing(tmp_path, settings):
    result = fig7.run(settings, step_deg=30.0, study=(1, 1))
    assert len(files.write("fig7", result, tmp_path)) > 5
    assert all(claim.holds is None for claim in result.claims)
