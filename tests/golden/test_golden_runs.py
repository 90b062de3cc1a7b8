"""Every golden run is as it was recorded. Where a change of results is meant: `python tests/golden/record.py`."""

from dataclasses import replace

import numpy as np
import pytest
from golden_runs import CLOSE, E_PER_RAD, RECORDING, RUNS, difference, play, read, write

OLD, SAME_ARITHMETIC = read()
MOST_BYTES = 100_000


@pytest.mark.parametrize("run", RUNS, ids=lambda run: run.name)
def test_a_run_is_as_it_was_recorded(run):
    found = difference(play(run), OLD[run.name])
    posture, E = (CLOSE, CLOSE) if SAME_ARITHMETIC else (run.elsewhere, E_PER_RAD * run.elsewhere)
    assert found.within(posture, E), f"{found}; if that is meant: python tests/golden/record.py"


def test_the_recording_is_small_and_holds_every_run():
    assert list(OLD) == [run.name for run in RUNS] and len(RUNS) == 20
    assert RECORDING.stat().st_size < MOST_BYTES
    assert all(run.why for run in RUNS if run.elsewhere > 1e-5 or run.most < 60)


def test_what_is_written_is_read_and_written_again_alike(tmp_path):
    write(OLD, tmp_path / "one.npz")
    again, same = read(tmp_path / "one.npz")
    write(again, tmp_path / "other.npz")
    assert same and (tmp_path / "one.npz").read_bytes() == (tmp_path / "other.npz").read_bytes()
    assert all(difference(again[name], OLD[name]).within(0.0, 0.0) for name in OLD)


def test_a_difference_in_anything_recorded_is_noticed():
    one = OLD["noise 0.5 px, 25 frames"]
    status, E, commanded = one.status.copy(), one.E.copy(), one.commanded.copy()
    status[3], E[4], commanded[5, 1] = "too-few-points", np.nan, commanded[5, 1] + 2 * CLOSE
    shorter = replace(one, status=one.status[:-1], E=one.E[:-1], commanded=one.commanded[:-1])
    others = [replace(one, status=status), replace(one, E=E), replace(one, commanded=commanded), shorter]
    others += [replace(one, E=one.E * (1 + 2 * CLOSE) + 2 * CLOSE)]
    others += [replace(one, expected_error=value) for value in (np.nan, one.expected_error + 2 * CLOSE)]
    assert difference(one, one).within(0.0, 0.0)
    assert not any(difference(other, one).within(CLOSE, CLOSE) for other in others)
    assert not any(difference(one, other).within(CLOSE, CLOSE) for other in others)
