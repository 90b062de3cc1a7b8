"""A link leads to the same moment to the last bit; what is not one is refused in a line, and costs nothing."""

import base64
import random
import re

import msgspec
import pytest
import zstandard
from hypothesis import given
from hypothesis import strategies as st
from viewimit.app.control.presets import PRESETS
from viewimit.app.sessions import link
from viewimit.app.sessions.link import Linked, read, written

from viewimit.rehearsal import begin_rehearsal
from viewimit.script import Began, Changed, Posed, Rehearsed, Script, Stepped
from viewimit.script_player import play
from viewimit.session import Session
from viewimit.settings import BEST, Settings

BY_POINTS = [preset for preset in PRESETS if preset.settings.camera == "points"]


def packed(fields) -> str:
    data = zstandard.compress(msgspec.msgpack.encode(fields))
    return link.FORM + base64.urlsafe_b64encode(data).decode().rstrip("=")


@pytest.mark.parametrize("preset", BY_POINTS, ids=lambda preset: preset.name)
def test_a_link_leads_to_the_same_moment(preset):
    session = Session(preset.settings)
    session.run(6)
    session.pose(session.snapshot.theta_demo * 0.98)
    session.run(8)
    linked = Linked(script=session.script, preset=preset.name, chosen=2, show={"rays": True})
    text = written(linked)
    assert len(text) < 600 and re.fullmatch(r"[\w-]+", text, re.ASCII)
    found = read(text, Settings())
    assert found == linked
    other = Session()
    play(found.script, other)
    assert other.snapshot.theta.tobytes() == session.snapshot.theta.tobytes()
    assert other.snapshot.E == session.snapshot.E and other.settings == session.settings


def test_the_longest_that_is_usual_is_short_enough():
    session = Session(BEST)
    begin_rehearsal(session, 20, seed=3)
    for k in range(40):
        session.step()
        session.pose((0.5 + 0.01 * k, -1.0 - 0.003 * k))
    assert len(written(Linked(script=session.script))) < link.MOST_CHARS


def test_too_much_is_said_to_be_too_much():
    rng = random.Random(1)
    deeds = tuple(Posed((rng.random(), rng.random())) for _ in range(link.MOST_DEEDS))
    with pytest.raises(ValueError, match="too much was done for a link"):
        written(Linked(script=Script(BEST, deeds)))


BYTES = st.binary(max_size=300).map(lambda data: link.FORM + base64.urlsafe_b64encode(data).decode())


@given(st.text(max_size=300) | BYTES)
def test_what_is_no_link_is_refused(text):
    with pytest.raises(ValueError, match="the link"):
        read(text, Settings())


def script(settings=None, *deeds) -> dict:
    return {"script": {"settings": settings or {}, "deeds": list(deeds)}}


@pytest.mark.parametrize(
    ("fields", "says"),
    [
        (script({"scene": "/etc/passwd"}), "not here"),
        (script({"robot": "/root/x.urdf"}), "not here"),
        (script(None, ["c", {"scene": "../secret.toml"}]), "not here"),
        (script(None, ["b", {"scene": "../secret.toml"}]), "not here"),
        (script(None, ["s", 10**9]), "motions"),
        (script(None, *[["s", 1000]] * 4), "motions"),
        (script(None, ["s", -5]), "damaged"),
        (script(None, *[["f"]] * 501), "deeds"),
        (script(None, ["p", [float("nan"), 0.0]]), "no number"),
        (script(None, ["r", [[0.0, 0.0]] * 201]), "rehearses"),
        (script(None, ["c", {"servo": "magic"}]), "damaged"),
        (script(None, ["c", {"nothing": 1}]), "damaged"),
        (script({"frames": 1000}), "averages"),
        (script({"body_points": [[2, 0.0, 0.0, 0.001 * k] for k in range(65)]}), "places"),
        (script({"noise_px": float("nan")}), "damaged"),
        ({**script(), "speed": float("nan")}, "damaged"),
        ({**script(), "chosen": -1}, "damaged"),
        ({**script(), "lesson": ["x" * 1000, 0]}, "damaged"),
        ({**script(), "more": 1}, "damaged"),
        ([], "damaged"),
    ],
)
def test_hostile_links_are_refused_in_a_line(fields, says):
    with pytest.raises(ValueError, match=says) as refused:
        read(packed(fields), Settings())
    assert "\n" not in str(refused.value) and len(str(refused.value)) < 250


def test_a_small_link_that_unpacks_to_much_is_refused():
    text = link.FORM + base64.urlsafe_b64encode(zstandard.compress(bytes(1 << 24))).decode().rstrip("=")
    assert len(text) < link.MOST_CHARS
    with pytest.raises(ValueError, match="damaged"):
        read(text, Settings())


def test_a_link_of_the_servers_own_scene_is_followed():
    begun = Settings(scene="mine.toml")
    text = written(Linked(script=Script(begun, (Stepped(1), Changed({"noise_px": 0.5}), Rehearsed(((0.1, 0.2),) * 4)))))
    assert read(text, begun).script.settings == begun
    with pytest.raises(ValueError, match="not here"):
        read(text, Settings())


def test_a_link_tells_no_folder_of_the_server():
    begun = Settings(scene="/home/ada/my arms/arm.urdf", robot="C:\\arms\\arm 2.urdf")
    deeds = (
        Changed({"scene": "panda", "robot": "iiwa"}),
        Changed({"scene": begun.scene, "robot": begun.robot}),
        Began(begun),
    )
    linked = Linked(script=Script(begun, deeds))
    text = written(linked)
    plain = zstandard.decompress(base64.urlsafe_b64decode(text[1:] + "==="), 1 << 18)
    assert b"ada" not in plain and b"arms" not in plain and b"arm 2.urdf" in plain
    assert read(text, begun) == linked
