"""A history as bytes: what is resumed goes on to the last bit as what was never interrupted."""

import dataclasses
import pickle

import msgspec
import numpy as np
import pytest
import zstandard
from sameness import assert_same
from viewimit.app.sessions.codec import decode, encode

from viewimit.estimation.transfers import TRANSFERS
from viewimit.loop.history import EARLY, STRIDE
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.servo import SERVOS, ServoStatus


def run(session: Session, passes: int, seed: int) -> None:
    """Steps, and a demonstrator that moves now and then."""
    rng = np.random.default_rng(seed)
    for k in range(passes):
        session.step()
        if k % 7 > 4:
            session.pose(session.snapshot.theta_demo + np.radians(rng.normal(0, 1, 2)))


@pytest.mark.parametrize("transfer", TRANSFERS)
@pytest.mark.parametrize("servo", SERVOS)
def test_a_resumed_session_goes_on_as_if_nothing_had_been(transfer, servo):
    settings = Settings.paper(
        transfer=transfer, servo=servo, noise_px=0.2, missing=0.02, frames=3, gain_error=0.05, delay=1
    )
    kept = Session(settings)
    run(kept, 20, seed=1)
    resumed = Session(Settings.paper())
    resumed.resume(decode(encode(kept.history)), kept.cursor)
    for session in (kept, resumed):
        run(session, 12, seed=2)
    assert len(kept.history) > 10
    assert_same(tuple(kept.history), tuple(resumed.history))


def test_moments_that_stand_for_others_are_kept_once():
    settings = Settings.paper(servo="gradient-retuned", start_deg=(25, -45))
    whole, thinned = Session(settings), Session(settings, dense=STRIDE)
    for _ in range(EARLY + 3 * STRIDE):
        whole.step()
        thinned.step()
    old = slice(EARLY, EARLY + 2 * STRIDE)
    packed, back = encode(thinned.history[old]), decode(encode(thinned.history))
    assert len(packed) < len(encode(whole.history[old])) / 5
    assert_same(tuple(back), tuple(thinned.history))
    assert [back[EARLY + k] is back[EARLY] for k in (1, STRIDE - 1, STRIDE)] == [True, True, False]


def test_a_resumed_session_can_go_back_and_on_from_there():
    kept = Session(Settings.paper(noise_px=0.1))
    run(kept, 15, seed=1)
    resumed = Session(Settings.paper())
    resumed.resume(decode(encode(kept.history)), 4)
    kept.scrub(4)
    for session in (kept, resumed):
        session.step()
    assert_same(tuple(kept.history), tuple(resumed.history))


def test_what_snapshots_share_is_kept_once():
    session = Session(Settings.paper(transfer="projective", servo="trust-region", noise_px=0.2))
    run(session, 60, seed=1)
    assert len(encode(session.history)) < 3_000 * len(session.history)
    restored = decode(encode(session.history))
    assert restored[15].servo_state.visits[3] is restored[25].servo_state.visits[3]


def packed(*content) -> bytes:
    return zstandard.compress(msgspec.msgpack.encode(content))


def test_statuses_in_the_words_of_earlier_versions_are_read_in_todays():
    session = Session(Settings(points=5, start_deg=(25, -45)))
    session.run()
    objects, values = msgspec.msgpack.decode(
        zstandard.ZstdDecompressor().decompressobj().decompress(encode([session.snapshot]))
    )
    stored = [content[0] for _, *content in objects if isinstance(content[0], dict) and content[0].get("status")]
    assert len(stored) == 2  # the servo's state and the moment
    for one in stored:
        one["status"] = "untold"
    back = decode(packed(*(objects, values)))
    assert_same(back[0], session.snapshot)
    assert back[0].status is back[0].servo_state.status is ServoStatus.UNOBSERVABLE
    stored[1]["status"] = "busy"
    with pytest.raises(ValueError, match="busy"):
        decode(packed(*(objects, values)))


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"nothing",
        pickle.dumps([1]),
        packed(),
        packed([], [[0]]),
        packed([["array", "|O", [1], b"12345678"]], [[0]]),
        packed([["array", "<f8", [2], b"12345678"]], [[0]]),
        packed([["System", {}]], [[0]]),
        packed([["FourViews", {"demo": 1}]], [[0]]),
        packed([["settings", {"servo": "rm -rf"}]], [[0]]),
    ],
)
def test_what_was_not_encoded_here_is_refused(data):
    with pytest.raises(ValueError):
        decode(data)


def test_what_is_not_known_is_not_kept():
    odd = dataclasses.replace(Session(Settings.paper()).snapshot, servo_state=lambda: None)
    with pytest.raises(TypeError, match="cannot keep a function"):
        encode([odd])
