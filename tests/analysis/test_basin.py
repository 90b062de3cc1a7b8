"""From where a learner arrives: the runs are what sessions do, and each ends somewhere."""

import msgspec
import numpy as np
import pytest

from viewimit.analysis.convergence import MAX_MOTIONS, NEAR_DEG, find_basin, place_of, smallest_E, spread_starts
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.simulation.scene import load_scene

FEW = Settings.paper(points=5)


@pytest.mark.parametrize("scene", ["panda", "iiwa"])
def test_starts_are_spread_evenly_over_the_range(scene):
    scene = load_scene(scene)
    starts = spread_starts(scene)
    assert starts.shape == (20, 2) and len(np.unique(starts, axis=0)) == 20
    for joint, count in enumerate((4, 5)):
        values = np.unique(starts[:, joint])
        assert len(values) == count and np.allclose(np.diff(values), np.diff(values)[0])
        assert values[0] - scene.lower[joint] == pytest.approx(scene.upper[joint] - values[-1])


def test_every_run_is_a_sessions_own():
    told: list = []
    found = find_basin(FEW, lambda *news: told.append(news), (1, 2))
    for start, ending in zip(found.starts, found.endings):
        alone = Session(msgspec.structs.replace(FEW, start_deg=tuple(np.degrees(start).tolist())))
        last = alone.run(MAX_MOTIONS, patience=1).last
        assert np.array_equal(ending.start, start) and np.array_equal(ending.end, last.theta)
        assert ending.claimed is (last.status == "converged")
        assert ending.place == place_of(last.theta, last.theta_demo, smallest_E(alone))
    assert [share for share, _ in told] == [0.5, 1.0] and told[-1][1].endings == found.endings


def test_without_bias_all_arrive_and_say_so():
    found = find_basin(Settings(), counts=(2, 2))
    assert found.count("demonstrator", True) == 4 == len(found.endings)


def test_a_run_ends_at_the_demonstrator_at_the_smallest_E_or_elsewhere():
    demo, lowest = np.radians([45.0, -90.0]), np.radians([40.0, -88.0])
    near = np.radians(NEAR_DEG - 0.01)
    assert place_of(demo + near, demo, lowest) == place_of(demo, demo, demo) == "demonstrator"
    assert place_of(lowest + (near, -near), demo, lowest) == "smallest E"
    assert place_of(demo + np.radians([0, NEAR_DEG + 0.01]), demo, lowest) == "elsewhere"
    assert place_of(lowest, demo, np.full(2, np.nan)) == "elsewhere"
