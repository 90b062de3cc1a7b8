"""What `evaluate` says of the transfers, of rectification, and of points that it leaves out for their confidence."""

import re

import numpy as np
import pytest
from axle_markers import axle_markers

from viewimit.commands.options import option
from viewimit.estimation.transfers import TRANSFERS
from viewimit.estimation.views import VIEW_NAMES, VIEWS, FourViews
from viewimit.experiments.bench.tracks import Case, draw
from viewimit.geometry.rectification import fit_rectification
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World


def write(path, views, confidence=lambda frame, view, point: 1.0):
    """A tidy table of views, (T, N, …), as a person would have tracked them."""
    lines = ["frame,view,point,x,y,confidence"]
    for frame, (demo, own) in enumerate(zip(views.demo, views.own)):
        for view, image in zip(VIEWS, (demo[:, :2], demo[:, 2:], own[:, :2], own[:, 2:])):
            for point, (x, y) in enumerate(image.tolist()):
                lines.append(f"{frame},{view},p{point},{x!r},{y!r},{confidence(frame, view, point)}")
    path.write_text("\n".join(lines) + "\n")
    return path


def arms(points=16, frames=3):
    """Both in the same posture."""
    world, rng = World(load_scene("panda"), points), np.random.default_rng(3)
    seen = [world.look(theta, theta) for theta in rng.uniform(world.scene.lower, world.scene.upper, (frames, 2))]
    noise = 0.2 * rng.standard_normal((2, frames, points, 4))
    demo, own = np.array([views.demo for views in seen]), np.array([views.own for views in seen])
    return FourViews(demo + noise[0], own + noise[1], np.ones(demo.shape, bool))


def rig(seed, points=20, toe_in_deg=0.0):
    return draw(Case(points, toe_in_deg), np.random.default_rng(seed))[0]


def test_all_transfers_are_listed_with_their_leave_one_out_error(ask, ask_json, tmp_path):
    path = write(tmp_path / "rig.csv", rig(4))
    _, told = ask_json("evaluate", path)
    found = told["leave_one_out"]
    assert list(found["error_px"]) == list(found["rectified_px"]) == list(TRANSFERS)
    assert told["transfer"] == "projective" and 5 * found["error_px"]["projective"] < found["error_px"]["epipolar"]
    assert (found["predictions"], found["of_predictions"], found["frames"], found["of_frames"]) == (20, 20, 1, 1)
    _, out, _ = ask("evaluate", path, "--out", tmp_path / "report.html")
    assert "leave-one-out error, rms px: 20 predictions in 1 frame\n" in out
    page = (tmp_path / "report.html").read_text()
    for name in TRANSFERS:
        cells = [f"{found[of][name]:.3g}" for of in ("error_px", "rectified_px")]
        (line,) = [line.split() for line in out.splitlines() if line.startswith(f"  {name} ")]
        assert line == [name, *cells]
        assert re.search(rf"{name} +{cells[0]} +{cells[1]}", page)
    _, out, _ = ask("evaluate", path, "--rectify", "off")
    assert [line for line in out.splitlines() if line.startswith("  projective ") and len(line.split()) == 2]


@pytest.mark.parametrize("seed", range(5))
def test_a_rectified_pair_is_left_as_it_is_where_its_matches_alone_would_ask_for_more(ask, ask_json, tmp_path, seed):
    views = next(
        views
        for views in (rig([seed, k], points=40) for k in range(50))
        if fit_rectification(*np.split(np.concatenate([views.demo[0], views.own[0]]), 2, axis=1)) is not None
    )
    path = write(tmp_path / "rig.csv", views)
    _, told = ask_json("evaluate", path)
    found = told["leave_one_out"]
    assert told["rectification"] is None and found["rectified_ratio"] < found["rectified_ratio_bound"]
    assert found["rectified_ratio_bound"] > 0.95
    _, out, _ = ask("evaluate", path)
    assert f"images left as they are: projective is {found['rectified_ratio']:.2g} times as far off if rectified" in out


@pytest.mark.parametrize("toe_in_deg", [2.0, 20.0])
def test_a_toed_in_pair_is_rectified(ask, ask_json, tmp_path, toe_in_deg):
    path = write(tmp_path / "rig.csv", rig(6, toe_in_deg=toe_in_deg))
    _, told = ask_json("evaluate", path)
    found = told["leave_one_out"]
    assert told["rectification"] is not None and found["rectified_ratio_bound"] < 0.95
    assert found["rectified_px"]["projective"] < found["error_px"]["projective"] / 2
    _, out, _ = ask("evaluate", path)
    assert "projective transfer, images rectified" in out and "images rectified: projective is 0." in out


def test_a_misplaced_point_and_a_swapped_pair_do_not_decide_what_fits(ask_json, tmp_path):
    views = arms()
    _, clean = ask_json("evaluate", write(tmp_path / "clean.csv", views))
    views.own[1, 5, 1] += 60
    wrong = views.permuted(((2, 9),))
    _, told = ask_json("evaluate", write(tmp_path / "wrong.csv", wrong))
    assert {suspect["kind"] for suspect in told["suspects"]} == {"misplaced", "swapped"}
    assert told["leave_one_out"]["predictions"] == clean["leave_one_out"]["predictions"] - 1
    for name, px in clean["leave_one_out"]["error_px"].items():
        assert told["leave_one_out"]["error_px"][name] == pytest.approx(px, rel=0.1)


@pytest.mark.parametrize("usable, transfer", [(5, "epipolar"), (7, "epipolar"), (8, "projective"), (16, "projective")])
def test_the_default_transfer_is_projective_from_eight_usable_points_on(ask_json, tmp_path, usable, transfer):
    unsure = lambda frame, view, point: 0.1 if view == "R" and point >= usable else 1.0
    _, told = ask_json("evaluate", write(tmp_path / "points.csv", arms(), unsure))
    assert told["transfer"] == transfer and len(told["frames"][0]["usable"]) == usable


def test_a_frame_of_too_few_points_for_the_projective_transfer_is_weak(ask_json, tmp_path):
    unsure = lambda frame, view, point: 0.1 if frame == 1 and point >= 7 else 1.0
    _, told = ask_json("evaluate", write(tmp_path / "points.csv", arms(), unsure))
    weak = [frame["weak"] for frame in told["frames"]]
    assert (
        told["transfer"] == "projective" and weak[0] is weak[2] is None and weak[1].startswith("7 points: fewer than")
    )


def test_what_min_confidence_removes_is_said_by_number_and_name(ask, ask_json, tmp_path):
    unsure = lambda frame, view, point: 0.59 if (point == 4 and view in "lR") or (point, frame) == (2, 1) else 0.6
    path = write(tmp_path / "points.csv", arms(), unsure)
    status, _, err = ask("evaluate", path)
    assert status == 0 and "--min-confidence 0.6 removed 10 of 192 image points: p4 (6), p2 (4)\n" in err
    assert ask_json("evaluate", path)[1]["removed_by_confidence"] == {"p2": 4, "p4": 6}
    status, _, err = ask("evaluate", path, "--min-confidence", 0)
    assert status == 0 and "removed" not in err
    assert ask_json("evaluate", path, "--min-confidence", 0)[1]["removed_by_confidence"] == {}
    _, _, err = ask("evaluate", write(tmp_path / "less.csv", arms(), lambda *of: 0.5 if of[2] < 12 else 1.0))
    assert "removed 144 of 192 image points: p0 (12), p1 (12), " in err and "p9 (12) and 2 more names\n" in err


def test_if_min_confidence_leaves_nothing_the_remedy_is_stated(ask, tmp_path):
    path = write(tmp_path / "points.csv", arms(), lambda *of: 0.3)
    status, _, err = ask("evaluate", path)
    assert status == 1 and "removed 192 of 192 image points" in err
    assert "no frame has 5 points in all four views of confidence 0.6 or more" in err and "--min-confidence 0 " in err
    assert ask("evaluate", path, "--min-confidence", 0)[0] == 0


def test_where_confidence_is_not_the_cause_no_such_remedy_is_stated(ask, tmp_path):
    lines = write(tmp_path / "points.csv", arms(), lambda *of: 0.3).read_text().splitlines()
    few = [line for line in lines if ",R,p" not in line or line.split(",")[2] in ("p0", "p1")]
    (tmp_path / "few.csv").write_text("\n".join(few) + "\n")
    status, _, err = ask("evaluate", tmp_path / "few.csv")
    assert status == 1 and err.endswith("no frame has 5 points in all four views\n")


def test_confidence_is_said_of_one_file_a_view_too(ask, tmp_path):
    views, words = arms(frames=1), []
    for view, image in zip(VIEWS, (views.demo_left, views.demo_right, views.own_left, views.own_right)):
        path = tmp_path / f"{'demo' if view in 'lr' else 'own'}-{view.lower()}.csv"
        rows = [f"0,p{k},{x!r},{y!r},{0.2 if k == 3 else 0.9}" for k, (x, y) in enumerate(image[0].tolist())]
        path.write_text("\n".join(["frame,point,x,y,likelihood", *rows]) + "\n")
        words += [option(VIEW_NAMES[view]), path]
    assert "--min-confidence 0.6 removed 4 of 64 image points: p3 (4)\n" in ask("evaluate", *words)[2]


def test_a_long_track_is_sampled_and_that_is_said(ask, tmp_path):
    _, out, _ = ask("evaluate", write(tmp_path / "long.csv", arms(10, 120)))
    assert "leave-one-out error, rms px: 500 of 1,200 predictions in 50 of 120 frames, evenly spaced\n" in out


def test_without_six_usable_points_there_is_no_leave_one_out_error_which_is_said(ask, ask_json, tmp_path):
    path = write(tmp_path / "points.csv", arms(5))
    assert "leave-one-out error: none, as no frame has 6 points" in ask("evaluate", path)[1]
    assert ask_json("evaluate", path)[1]["leave_one_out"] is None


def test_a_table_of_one_point_has_too_few_points_however_many_frames_it_has(ask, tmp_path):
    views = arms(frames=9)
    one = FourViews(*(images[:, :1] for images in (views.demo, views.own, views.visible)))
    status, out, err = ask("evaluate", write(tmp_path / "one.csv", one))
    assert status == 1 and " 1 points, 9 frames\n" in out
    assert "no frame has 5 points in all four views" in err


def test_of_arms_in_different_postures_the_matches_decide_which_is_said(ask, tmp_path):
    world, rng = World(load_scene("panda-toed"), 16), np.random.default_rng(4)
    low, high = world.scene.lower, world.scene.upper
    seen = [world.look(low + 0.1 * k, high - 0.1 * k) for k in range(4)]
    demo, own = (np.array([getattr(views, body) for views in seen]) for body in ("demo", "own"))
    noise = 0.2 * rng.standard_normal((2, *demo.shape))
    views = FourViews(demo + noise[0], own + noise[1], np.ones(demo.shape, bool))
    _, out, _ = ask("evaluate", write(tmp_path / "points.csv", views))
    large = "errors this large are of arms in different postures, or of magnified noise"
    assert f"images rectified, as their matches ask; {large}\n" in out


def mirrored(head, noise_px=0.2):
    """Arms with markers at both ends of their axles: the learner in mirrored postures but in frame 1."""
    scene = load_scene('extends = "iiwa"\nrange_deg = [[-50, 50], [-100, 100]]\n' + head)
    world, rng = World(scene, body=axle_markers(scene)), np.random.default_rng(0)
    seen = [
        world.look(theta, theta if k == 1 else -theta)
        for k, theta in enumerate(np.radians([(40, -60), (-30, 80), (20, 50)]))
    ]
    demo, own = (np.array([getattr(views, body) for views in seen]) for body in ("demo", "own"))
    noise = noise_px * rng.standard_normal((2, *demo.shape))
    return FourViews(demo + noise[0], own + noise[1], np.ones(demo.shape, bool))


@pytest.mark.parametrize("toe_in_deg", [0, 12])
@pytest.mark.parametrize("transfer", ["projective", "epipolar"])
def test_a_frame_whose_fit_reflects_is_called_mirrored_and_its_E_no_good_fit(
    ask, ask_json, tmp_path, toe_in_deg, transfer
):
    path = write(tmp_path / "points.csv", mirrored(f"[head]\ntoe_in_deg = {toe_in_deg}\n"))
    _, told = ask_json("evaluate", path, "--transfer", transfer)
    assert (told["rectification"] is not None) == (toe_in_deg > 0)
    assert [frame["mirrored"] for frame in told["frames"]] == [True, False, True]
    _, out, err = ask("evaluate", path, "--transfer", transfer, "--out", tmp_path / "report.html")
    rows = [line for line in out.splitlines() if line[:7].strip() in ("0", "1", "2")]
    assert [row.endswith("  mirrored") for row in rows] == [True, False, True]
    says = "2 of 3 frames mirrored: "
    assert f"{says}frame 0: the fit is a reflection" in err and "no good fit" in err
    page = (tmp_path / "report.html").read_text()
    E = [f"{frame['E']:.4g}" for frame in told["frames"]]
    assert f"E = {E[0]} (mirrored) px²" in page and f"<p>{says}the fit is a reflection" in page
    assert all(one in page for one in E)


def test_of_arms_in_the_same_posture_nothing_is_called_mirrored(ask, ask_json, tmp_path):
    path = write(tmp_path / "points.csv", arms())
    assert [frame["mirrored"] for frame in ask_json("evaluate", path)[1]["frames"]] == [False] * 3
    _, out, err = ask("evaluate", path, "--out", tmp_path / "report.html")
    assert "mirrored" not in out + err + (tmp_path / "report.html").read_text()


def test_files_of_left_and_right_in_each_others_place_are_a_mirror_image(ask_json, tmp_path):
    views = arms()
    exchanged = views.with_own(views.own[..., [2, 3, 0, 1]])
    _, told = ask_json("evaluate", write(tmp_path / "points.csv", exchanged))
    assert [frame["mirrored"] for frame in told["frames"]] == [True] * 3


def test_of_points_too_flat_for_their_handedness_to_show_nothing_is_said(ask_json, tmp_path):
    """Their disparities differ by noise alone; and with ten matches of left and right nobody knows the noise."""
    views = mirrored("")
    flat = views.demo.copy()
    flat[..., 2] = flat[..., 0] + 80 + 0.2 * np.random.default_rng(1).standard_normal(flat.shape[:2])
    _, told = ask_json("evaluate", write(tmp_path / "flat.csv", FourViews(flat, views.own, views.visible)))
    assert [frame["mirrored"] for frame in told["frames"]] == [None] * 3
    few = FourViews(views.demo[:1], views.own[:1], views.visible[:1]).select(np.arange(4, 9))
    assert ask_json("evaluate", write(tmp_path / "few.csv", few))[1]["frames"][0]["mirrored"] is None
