"""The robustness table counts what happened, and the cases that are easy are met."""

import numpy as np
import pytest

from viewimit.experiments.bench import robustness
from viewimit.experiments.bench.benchmark import Context
from viewimit.experiments.bench.robustness import CASES, Case, run, run_once
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings

ALONE = Context.in_processes(1)


def test_every_case_can_be_set():
    for case in CASES:
        session = Session(Settings(**case.changes))
        assert np.isfinite(session.snapshot.E) or case.changes.get("missing")


@pytest.mark.parametrize("name", ["undisturbed", "gain error 5 %", "steps of 0.2°", "outliers 10%, 5 frames"])
def test_these_lose_nothing(name):
    (case,) = (case for case in CASES if case.name == name)
    (found,) = run(Settings(), [case], runs=12, seed=3, context=ALONE)
    assert found.ended[0.5].count == found.claimed.count == 12 and found.claimed_falsely.count == 0
    assert found.rms_deg < 0.3 and found.motions_95 <= 14


@pytest.mark.parametrize("noise_px", [0.25, 1.0])
@pytest.mark.parametrize("runs", [8, pytest.param(16, marks=pytest.mark.slow)])
def test_with_noise_the_error_is_the_one_expected(noise_px, runs):
    """Of two joints' errors, each normal, the larger is 0.5 to 2.2 standard deviations in 16 to 95 of 100 runs."""
    case = Case("noise", {"noise_px": noise_px, "frames": 25, "points": 16})
    (found,) = run(Settings(), [case], runs=runs, seed=2, context=ALONE)
    assert found.claimed.count == runs and found.claimed_falsely.count <= 1
    assert 0.5 < found.rms_deg / found.expected_deg < 2.2


def test_seven_joints_arrive():
    case = Case("seven", {"joints": robustness.SEVEN, "points": 16}, 30.0)
    (found,) = run(Settings(), [case], runs=3, seed=1, context=ALONE)
    assert found.ended[0.5].count == 3


def test_the_table_is_of_the_runs(monkeypatch):
    ended = iter([(0.1, 0.0, 5, True), (0.7, 0.2, 9, True), (2.0, 0.4, 80, False), (0.8, 0.4, 6, True)])
    monkeypatch.setattr(robustness, "run_once", lambda *_: next(ended))
    (found,) = run(Settings(), [Case("a", {})], runs=4, context=ALONE)
    assert found.rms_deg == pytest.approx(np.sqrt((0.01 + 0.49 + 4 + 0.64) / 4))
    assert found.expected_deg == pytest.approx(np.sqrt((0.04 + 0.16 + 0.16) / 4))
    assert found.claimed_rms_deg == pytest.approx(np.sqrt((0.01 + 0.49 + 0.64) / 3))
    assert [share.count for share in found.ended.values()] == [1, 3, 4]
    assert (found.claimed.count, found.claimed_falsely.count, found.motions_median) == (3, 1, 7.5)


def test_a_run_repeats_itself_and_gives_up_when_blind():
    settings = Settings(noise_px=0.5, frames=3)
    assert run_once(settings, CASES[0], [0, 1], 12) == run_once(settings, CASES[0], [0, 1], 12)
    blind = Settings(missing=1.0)
    error, expected, motions, claimed = run_once(blind, CASES[0], [0, 1], 12)
    assert motions == 0 and not claimed and expected == 0
