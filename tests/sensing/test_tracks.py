"""Tracked points: tidy and DeepLabCut's CSV say the same, faults are named by file, line and column."""

import re

import numpy as np
import pytest
from drawn import RESIDUALS, written_path

from viewimit import TRANSFERS
from viewimit.commands.options import option
from viewimit.drawing.export import figures
from viewimit.estimation.views import VIEW_NAMES, VIEWS, FourViews, view_of
from viewimit.sensing.tracks import read_files, read_tidy, read_view, write_tidy
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


def test_columns_are_known_in_capitals_and_between_blanks_too(tmp_path, tidy):
    heading, rest = tidy.read_text().split("\n", 1)
    other = tmp_path / "capitals.csv"
    other.write_text(f"{heading.title().replace(',', ' , ')}\n{rest}")
    found, same = read_tidy(other).views(0.6), read_tidy(tidy).views(0.6)
    np.testing.assert_array_equal(found.demo, same.demo)
    np.testing.assert_array_equal(found.own, same.own)
    with pytest.raises(ValueError, match="a table of all four views: give it alone"):
        read_view(other)


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


@pytest.mark.parametrize("more", [[], ["--undistort", "0.001,0", "--lens", "256,256,320,120"]])
def test_points_in_whole_pixels_are_not_called_misplaced(ask_json, tmp_path, more):
    world, rng, lines = World(load_scene("panda"), 16), np.random.default_rng(0), ["frame,view,point,x,y,confidence"]
    for frame, theta in enumerate(np.radians([(45, -90), (20, -40), (70, -140)])):
        for view, points in images(world.look(theta, theta + 0.5)).items():
            whole = np.round(points + 0.3 * rng.standard_normal(points.shape)).tolist()
            lines += [f"{frame},{view},{k},{x:.0f},{y:.0f},1" for k, (x, y) in enumerate(whole)]
    path = tmp_path / "whole.csv"
    path.write_text("\n".join(lines) + "\n")
    status, told = ask_json("evaluate", path, *more)
    assert status == 0 and told["suspects"] == []


def test_no_suspects_and_undecided_swaps_are_reported(ask, ask_json, tidy, suspicious):
    _, told = ask_json("evaluate", tidy)
    assert told["suspects"] == [] and "they show only with arms in one posture" in told["undecided"][0]
    _, out, _ = ask("evaluate", tidy)
    assert "suspects: none\n  undecided: swapped points: E of the projective transfer is " in out


def test_a_view_of_one_frame_is_used_for_all_frames(tmp_path, tidy):
    text = tidy.read_text()
    more = [line.replace("0,", "7,", 1) for line in text.splitlines() if line[:4] in ("0,L,", "0,R,")]
    tidy.write_text(text + "\n".join(more) + "\n")
    tracked = read_tidy(tidy)
    assert tracked.frames == (0, 7) and tracked.views().visible.all()


def test_a_view_with_one_non_empty_frame_is_not_used_for_all_frames(tmp_path):
    """Its body moves: the other view of it says so."""
    lines = [
        f"{t},{view},p{k},{'' if view == 'L' and t != 3 else 9 * k},{k * k + t},1"
        for t in range(5) for view in VIEWS for k in range(6)
    ]  # fmt: skip
    paths = {view: tmp_path / f"{view}.csv" for view in VIEWS}
    for view, path in paths.items():
        own = [line.replace(f"{view},", "", 1) for line in lines if f",{view}," in line]
        path.write_text("\n".join(["frame,point,x,y,confidence", *own]) + "\n")
    (tmp_path / "tidy.csv").write_text("\n".join(["frame,view,point,x,y,confidence", *lines]) + "\n")
    for tracked in (read_tidy(tmp_path / "tidy.csv"), read_files(paths)):
        assert tracked.frames == (0, 1, 2, 3, 4)
        assert tracked.views().visible[:, :, 2].any(-1).tolist() == [False, False, False, True, False]


def test_a_confidence_in_percent_is_refused(tmp_path, tidy):
    percent = tmp_path / "percent.csv"
    percent.write_text(tidy.read_text().replace(",0.9\n", ",97\n", 3))
    with pytest.raises(
        ValueError, match="percent.csv: view demo_left: frame 0, point .*: confidence 97 .* divide percentages by"
    ):
        read_tidy(percent)
    of_one = tmp_path / "of_one.csv"
    of_one.write_text("frame,point,x,y,likelihood\n0,a,1,2,97\n")
    with pytest.raises(ValueError, match="of_one.csv: frame 0, point a: confidence 97 .* divide percentages by 100"):
        read_view(of_one)


def test_a_png_that_cannot_be_rendered_is_refused_with_alternatives(ask, tidy, tmp_path, monkeypatch):
    monkeypatch.setattr(figures, "can_render", lambda suffix=".png": False)
    status, _, err = ask("evaluate", tidy, "--out", tmp_path / "report.png")
    assert status == 2 and "pip install" in err
    instead = re.search(r"(\.\w+) does not", err)[1]
    assert ask("evaluate", tidy, "--out", tmp_path / f"report{instead}")[0] == 0


def test_tracks_without_a_common_name_have_a_message_of_their_own(ask, tmp_path, tidy):
    head, *rows = tidy.read_text().splitlines()
    other = tmp_path / "other.csv"
    renamed = [re.sub(r"^(\d+,[LR],)", r"\1own ", row) for row in rows]
    other.write_text("\n".join([head, *renamed]) + "\n")
    status, _, err = ask("evaluate", other)
    assert status == 1 and "no point has the same name in all four views" in err


def test_a_report_is_written(ask, tidy, tmp_path):
    status, _, _ = ask("evaluate", tidy, "--out", tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text()
    assert status == 0 and page.count("<svg") == 4 and page.count("<circle") == 40 and "http" not in page
    assert "var(" not in page and "<script" not in page
    assert ask("evaluate", tidy, "--out", tmp_path / "report.doc")[0] == 2


def test_a_report_shows_points_and_residuals_to_one_scale(ask, ask_json, tidy, tmp_path):
    _, told = ask_json("evaluate", tidy, "--out", tmp_path / "report.html")
    (frame,) = told["frames"]
    page = (tmp_path / "report.html").read_text()
    for view, drawing in zip(VIEWS, re.findall(r"<svg.*?</svg>", page, re.DOTALL)):
        x, y = (np.array(re.findall(rf'<circle[^>]* c{axis}="([\d.]+)"', drawing), float) for axis in "xy")
        seen = np.array(frame["seen"][VIEW_NAMES[view]])
        scale = np.ptp(x) / np.ptp(seen[:, 0])
        np.testing.assert_allclose(y - y[0], scale * (seen[:, 1] - seen[0, 1]), atol=0.3)
        arrows = written_path(drawing, RESIDUALS)
        assert (arrows is not None) == (view in "LR")
        if arrows:
            a, b, c, d = np.array(re.findall(r"-?[\d.]+", arrows), float).reshape(-1, 4).T
            away = seen - frame["recovered"][VIEW_NAMES[view]]
            np.testing.assert_allclose(np.stack([c - a, d - b], -1), scale * away, atol=0.3)


def test_a_report_is_a_picture_too(ask, tidy, tmp_path, monkeypatch):
    assert ask("evaluate", tidy, "--out", tmp_path / "report.png")[0] == 0
    assert (tmp_path / "report.png").read_bytes().startswith(b"\x89PNG")
    monkeypatch.setattr("viewimit.drawing.export.figures.can_render", lambda suffix=".png": False)
    status, _, err = ask("evaluate", tidy, "--out", tmp_path / "other.png")
    assert status == 2 and "pip install 'viewimit[plot]'" in err


@pytest.mark.parametrize("sure, usable", [("", 10), ("nan", 9), ("0.2", 9), ("1", 10)])
def test_a_point_of_no_confidence_is_not_seen(ask_json, tidy, sure, usable):
    """Of an empty cell it is not known, and taken to be seen."""
    lines = tidy.read_text().splitlines()
    lines[4] = ",".join([*lines[4].split(",")[:-1], sure])
    tidy.write_text("\n".join(lines))
    _, found = ask_json("evaluate", tidy, "--min-confidence", 0.5)
    assert len(found["frames"][0]["usable"]) == usable


@pytest.mark.parametrize("mark", ["0,0", "-1,-1", "0.0,-0.0"])
def test_missing_values_are_invisible_and_reported(ask, tidy, mark):
    lines = tidy.read_text().splitlines()
    lost = [",".join([*line.split(",")[:3], mark, "0.9"]) if line.split(",")[2] == "4" else line for line in lines]
    tidy.write_text("\n".join(line for line in lines if line.split(",")[2] != "4"))
    _, expected, silent = ask("evaluate", tidy)
    tidy.write_text("\n".join(lost))
    status, said, err = ask("evaluate", tidy)
    assert (status, said.replace("10 points", "9 points")) == (0, expected) and "lost" not in silent
    assert "4 points at (0, 0) or (-1, -1): taken for lost by the tracker, not seen" in err


def test_too_few_points_are_no_success(ask, tidy):
    status, _, err = ask("evaluate", tidy, "--min-confidence", 0.95)
    assert status == 1 and "no frame has 5 points" in err


@pytest.mark.parametrize(
    "line, column, text, says",
    [
        (1, 3, "ux", "line 1: no column x"),
        (1, 5, "x", "line 1: two columns are named x: keep one of them"),
        (5, 3, "abc", "line 5, column x: 'abc' is not a finite number"),
        (5, 4, "inf", "line 5, column y: 'inf'"),
        (5, 5, "high", "line 5, column confidence: 'high'"),
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


@pytest.mark.parametrize("option", ["--demonstrator", "--learner"])
def test_nobody_is_named_in_a_table_of_all_four_views(ask, tidy, option):
    status, out, err = ask("evaluate", tidy, option, "m1")
    assert status == 2 and out == "" and f"{option}: {tidy} is a table of all four views" in err


def test_spaces_after_commas_are_no_part_of_a_heading_nor_of_a_cell(tidy, tmp_path):
    (tmp_path / "spaced.csv").write_text(tidy.read_text().replace(",", ", "))
    read, spaced = read_tidy(tidy), read_tidy(tmp_path / "spaced.csv")
    assert spaced.points == read.points
    np.testing.assert_array_equal(spaced.views().demo, read.views().demo)


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


@pytest.mark.parametrize(
    "name, option_named",
    [
        ("own_left.png", "--own-left"),
        ("take2_demo_right.png", "--demo-right"),
        ("take2-Own-Right.png", "--own-right"),
        ("L.png", "--own-left"),
        ("take_l.png", "--demo-left"),
    ],
)
def test_a_picture_is_known_by_the_end_of_its_name(ask, tmp_path, name, option_named):
    pytest.importorskip("cv2")
    status, _, err = ask("detect", tmp_path / name, "--out", tmp_path / "a.csv")
    assert status == 2 and f"{option_named}: " in err and "No such file" in err


@pytest.mark.parametrize("name", ["shown_left.png", "reown_left.png", "ownleft.png", "left.png", "take_M.png"])
def test_a_picture_that_only_seems_to_name_a_view_is_refused(ask, tmp_path, name):
    pytest.importorskip("cv2")
    status, _, err = ask("detect", tmp_path / name, "--out", tmp_path / "a.csv")
    assert status == 2 and "does not end in a view such as _demo_left" in err


def test_full_names_of_views_and_those_of_the_paper_are_read_alike(tmp_path, tidy, deeplabcut, views):
    short = read_tidy(tidy)
    full = tmp_path / "full.csv"
    full.write_text(re.sub("(?m)^0,([lrLR]),", lambda found: f"0,{VIEW_NAMES[found[1]]},", tidy.read_text()))
    mixed = tmp_path / "mixed.csv"
    mixed.write_text(re.sub("(?m)^0,([rL]),", lambda found: f"0, {VIEW_NAMES[found[1]]} ,", tidy.read_text()))
    by_name = {VIEW_NAMES[view]: path for view, path in deeplabcut.items()}
    for found in (read_tidy(full), read_tidy(mixed), read_files(by_name), read_files(deeplabcut)):
        np.testing.assert_array_equal(found.views().demo[0], views.demo)
        np.testing.assert_array_equal(found.views().own[0], views.own)
    assert "own_left" in full.read_text() and read_tidy(full).points == short.points


def test_a_row_under_both_names_of_its_view_is_a_repeated_row(tmp_path, tidy):
    tidy.write_text(tidy.read_text() + "0,demo_left,3,1,2,0.9\n")
    with pytest.raises(ValueError, match="point 3 of frame 0 in view demo_left stands in line 5 too"):
        read_tidy(tidy)


def test_written_names_of_views_differ_by_more_than_case(tmp_path):
    path = tmp_path / "p.csv"
    write_tidy(path, {view: [(0, "a", 1.0 + k, 2.0, 1.0), (0, "b", 3.0, 4.0 + k, 1.0)] for k, view in enumerate(VIEWS)})
    lines = path.read_text().splitlines()
    written = list(dict.fromkeys(line.split(",")[1] for line in lines[1:]))
    assert written == ["demo_left", "demo_right", "own_left", "own_right"] == [*VIEW_NAMES.values()]
    assert len({name.lower() for name in written}) == 4
    assert read_tidy(path).image["L"][0].tolist() == [[3.0, 2.0], [3.0, 6.0]]


@pytest.mark.parametrize("command", ["detect", "evaluate"])
def test_names_that_are_one_file_where_case_makes_no_name_are_refused(ask, tmp_path, command):
    """As `take_l.png` and `take_L.png` on most disks of macOS and Windows; here by a link."""
    pytest.importorskip("cv2")
    small, capital = tmp_path / "take_l.csv", tmp_path / "take_L.csv"
    small.write_text("point,x,y\n")
    capital.hardlink_to(small)
    words = ["--demo-left", small, "--own-left", capital]
    more = ["--out", tmp_path / "out.csv"] if command == "detect" else []
    files = [small, capital] if command == "detect" else words
    status, _, err = ask(command, *files, *more)
    assert status == 2 and f"{small} and {capital} are one file here: name those of the views by demo_left, " in err


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
