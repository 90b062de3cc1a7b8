"""The benchmark of misfits: its demonstrators, its counts, and the bound that estimates of another body are held to."""

import numpy as np
import pytest

from viewimit import Session, Settings
from viewimit.experiments.bench.benchmark import Context
from viewimit.experiments.bench.bound import bound
from viewimit.experiments.bench.misfits import (
    CASES,
    MisfitsBenchmark,
    OtherDemonstrator,
    Row,
    outcome,
    run_once,
    stretched,
)
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World

NOISY = {"noise_px": 0.25, "frames": 25, "points": 16}


def test_stretched_links_move_joints_apart_and_leave_points_at_their_places_on_the_links():
    scene, stretch = load_scene("panda"), np.array([0.1, -0.05])
    worlds = World(scene, 16), World(scene, 16, stretched(scene, World(scene, 16).robot, stretch))
    theta = np.array([0.4, -1.2])
    places = [world.points_world(theta, np.eye(4)) for world in worlds]
    joints = [world.link_frames(theta, np.eye(4))[np.array(scene.moving) + 1, :3, 3] for world in worlds]
    assert np.linalg.norm(joints[1][0]) == pytest.approx(1.1 * np.linalg.norm(joints[0][0]))
    links = [np.linalg.norm(one[1] - one[0]) for one in joints]
    assert links[1] == pytest.approx(0.95 * links[0])
    rigid = np.searchsorted(np.array(scene.moving) + 1, worlds[0].body.link, side="right")
    for group in range(3):
        apart = [np.linalg.norm(one[rigid == group][:, None] - one[rigid == group], axis=-1) for one in places]
        np.testing.assert_allclose(*apart, atol=1e-12)


@pytest.mark.parametrize("earlier_deg", [[], [(20, -40), (75, -110), (40, -140)]])
def test_another_bodys_expected_error_is_that_of_the_bound(earlier_deg):
    """Also where the demonstrator was seen in other postures before: all are adjusted together."""
    settings = Settings(start_deg=(20, -120), demonstrator_deg=(60, -60), seed=3, **NOISY)
    robot = lambda scene, points: stretched(scene, World(scene, points).robot, np.array([0.02, -0.04]))
    session = Session(settings, open_eyes=lambda camera, *scene: OtherDemonstrator(*scene, robot(*scene)))
    for demonstrator_deg in [*earlier_deg, (60, -60)]:
        session.pose(np.radians(demonstrator_deg))
        last = session.run(60).last
    visited, earlier = [moment.theta for moment in session.history], list(np.radians(earlier_deg))
    least = bound(session.world, last.theta_demo, 0.05, visited, another_body=True, earlier=earlier)
    alike = bound(session.world, last.theta_demo, 0.05, visited)
    assert (least > 0.5 * alike).all()
    np.testing.assert_allclose(last.certificate.std_error, least, rtol=0.2)
    if earlier_deg:
        alone = bound(session.world, last.theta_demo, 0.05, visited, another_body=True)
        assert (last.certificate.std_error < 0.8 * alone).all()


def test_a_word_counts_as_right_only_where_something_is_wrong():
    right = Row("one point elsewhere", "point", True, False, 0.5, 0.3, np.nan, 9)
    silent = Row("one point elsewhere", "", False, True, 0.1, 0.3, np.nan, 9)
    false = Row("one point elsewhere", "", False, True, 1.5, 0.3, np.nan, 9)
    case = next(case for case in CASES if case.name == "one point elsewhere")
    found = outcome(case, [right, silent, false])
    assert (found.noticed.count, found.right.count, found.right.runs) == (1, 1, 1)
    assert (found.claimed.count, found.false.count, found.covered.count) == (2, 1, 1)
    assert found.words == {"point": 1} and found.over_bound is None


def test_a_run_repeats_itself_and_is_kept_in_a_table(tmp_path):
    assert run_once("none", [0, 1]) == run_once("none", [0, 1])
    file = tmp_path / "rows.csv"
    found, text = MisfitsBenchmark(runs=1, case="none", csv=file).run(Context.in_processes(1))
    assert found[0]["claimed"]["count"] == 1 and "none" in text
    assert file.read_text().splitlines()[0].startswith("case,word,right,claimed")
