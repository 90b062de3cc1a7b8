"""Tracked points: tidy and DeepLabCut's CSV say the same, faults are named by file, line and column."""

import re

import numpy as np
import pytest

from viewimit import TRANSFERS
from viewimit.drawing.export import figures
from viewimit.estimation.views import VIEW_NAMES, VIEWS, FourViews, view_of
from viewimit.options import option
from viewimit.sensing.tracks import read_files, read_tidy
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World


@pytest.fixture
def views():
    theta = np.radians([45.0, -90.0])
    return World(load_scene("panda")).look(theta, theta + 0.1)


def images(views: FourViews):
    return dict(zip(VIEWS, (views.demo_left, views.demo_right, views.own_left, views.own_right)))


@pytest.fixture
def tidy(tmp_path, views):
    lines = ["frame,view,point,x,y,confidence"]
    for view, points in images(views).items():
        lines += [f"0,{view},{k},{x!r},{y!r},0.9" for k, (x, y) in enumerate(points.tolist())]
    path = tmp_path / "points.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.fixture
def deeplabcut(tmp_path, views):
    paths = {}
    for view, points in images(views).items():
        parts = [f"p{k}" for k in range(len(points)) for _ in range(3)]
        row = [value for x, y in points.tolist() for value in (repr(x), repr(y), "0.9")]
        heads = ["scorer", *["net"] * len(parts)], ["bodyparts", *parts], ["coords", *["x", "y", "likelihood"] * 10]
        paths[view] = tmp_path / f"dlc-{'demo' if view in 'lr' else 'own'}-{view.lower()}.csv"
        paths[view].write_text("\n".join(",".join(line) for line in (*heads, ["0", *row])) + "\n")
    return paths


def test_both_kinds_of_file_hold_the_same(tidy, deeplabcut, views):
    for tracked in (read_tidy(tidy), read_files(deeplabcut)):
        read = tracked.views(0.6)
        np.testing.assert_array_equal(read.demo[0], views.demo)
        np.testing.assert_array_equal(read.own[0], views.own)
        assert read.visible.all() and not tracked.views(0.95).visible.any()


def test_the_command_prints_the_results_of_the_library(ask_json, tidy, deeplabcut, views):
    files = [word for view in VIEWS for word in (option(VIEW_NAMES[view]), deeplabcut[view])]
    for words, transfer in (
        ([tidy], "projective"),
        (files, "projective"),
        ([tidy, "--transfer", "epipolar"], "epipolar"),
    ):
        fitted = TRANSFERS[transfer](views)
        status, told = ask_json("evaluate", *words)
        (frame,) = told["frames"]
        assert status == 0 and frame["E"] == pytest.approx(float(fitted.conflict(views)))
        assert frame["condition"] == pytest.approx(float(fitted.condition)) and len(frame["usable"]) == 10
        assert set(frame["fundamental"]) == {
            "demo_left,own_left", "demo_left,own_right", "demo_right,own_left", "demo_right,own_right",
            "own_left,own_right",
        }  # fmt: skip
        for pair, f in frame["fundamental"].items():
            p, q = (images(views)[view_of(name)] for name in pair.split(","))
            away = np.concatenate([p, q], -1) @ [f["f13"], f["f23"], f["f31"], f["f32"]] + f["f33"]
            assert np.sqrt((away**2).mean()) < 1.5  # Eq. (1), to the affine camera's error


@pytest.fixture
def suspicious(tmp_path):
    """Three frames of 16 points, the learner in the demonstrator's posture: p2 and p9 are swapped, p5 is misplaced."""
    world, lines = World(load_scene("panda"), 16), ["frame,view,point,x,y,confidence"]
    for frame, theta in enumerate(np.radians([(45, -90), (20, -40), (70, -140)])):
        seen = world.look(theta, theta).permuted(((2, 9),))
        seen.own[5, 1] += 60 * (frame == 1)
        for view, points in images(seen).items():
            lines += [f"{10 + frame},{view},<p{k}>,{x!r},{y!r},0.9" for k, (x, y) in enumerate(points.tolist())]
    path = tmp_path / "suspicious.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


def test_points_that_are_likely_wrong_are_listed_with_their_score(ask, ask_json, suspicious, tmp_path):
    _, told = ask_json("evaluate", suspicious, "--out", tmp_path / "report.html")
    misplaced, swapped = told["suspects"]
    assert {key: misplaced[key] for key in ("kind", "points", "views", "frames")} == {
        "kind": "misplaced", "points": ["<p5>"], "views": ["own_left", "own_right"], "frames": [11],
    }  # fmt: skip
    assert misplaced["score"] > 100 and "E" not in misplaced
    assert (swapped["kind"], swapped["points"]) == ("swapped", ["<p2>", "<p9>"])
    assert swapped["views"] == ["demo_left", "demo_right"]
    assert swapped["E"] > 10 * swapped["E_swapped"] and told["undecided"] == []
    _, out, _ = ask("evaluate", suspicious)
    page = (tmp_path / "report.html").read_text()
    assert "<p5>  misplaced in own_left or own_right: " in out and "off; frame 11" in out
    assert "<p2> and <p9>  swapped in demo_left, demo_right: E " in out
    assert "&lt;p5&gt;" in page and "misplaced in own_left or own_right" in page and "<p5>" not in page


def test_a_view_of_one_frame_is_used_for_all_frames(tmp_path, tidy):
    text = tidy.read_text()
    more = [line.replace("0,", "7,", 1) for line in text.splitlines() if line[:4] in ("0,L,", "0,R,")]
    tidy.write_text(text + "\n".join(more) + "\n")
    tracked = read_tidy(tidy)
    assert tracked.frames == (0, 7) and tracked.views().visible.all()


def test_a_png_that_cannot_be_rendered_is_refused_with_alternatives(ask, tidy, tmp_path, monkeypatch):
    monkeypatch.setattr(figures, "can_render", lambda suffix=".png": False)
    status, _, err = ask("evaluate", tidy, "--out", tmp_path / "report.png")
    assert status == 2 and "pip install" in err
    instead = re.search(r"(\.\w+) does not", err)[1]
    assert ask("evaluate", tidy, "--out", tmp_path / f"report{instead}")[0] == 0


def test_a_report_is_written(ask, tidy, tmp_path):
    status, _, _ = ask("evaluate", tidy, "--out", tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text()
    assert status == 0 and page.count("<svg") == 4 and page.count("<circle") == 40 and "http" not in page
    assert "var(" not in page and "<script" not in page
    assert ask("evaluate", tidy, "--out", tmp_path / "report.doc")[0] == 2


@pytest.mark.parametrize("mark", ["0,0", "-1,-1", "0.0,-0.0"])
def test_missing_values_are_invisible_and_reported(ask, tidy, mark):
    lines = tidy.read_text().splitlines()
    lost = [",".join([*line.split(",")[:3], mark, "0.9"]) if line.split(",")[2] == "4" else line for line in lines]
    tidy.write_text("\n".join(line for line in lines if line.split(",")[2] != "4"))
    _, expected, silent = ask("evaluate", tidy)
    tidy.write_text("\n".join(lost))
    status, said, err = ask("evaluate", tidy)
    assert (status, said.replace("10 points", "9 points")) == (0, expected) and "lost" not in silent
    assert "4 points at (0, 0), (-1, -1) or the like: counted as lost by the tracker" in err


def test_views_without_a_common_frame_are_told_with_their_frames(ask, tidy):
    head, *rows = tidy.read_text().splitlines()
    rows = [f"{2 * VIEWS.index(row[2]) + k}{row[1:]}" for row in rows for k in (0, 1)]
    tidy.write_text("\n".join([head, *rows]) + "\n")
    said = ask("evaluate", tidy)[2]
    assert "no frame number is in all four views" in said and f"{VIEW_NAMES[VIEWS[3]]} has 6 to 7" in said


def test_too_few_points_are_no_success(ask, tidy):
    status, _, err = ask("evaluate", tidy, "--min-confidence", 0.95)
    assert status == 1 and "no frame has 5 points" in err


@pytest.mark.parametrize(
    "line, column, text, says",
    [
        (1, 3, "ux", "line 1: no column x"),
        (1, 5, "x", "line 1: two columns are named x: keep one of them"),
        (5, 4, "inf", "line 5, column y: 'inf'"),
        (5, 0, "-1", "line 5, column frame: '-1' is not a whole number"),
        (5, 0, "9" * 20, "line 5, column frame: '99999999999999999999' is not a whole number"),
        (5, 1, "M", "line 5, column view: 'M' is none of demo_left, demo_right, own_left, own_right"),
        (5, 2, "2", "line 5: point 2 of frame 0 in view demo_left stands in line 4 too"),
        (5, 5, "1,1", "line 5: 7 cells, but 6 columns"),
    ],
)
def test_faults_are_named_by_line_and_column(ask, tidy, line, column, text, says):
    lines = tidy.read_text().splitlines()
    cells = lines[line - 1].split(",")
    cells[column] = text
    lines[line - 1] = ",".join(cells)
    tidy.write_text("\n".join(lines))
    status, _, err = ask("evaluate", tidy)
    assert status == 2 and "points.csv" in err and says in err


def test_faults_of_deeplabcut_files_are_named(ask, deeplabcut):
    path = deeplabcut["L"]
    path.write_text(path.read_text().replace("0.9", "sure", 1))
    status, _, err = ask("evaluate", *[word for view in VIEWS for word in (option(VIEW_NAMES[view]), deeplabcut[view])])
    assert status == 2 and path.name in err and "line 4, column 4 (p0 likelihood): 'sure'" in err
    assert ask("evaluate", "--demo-left", path)[0] == 2
    assert ask("evaluate", path)[0] == 2 and "no view" not in err


def test_the_view_of_a_picture_follows_from_its_name_or_an_option(ask, tmp_path):
    pytest.importorskip("cv2")
    status, _, err = ask("detect", tmp_path / "front.png", "--out", tmp_path / "a.csv")
    assert status == 2 and "does not end in a view" in err
    status, _, err = ask("detect", "--own-left", tmp_path / "front.png", "--out", tmp_path / "a.csv")
    assert status == 2 and "--own-left" in err and "No such file" in err


def test_full_names_of_views_and_those_of_the_paper_are_read_alike(tmp_path, tidy, deeplabcut, views):
    short = read_tidy(tidy)
    full = tmp_path / "full.csv"
    full.write_text(re.sub("(?m)^0,([lrLR]),", lambda found: f"0,{VIEW_NAMES[found[1]]},", tidy.read_text()))
    mixed = tmp_path / "mixed.csv"
    mixed.write_text(re.sub("(?m)^0,([rL]),", lambda found: f"0, {VIEW_NAMES[found[1]].title()} ,", tidy.read_text()))
    by_name = {VIEW_NAMES[view]: path for view, path in deeplabcut.items()}
    for found in (read_tidy(full), read_tidy(mixed), read_files(by_name), read_files(deeplabcut)):
        np.testing.assert_array_equal(found.views().demo[0], views.demo)
        np.testing.assert_array_equal(found.views().own[0], views.own)
    assert "own_left" in full.read_text() and read_tidy(full).points == short.points


def test_pictures_become_points_and_an_evaluation(ask, ask_json, tmp_path):
    cv2 = pytest.importorskip("cv2")
    from viewimit.simulation.rendering import RenderedEyes

    eyes, theta = RenderedEyes(load_scene("panda")), np.radians([45.0, -90.0])
    eyes.demo_images(theta), eyes.own_images(theta)
    files = []
    for view in VIEWS:
        files.append(tmp_path / f"take_{VIEW_NAMES[view]}.png")
        cv2.imwrite(str(files[-1]), cv2.cvtColor(eyes.look(view), cv2.COLOR_RGB2BGR))
    status, told = ask_json("detect", *files, "--middle", 0.56, "--out", tmp_path / "p.csv")
    assert status == 0 and all(each["frames"] == 1 for each in told["views"].values())
    status, told = ask_json("evaluate", tmp_path / "p.csv")
    found = np.all([eyes.detections[view].found for view in VIEWS], 0)
    assert status == 0 and told["frames"][0]["usable"] == [str(k) for k in np.flatnonzero(found)]
    assert told["frames"][0]["E"] < 5
