"""Arms with mass sag, obey and repeat themselves; without PyBullet a line says what can be done."""

import importlib.util

import numpy as np
import pytest

from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.simulation import arms
from viewimit.simulation.scene import load_scene

needed = pytest.mark.skipif(importlib.util.find_spec("pybullet") is None, reason="no PyBullet")
GOAL = np.radians([45.0, -90.0])


@needed
def test_an_arm_sags_and_obeys_and_repeats_itself():
    arm, start = arms.open_arm("pybullet", load_scene("panda")), np.radians([25.0, -25.0])
    drive = lambda theta, commanded: arm.drive((), start, theta, theta, commanded)
    reached = drive(start, GOAL)
    sag = np.degrees(reached - GOAL)
    assert 0.02 < np.abs(sag).max() < 0.5 and sag[0] > 0  # joint 2 leans forwards
    np.testing.assert_array_equal(drive(start, GOAL), reached)
    np.testing.assert_allclose(drive(np.radians([80.0, -150.0]), GOAL), reached, atol=np.radians(0.01))
    np.testing.assert_allclose(drive(reached, GOAL), reached, atol=np.radians(0.01))
    np.testing.assert_allclose(arm.settle(GOAL), reached, atol=np.radians(0.01))


@needed
@pytest.mark.parametrize("sensor", ["projected", "rendered"])
def test_an_arm_with_mass_is_not_where_it_was_told_to_be(sensor):
    session = Session(Settings(sensor=sensor, dynamics="pybullet"))
    assert session.step()
    away = np.degrees(np.abs(session.snapshot.theta - session.snapshot.commanded))
    assert 0.01 < away.max() < 0.5


@pytest.mark.parametrize("has_wheel", [True, False])
def test_without_pybullet_a_line_says_what_can_be_done(ask, monkeypatch, has_wheel):
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "pybullet" else find(name))
    monkeypatch.setattr(arms, "pybullet_has_wheel", lambda: has_wheel)
    status, _, err = ask("imitate", "--dynamics", "pybullet")
    assert status == 2 and err.count("\n") == 1 and "--dynamics: arms with mass need PyBullet" in err
    assert "pip install 'viewimit[pybullet]'" in err
    assert ("wheels only for CPython 3.10 and 3.11 on Linux x86-64" in err) == (not has_wheel)
