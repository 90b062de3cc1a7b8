"""Tracking: a path of constant speed, and errors of the best method and of the paper's law."""

import numpy as np
import pytest

from viewimit.experiments.bench import tracking
from viewimit.experiments.bench.benchmark import Context
from viewimit.experiments.bench.tracking import Case, path, run
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings

NOISY = Case("noise", Settings(noise_px=0.5), 1.0)
SETTINGS = [Settings.paper(), Settings.paper(joints=(2, 4, 6), points=16), Settings.paper(scene="iiwa")]


@pytest.mark.parametrize("settings", SETTINGS)
def test_the_fastest_joint_of_a_path_has_its_speed_and_none_leaves_its_limits(settings):
    session = Session(settings)
    theta = path(session, 2.0, np.random.default_rng(0))
    speed = np.degrees(np.abs(np.diff(theta, axis=0)).max(1))
    assert speed.max() < 2.01 and np.median(speed) == pytest.approx(2.0, abs=0.01)  # less where it turns round
    assert (theta >= session.scene.lower - 1e-12).all() and (theta <= session.scene.upper + 1e-12).all()


def test_one_degree_a_step_is_tracked_closely_and_the_papers_law_is_left_behind():
    """At most 0.3° rms is asked; a learner that only reacts is a step, 1°, behind."""
    cases = [Case("best", Settings(), 1.0), Case("paper", tracking.PAPER, 1.0)]
    best, paper = run(cases=cases, runs=1, seed=1, context=Context.in_processes(1))
    assert best.rms_deg < 0.3
    assert paper.rms_deg > 3


def test_behind_a_moving_demonstrator_seen_with_noise_the_transfer_is_kept(monkeypatch):
    """Fitted anew at every step it would add its own noise to that of the postures."""
    (kept,) = run(cases=[NOISY], points=16, runs=1, context=Context.in_processes(1))

    class Forgetful(Session):
        def step(self):
            moved = super().step()
            self.history.replace(self.snapshot.with_fields(converged_transfer=None))
            return moved

    monkeypatch.setattr(tracking, "Session", Forgetful)
    (anew,) = run(cases=[NOISY], points=16, runs=1, context=Context.in_processes(1))
    assert anew.rms_deg > 1.3 * kept.rms_deg
