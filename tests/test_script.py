"""What is remembered of a session leads another to the same moment, to the last bit, whatever was done to it."""

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from viewimit.loop.script import Action, MoveDemonstrator, Script
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.loop.snapshot import Snapshot

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
            st.sampled_from([{"noise_px": 0.4}, {"servo": "broyden"}, {"servo": "likelihood"}, {"frames": 3},
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


def test_a_script_that_cannot_be_played_says_why():
    with pytest.raises(ValueError, match="servo"):
        Session().play(Script(Settings.paper(), (msgspec.convert(["c", {"servo": "magic"}], type=Action),)))
    with pytest.raises(ValueError, match="demonstrator"):
        Session().play(Script(Settings.paper(), (MoveDemonstrator((9.0, 9.0)),)))
    with pytest.raises(TypeError, match="no action of a script: 'dance'"):
        Session().play(Script(Settings.paper(), ("dance",)))
