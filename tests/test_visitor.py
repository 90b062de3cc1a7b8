"""What a browser may send, carried out or refused; nothing is lost by a refusal."""

import numpy as np
import pytest
from viewimit.app.controls import SERVO_NAMES, TRANSFER_NAMES, Inbox
from viewimit.app.pace import Pace
from viewimit.app.presets import AS_STARTED, PRESETS, presets_from
from viewimit.app.visitor import View, Visitor

from viewimit.posing import hand_position
from viewimit.servo import SERVOS
from viewimit.session import Session
from viewimit.snapshot import Settings
from viewimit.transfer import TRANSFERS


class QuietControls:
    """Takes what would be shown."""

    def __getattr__(self, name):
        return lambda *args: None


@pytest.fixture
def page():
    session = Session(Settings(start_deg=(25, -25)))
    pace, view, drawn = Pace(session), View(), []
    visitor = Visitor(
        session, pace, QuietControls(), view, presets_from(Settings(seed=99)), lambda: drawn.append("world"), {}
    )
    return session, pace, view, visitor, drawn


HOSTILE = [np.nan, np.inf, "1e9x", None, [1, 2], {"a": 1}, "<script>"]


@pytest.mark.parametrize("name", ["joint0", "joint1", "noise_px", "missing", "seed", "history", "chosen"])
@pytest.mark.parametrize("value", HOSTILE, ids=str)
def test_values_that_are_no_numbers_are_refused_and_change_nothing(page, name, value):
    session, _, view, visitor, _ = page
    before, chosen = session.snapshot, view.chosen
    with pytest.raises(ValueError):
        visitor.set(name, value)
    assert session.snapshot is before and view.chosen == chosen


@pytest.mark.parametrize(
    "name, value",
    [
        ("joint0", 1e9),
        ("joint1", 1.0),
        ("noise_px", -1),
        ("missing", 101),
        ("seed", -3),
        ("points", "7 points"),
        ("chosen", 10),
        ("chosen", -1),
        ("transfer", "best"),
        ("servo", ["broyden"]),
        ("speed", "warp"),
        ("preset", "none such"),
    ],
)
def test_values_out_of_range_are_refused_and_change_nothing(page, name, value):
    session, _, _, visitor, _ = page
    before = session.snapshot
    with pytest.raises(ValueError):
        visitor.set(name, value)
    assert session.snapshot is before


def test_every_transfer_and_servo_has_a_name_on_the_page():
    assert list(TRANSFER_NAMES) == list(TRANSFERS) and list(SERVO_NAMES) == list(SERVOS)


@pytest.mark.parametrize("preset", PRESETS, ids=lambda preset: preset.name)
def test_every_preset_begins_and_moves_or_says_why_not(page, preset):
    session, pace, _, visitor, drawn = page
    visitor.set("preset", preset.name)
    assert drawn and session.snapshot.motion == 0 and pace.speed == preset.motions_per_second
    moved = [session.step() for _ in range(6)]
    assert any(moved) or session.snapshot.status == "stopped"


def test_what_the_command_line_asked_for_is_a_preset_of_its_own(page):
    session, _, _, visitor, _ = page
    visitor.set("preset", PRESETS[1].name)
    visitor.set("preset", AS_STARTED)
    assert session.settings.seed == 99
    assert list(presets_from(PRESETS[2].settings)) == [PRESETS[2].name, *(p.name for p in PRESETS if p != PRESETS[2])]


def test_joints_move_the_demonstrator_alone(page):
    session, _, _, visitor, _ = page
    theta = session.snapshot.theta
    visitor.set("joint0", 60)
    assert np.allclose(np.degrees(session.snapshot.theta_demo), [60, -90])
    assert np.array_equal(session.snapshot.theta, theta) and session.snapshot.motion == 0


def test_a_resting_loop_wakes_when_the_demonstrator_moves(page):
    session, pace, _, visitor, _ = page
    pace.toggle()
    pace.speed = 0
    for now in range(200):
        pace.advance(float(now))
    rested = session.snapshot
    pace.advance(300.0)
    assert session.snapshot is rested and rested.status in ("converged", "stalled")
    visitor.set("joint0", 70)
    for now in range(400, 600):
        pace.advance(float(now))
    assert session.snapshot.motion > rested.motion
    assert np.abs(np.degrees(session.snapshot.theta - session.snapshot.theta_demo)).max() < 5


def test_the_hand_is_followed_to_where_the_joints_can_bring_it(page):
    session, _, _, visitor, _ = page
    world = session.world
    posture = np.radians([62.0, -71.0])
    target = hand_position(world, posture, world.T_world_demo)
    visitor.set("hand", target)
    assert np.allclose(np.degrees(session.snapshot.theta_demo), [62, -71], atol=0.1)


def test_scrubbing_beyond_the_history_keeps_the_present(page):
    session, _, _, visitor, _ = page
    session.step()
    visitor.set("history", 99)
    assert session.cursor == 1
    visitor.set("history", 0)
    assert session.cursor == 0 and len(session.history) == 2


def test_motions_are_seen_on_their_way(page):
    session, pace, _, visitor, _ = page
    start = session.snapshot.theta
    visitor.act("step", 10.0)
    halfway, moving = pace.theta(10.0 + 0.225)
    assert moving and np.allclose(halfway, (start + session.snapshot.theta) / 2)
    there, moving = pace.theta(11.0)
    assert not moving and np.array_equal(there, session.snapshot.theta)


def test_the_inbox_keeps_the_newest_value_and_the_order_of_actions():
    inbox = Inbox()
    for value in range(1000):
        inbox.put("joint0", value)
        inbox.act("step")
    inbox.put("joint1", -3)
    values, actions = inbox.take()
    assert values == {"joint0": 999, "joint1": -3} and 1 <= len(actions) <= 200
    assert inbox.take() == ({}, [])


def test_reset_keeps_the_world_and_its_drawings(page):
    session, _, _, visitor, drawn = page
    world = session.world
    session.step()
    visitor.act("reset", 0.0)
    assert session.snapshot.motion == 0 and session.world is world and not drawn


@pytest.mark.parametrize("speed", [0.5, 4.0])
def test_motions_keep_their_distance_in_time(page, speed):
    session, pace, _, _, _ = page
    pace.toggle()
    pace.speed = speed
    motions = []
    for tick in range(100):
        before = session.snapshot.motion
        pace.advance(0.05 * tick + 7.0)
        if session.snapshot.motion > before:
            motions.append(0.05 * tick)
    assert len(motions) >= 3 and np.diff(motions) == pytest.approx(1 / speed, abs=0.051)
