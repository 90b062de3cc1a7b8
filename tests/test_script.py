"""What is remembered of a session leads another to the same moment, to the last bit, whatever was done to it."""

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from viewimit.loop.script import MAX_ACTIONS, Action, Log, MoveDemonstrator, Script, Steps
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.loop.snapshot import Snapshot

replace = msgspec.structs.replace
LOSSY = Settings.paper(points=16, missing=0.3, transfer="linear", start_deg=(25, -45))


def same(one: Snapshot, other: Snapshot) -> None:
    """What is seen, commanded and remembered, bit by bit."""
    assert one.settings == other.settings and (one.motion, one.look) == (other.motion, other.look)
    for name in ("theta", "theta_demo", "commanded", "moved"):
        assert getattr(one, name).tobytes() == getattr(other, name).tobytes(), name
    assert np.array_equal(one.E, other.E, equal_nan=True) and one.status == other.status
    assert one.views.own.tobytes() == other.views.own.tobytes()


def again(session: Session) -> Session:
    """Another session, by what is written of the first one's script."""
    script = msgspec.msgpack.decode(msgspec.msgpack.encode(session.script), type=Script)
    other = Session(Settings.paper(servo="gradient"))
    other.play(script)
    return other


ACTIONS = st.lists(
    st.one_of(
        st.tuples(st.just("step"), st.integers(1, 4)),
        st.tuples(st.just("pose"), st.tuples(st.floats(0.1, 1.4), st.floats(-2.9, -0.2))),
        st.tuples(
            st.just("change"),
            st.sampled_from([{"noise_px": 0.4}, {"servo": "broyden"}, {"servo": "trust-region"}, {"frames": 3},
                             {"transfer": "linear"}, {"start_deg": (30.0123456789012, -40.0)}, {"missing": 0.3}]),
        ),
        st.tuples(st.just("scrub"), st.integers(0, 6)),
        st.tuples(st.just("look"), st.integers(1, 2)),
        st.tuples(st.just("reset"), st.just(0)),
        st.tuples(st.just("rehearse"), st.integers(4, 5)),
        st.tuples(st.just("forget"), st.just(0)),
    ),
    max_size=9,
)  # fmt: skip


@settings(max_examples=40, deadline=None)
@given(ACTIONS, st.sampled_from([Settings.paper(), Settings(), LOSSY]))
def test_whatever_is_done_is_done_again_to_the_last_bit(actions, begun):
    session = Session(begun)
    for kind, value in actions:
        if kind == "step":
            for _ in range(value):
                session.step()
        elif kind == "pose":
            session.pose(value)
        elif kind == "change":
            session.change(**value)
        elif kind == "scrub":
            session.scrub(value)
        elif kind == "look":
            for _ in range(value):
                session.look()
        elif kind == "reset":
            session.reset()
        elif kind == "rehearse":
            session.begin_calibration(session.calibration_postures(value, seed=1))
        else:
            session.use_calibration(None)
    other = again(session)
    same(session.snapshot, other.snapshot)
    for _ in range(3):  # and they go on alike
        assert session.step() == other.step()
        same(session.snapshot, other.snapshot)


@pytest.mark.parametrize("seed", range(8))
def test_settings_tell_of_postures_to_the_last_bit(seed):
    """However many digits these were given with, and at limits that have no end in degrees, too."""
    rng = np.random.default_rng(seed)
    low, high = np.array([[0.0, -180.0], [90.0, 0.0]])
    session = Session(
        Settings.paper(start_deg=rng.uniform(low, high), demonstrator_deg=rng.uniform(low, high), noise_px=0.5)
    )
    same(session.snapshot, Session(session.settings).snapshot)
    session.pose(np.radians(rng.uniform(low, high)))
    posed = session.snapshot.theta_demo
    same(session.snapshot, Session(session.settings).snapshot)
    session.change(transfer="linear")
    assert session.snapshot.theta_demo.tobytes() == posed.tobytes()
    of_all = Session(replace(session.settings, joints=tuple(range(1, 8)), start_deg=None, demonstrator_deg=None))
    of_all.pose(of_all.embodiment.upper)
    same(of_all.snapshot, Session(of_all.settings).snapshot)


def test_a_moment_at_which_the_arm_was_held_until_enough_was_seen_is_led_to():
    session = Session(LOSSY)
    held = 0
    while held < 3:
        before, motion = session.snapshot, session.snapshot.motion
        moved = session.step()
        if before.transfer is None and moved:
            held += 1
            session.scrub(motion)
            same(session.snapshot, again(session).snapshot)
            session.step()


@pytest.mark.parametrize("servo", ["broyden", "trust-region"])
def test_an_arm_held_that_goes_on_by_what_its_servo_knows_is_led_on(servo):
    """From where too few points are in sight still, after one look more."""
    session = Session(LOSSY)
    session.step()
    session.change(servo=servo)
    for _ in range(6):
        session.step()
        other = again(session)
        same(session.snapshot, other.snapshot)
    session.scrub(session.cursor - 1)
    same(session.snapshot, again(session).snapshot)


def test_motions_in_a_row_are_said_in_one_word():
    session = Session(Settings())
    session.run(40)
    session.step()  # at rest
    motions = session.snapshot.motion
    assert session.script.actions == (Steps(motions), Steps(2))
    session.scrub(2)
    assert session.script.actions == (Steps(2),)


def test_what_came_after_a_moment_that_is_changed_is_forgotten():
    session = Session(Settings())
    for _ in range(4):
        session.step()
    session.pose((0.5, -1.0))
    session.scrub(2)
    assert session.script.actions == (Steps(2),)
    session.step()
    session.scrub(3)
    assert session.script.actions == (Steps(3),)


def test_what_no_script_can_say_is_said_to_be_unknown_until_it_is_undone():
    session = Session(Settings())
    session.begin_calibration(session.calibration_postures(4, seed=1))
    for _ in range(4):
        session.step()
    other = Session(Settings())
    other.step()
    other.use_calibration(session.snapshot.calibration)
    with pytest.raises(ValueError, match="cannot be said"):
        _ = other.script
    other.reset()
    with pytest.raises(ValueError, match="cannot be said"):
        _ = other.script
    other.use_calibration(None)
    other.reset()
    assert other.script.actions == ()


def test_more_than_is_remembered_is_lost_and_no_memory_grows():
    log = Log(Script(Settings.paper()))
    for k in range(MAX_ACTIONS + 10):
        log.note(k // 10, MoveDemonstrator((0.1 * (k % 10), -1.0)))
    assert sum(map(len, log.actions.values())) == MAX_ACTIONS
    assert len(log.script(3).actions) == 43
    with pytest.raises(ValueError, match="cannot be said"):
        log.script(MAX_ACTIONS)


def test_a_script_that_cannot_be_played_says_why():
    with pytest.raises(ValueError, match="servo"):
        Session(Settings.paper()).do(msgspec.convert(["c", {"servo": "magic"}], type=Action))
    with pytest.raises(ValueError, match="demonstrator"):
        Session(Settings.paper()).do(MoveDemonstrator((9.0, 9.0)))
