"""What `evaluate` says of the transfers, of rectification, and of points that it leaves out for their confidence."""

import re

import numpy as np
import pytest
from axle_markers import axle_markers
from tracks import Case, draw

from viewimit.estimation.transfers import TRANSFERS
from viewimit.estimation.views import VIEWS, FourViews
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


@pytest.mark.parametrize("toe_in_deg", [2.0, 20.0])
def test_a_toed_in_pair_is_rectified(ask, ask_json, tmp_path, toe_in_deg):
    path = write(tmp_path / "rig.csv", rig(6, toe_in_deg=toe_in_deg))
    _, told = ask_json("evaluate", path)
    found = told["leave_one_out"]
    assert told["rectification"] is not None and found["rectified_ratio_bound"] < 0.95
    assert found["rectified_px"]["projective"] < found["error_px"]["projective"] / 2
    _, out, _ = ask("evaluate", path)
    assert "projective transfer, images rectified" in out and "images rectified: projective is 0." in out


@pytest.mark.parametrize("usable, transfer", [(5, "epipolar"), (7, "epipolar"), (8, "projective"), (16, "projective")])
def test_the_default_transfer_is_projective_from_eight_usable_points_on(ask_json, tmp_path, usable, transfer):
    unsure = lambda frame, view, point: 0.1 if view == "R" and point >= usable else 1.0
    _, told = ask_json("evaluate", write(tmp_path / "points.csv", arms(), unsure))
    assert told["transfer"] == transfer and len(told["frames"][0]["usable"]) == usable


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


def test_files_of_left_and_right_in_each_others_place_are_a_mirror_image(ask_json, tmp_path):
    views = arms()
    exchanged = views.with_own(views.own[..., [2, 3, 0, 1]])
    _, told = ask_json("evaluate", write(tmp_path / "points.csv", exchanged))
    assert [frame["mirrored"] for frame in told["frames"]] == [True] * 3
