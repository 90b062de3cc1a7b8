"""What an experiment writes: the result's own numbers, in every format, with a manifest that names them all."""

import csv
import json
import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from drawn import CELL_NUMBERS, LAYOUT_ONLY, SMALLEST_E, classes, only, styled
from PIL import Image

from viewimit.analysis.landscape import Landscape
from viewimit.drawing import svg
from viewimit.drawing.export import figures
from viewimit.drawing.plots import describe_settings
from viewimit.drawing.theme import ROLES
from viewimit.experiments import EXPERIMENTS, ON_PICTURES
from viewimit.experiments.experiment import write
from viewimit.experiments.paper import fig7, fig8, fig9, fig10
from viewimit.experiments.paper.common import verdict
from viewimit.loop.settings import Settings

COARSE = {
    "fig7": lambda: fig7.run(Settings.paper(), step_deg=15.0, study=(2, 2)),
    "fig9": lambda: fig9.run(Settings.paper(), starts=(1, 1), max_motions=20),
    "fig10": lambda: fig10.run(Settings.paper(), max_motions=30),
}
TABLES = {
    "fig7": {"surface", "minima", "convexity", "demonstrators"},
    "fig9": {"motions", "arrivals"},
    "fig10": {"frames", "points"},
}
SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module", params=COARSE)
def made(request, tmp_path_factory):
    name, folder = request.param, tmp_path_factory.mktemp(request.param) / "made" / "for it"
    result = COARSE[name]()
    return name, result, folder, write(name, EXPERIMENTS[name], result, folder)


def rows(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_every_file_is_there_and_in_the_manifest_which_says_of_what(made):
    name, result, folder, written = made
    assert {path.name for path in written} == {path.name for path in folder.iterdir()}
    manifest = json.loads((folder / f"{name}.json").read_text("utf-8"))
    assert set(manifest["files"]) == {path.name for path in written} - {f"{name}.json"}
    expected = {f"{name}-{table}.csv" for table in TABLES[name]} | {f"{name}.npz", f"{name}.json"}
    expected |= {f"{name}{suffix}" for suffix in (".svg", *filter(figures.can_render, figures.WRITERS))}
    assert {path.name for path in written} == expected
    assert manifest["settings"]["demonstrator_deg"] == [45, -90] and manifest["settings"]["transfer"] == "epipolar"
    assert manifest["seed"] == result.settings.seed
    assert {"python", "viewimit", "numpy"} <= set(manifest["versions"])
    assert manifest["verdict"] == verdict(result.claims)
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


def test_pictures_are_pictures_and_repeat_themselves(made, tmp_path):
    name, result, folder, _ = made
    image = Image.open(folder / f"{name}.png")
    shown = np.asarray(image.convert("RGB"))
    assert image.format == "PNG" and image.width > 1200 and (shown[0] == 255).all()  # a white margin
    assert len(np.unique(shown.reshape(-1, 3), axis=0)) > 50
    again = write(name, EXPERIMENTS[name], result, tmp_path)
    for path in again:
        assert path.read_bytes() == (folder / path.name).read_bytes() or path.suffix == ".npz", path.name


def test_an_svg_needs_nothing_beside_it(made):
    name, result, folder, _ = made
    text = (folder / f"{name}.svg").read_text("utf-8")
    root = ElementTree.fromstring(text)
    assert root.tag == f"{SVG}svg" and root.find(f"{SVG}title").text.startswith(f"Fig. {name[3:]}: ")
    assert root.find(f"{SVG}desc").text == describe_settings(result.settings)
    without_namespace = text.replace('xmlns="http://www.w3.org/2000/svg"', "")
    assert not re.search(r"<script|var\(|@import|http|url\((?!#)|href=\"(?!data:)", without_namespace)
    known = styled(root.find(f"{SVG}style").text)
    used = set().union(*map(classes, root.iter()))
    assert used - known <= LAYOUT_ONLY and known <= used
    colours = {light for light, _ in ROLES.values()}
    assert set(re.findall(r"#[0-9a-f]{6}", text)) <= colours
    names = set(re.findall(r' id="([^"]+)"', text))
    assert set(re.findall(r"url\(#([^)]+)\)", text)) <= names


def test_without_a_renderer_all_but_png_is_written(tmp_path, monkeypatch):
    monkeypatch.setattr("viewimit.drawing.export.figures.can_render", lambda suffix=".png": False)
    written = write("fig9", EXPERIMENTS["fig9"], COARSE["fig9"](), tmp_path)
    assert {path.suffix for path in written} == {".npz", ".csv", ".json", ".svg"}


def test_fig8_is_drawn_from_its_surfaces(tmp_path):
    rng = np.random.default_rng(1)
    axes = np.radians(np.arange(25.0, 80, 10)), np.radians(np.arange(-135.0, -20, 10))
    E = rng.uniform(1, 200, (6, 12))
    surfaces = {name: fig8.Surface(Landscape(axes, E * (k + 1)), 2.0, axes[0][:2]) for k, name in enumerate("abcdef")}
    usable, sag = rng.integers(5, 17, (6, 12)), np.zeros((6, 12, 2))
    settings = Settings.paper(demonstrator_deg=(45, -90), sensor="rendered")
    found = fig8.Fig8(settings, (2, 4), np.array([45.0, -90]), usable, sag, surfaces)
    written = write("fig8", ON_PICTURES["fig8"], found, tmp_path)
    assert {path.name for path in written} >= {"fig8.svg", "fig8.png", "fig8-surface.csv"}
    root = ElementTree.parse(tmp_path / "fig8.svg").getroot()
    crosses = only(root, f"{SVG}path", SMALLEST_E)
    assert len(crosses) == len(surfaces) + 1  # and one in the legend
    said = "".join(root.itertext())
    assert all(
        f"{name}E {svg.number(k * E.min(), 2 if k * E.min() < 10 else 0)}" in said for k, name in enumerate("abcdef", 1)
    )
    numbers = [node.text for node in only(root, f"{SVG}text", CELL_NUMBERS) if node.text.isdigit()]
    assert [int(number) for number in numbers] == usable.ravel().tolist()
