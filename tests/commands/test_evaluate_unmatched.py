"""`evaluate --unmatched` names tracked points by several postures of the learner's own body, or by a rehearsal."""

import numpy as np
import pytest

from viewimit.estimation.views import VIEWS
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World

POINTS, NOISE_PX = 16, 0.05
POSTURES_DEG = np.array([[30, -60], [45, -60], [45, -75], [60, -100], [20, -110], [70, -40]], float)
SHOWN_DEG = np.array([55.0, -85.0])  # none of the learner's own postures
ORDER = np.random.default_rng(3).permutation(POINTS)  # of the demonstrator's points
LETTERS = [chr(ord("a") + k) for k in range(POINTS)]


@pytest.fixture
def tracks(tmp_path):
    """A table of points, the demonstrator's by letter and the learner's by number, and the postures beside it."""
    world, rng = World(load_scene("panda"), POINTS), np.random.default_rng(4)

    def write(demo_points=ORDER, own_names=lambda k: k):
        lines = ["frame,view,point,x,y"]
        demo = world.demo_images(np.radians(SHOWN_DEG))[0] + NOISE_PX * rng.standard_normal((POINTS, 4))
        for frame, posture in enumerate(np.radians(POSTURES_DEG)):
            own = world.own_images(posture)[0] + NOISE_PX * rng.standard_normal((POINTS, 4))
            for view, image in zip(VIEWS, (demo[:, :2], demo[:, 2:], own[:, :2], own[:, 2:])):
                if view in "lr":
                    lines += [
                        f"{frame},{view},{LETTERS[k]},{x!r},{y!r}"
                        for k, (x, y) in enumerate(image[demo_points].tolist())
                    ]
                else:
                    lines += [f"{frame},{view},{own_names(k)},{x!r},{y!r}" for k, (x, y) in enumerate(image.tolist())]
        (tmp_path / "tracks.csv").write_text("\n".join(lines) + "\n")
        angles = [f"{k},{low:g},{high:g}" for k, (low, high) in enumerate(POSTURES_DEG)]
        (tmp_path / "angles.csv").write_text("\n".join(["frame,theta2,theta4", *angles]) + "\n")
        return tmp_path / "tracks.csv", tmp_path / "angles.csv"

    return write


def test_several_postures_of_the_own_body_name_the_points_and_say_the_posture(ask, ask_json, tracks):
    path, angles = tracks()
    status, said = ask_json("evaluate", path, "--unmatched", "--postures", angles)
    found = said["naming"]
    assert status == 0 and found["accepted"] and not found["two_answers"] and all(found["certain"].values())
    assert [found["names"][str(k)] for k in range(POINTS)] == [LETTERS[j] for j in np.argsort(ORDER)]
    np.testing.assert_allclose(found["posture_deg"], SHOWN_DEG, atol=0.5)
    assert "degrees_per_unit" not in said
    assert said["points"] == [str(k) for k in range(POINTS)] and found["without_partner"] == {
        "learner": [],
        "demonstrator": [],
    }
    status, out, _ = ask("evaluate", path, "--unmatched", "--postures", angles)
    assert status == 0 and f"names: {POINTS} points named\n" in out and f"0 = {found['names']['0']}, " in out


def test_a_rehearsal_serves_as_well(ask, ask_json, tracks, tmp_path):
    path, _ = tracks()
    body = tmp_path / "body.npz"
    ask("rehearse", "--n-points", POINTS, "--noise-px", NOISE_PX, "--out", body)
    status, said = ask_json("evaluate", path, "--unmatched", "--calibration", body)
    assert status == 0 and [said["naming"]["names"][str(k)] for k in range(POINTS)] == [
        LETTERS[j] for j in np.argsort(ORDER)
    ]
    low = np.array(load_scene("panda").range_deg)[:, 0]
    np.testing.assert_allclose(said["naming"]["posture_deg"] + low, SHOWN_DEG, atol=0.5)  # from the lower limits


def test_what_it_needs_is_said(ask, tracks, tmp_path):
    path, angles = tracks()
    for words, options in (
        ("--unmatched: needs --calibration FILE", ["--unmatched"]),
        ("both show the learner's body", ["--postures", angles, "--calibration", angles]),
    ):
        status, _, error = ask("evaluate", path, *options)
        assert status == 2 and words in error
    few = tmp_path / "few.csv"
    few.write_text("frame,theta2\n0,10\n1,20\n")
    status, _, error = ask("evaluate", path, "--unmatched", "--postures", few)
    assert status == 2 and "joint angles of 2 frames; needs 3" in error
    few.write_text("theta2\n10\n")
    status, _, error = ask("evaluate", path, "--unmatched", "--postures", few)
    assert status == 2 and "the heading must be frame" in error
    for cells, words in (
        ("{k},10,10\n", "theta2, theta4: the same in all frames"),
        ("{k},{k},{1}\n", "6 poses do not show how the joints move points: turn each joint alone"),
    ):
        few.write_text("frame,theta2,theta4\n" + "".join(cells.format(k, k * k % 5, k=k) for k in range(6)))
        status, _, error = ask("evaluate", path, "--unmatched", "--postures", few)
        assert status == 2 and words in error
    lines = angles.read_text().splitlines()
    few.write_text("".join(f"{line},{k * k % 7 if k else 'jaw'}\n" for k, line in enumerate(lines)))
    assert "joint 3 turns no point: leave its column out" in ask("evaluate", path, "--unmatched", "--postures", few)[2]
