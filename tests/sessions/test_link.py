"""A link leads to the same moment to the last bit; what is not one is refused in a line, and costs nothing."""

import base64
import random
import re

import msgspec
import pytest
import zstandard
from hypothesis import given
from hypothesis import strategies as st
from viewimit.app.model.choices import PRESETS
from viewimit.app.sessions import link
from viewimit.app.sessions.link import Branch, Run, SavedPage, decode, encode_link, files_named

from viewimit.loop.script import Begin, Calibrate, ChangeSettings, MoveDemonstrator, Script, Steps
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.simulation.scene import load_scene

BY_POINTS = [preset for preset in PRESETS if preset.settings.sensor == "projected"]


def packed(fields) -> str:
    """A link of format 1."""
    return "1" + block(fields)


def block(content) -> str:
    data = zstandard.compress(msgspec.msgpack.encode(content))
    return base64.urlsafe_b64encode(data).decode().rstrip("=")


def page_of(script: Script, **fields) -> SavedPage:
    """What a link to the end of a script holds."""
    run = Run(script=script, cursor=script.steps)
    branch = {name: fields.pop(name) for name in ("preset", "speed") if name in fields}
    return SavedPage(present=Branch(runs=(run,), **branch), settings=script.settings, commanded=(0.5, -1.0), **fields)


@pytest.mark.parametrize("preset", BY_POINTS, ids=lambda preset: preset.name)
def test_a_link_leads_to_the_same_moment(preset):
    session = Session(preset.settings)
    session.run(6)
    session.pose(session.snapshot.theta_demo * 0.98)
    session.run(8)
    linked = page_of(session.script, preset=preset.name, chosen=2, show={"rays": True})
    text = encode_link(linked)
    assert len(text) < 700 and re.fullmatch(r"[\w.-]+", text, re.ASCII)
    found = decode(text, Settings.paper())
    assert found == linked
    other = Session(Settings.paper())
    other.play(found.present.runs[0].script)
    assert other.snapshot.theta.tobytes() == session.snapshot.theta.tobytes()
    assert other.snapshot.E == session.snapshot.E and other.settings == session.settings


def test_the_longest_that_is_usual_is_short_enough():
    session = Session(Settings())
    session.begin_calibration(session.calibration_postures(20, seed=3))
    for k in range(40):
        session.step()
        session.pose((0.5 + 0.01 * k, -1.0 - 0.003 * k))
    assert len(encode_link(page_of(session.script))) < link.MAX_LINK


def test_too_much_is_said_to_be_too_much():
    rng = random.Random(1)
    actions = tuple(MoveDemonstrator((rng.random(), rng.random())) for _ in range(500))
    with pytest.raises(ValueError, match="too much was done for a link"):
        encode_link(page_of(Script(Settings(), actions)))


BYTES = st.binary(max_size=300).map(lambda data: "1" + base64.urlsafe_b64encode(data).decode())


@given(st.text(max_size=300) | BYTES)
def test_what_is_no_link_is_refused(text):
    with pytest.raises(ValueError, match="the link"):
        decode(text, Settings.paper())


def script(settings=None, *actions) -> dict:
    return {"script": {"settings": settings or {}, "deeds": list(actions)}}


def layout(count: int) -> str:
    return f"points.{count} = {[[1, 0.1, 0.1, 0.1 * k] for k in range(count)]}\n"


@pytest.mark.parametrize(
    ("fields", "says"),
    [
        (script({"scene": "/etc/passwd"}), "not here"),
        (script({"robot": "/root/x.urdf"}), "not here"),
        (script(None, ["c", {"scene": "../secret.toml"}]), "not here"),
        (script(None, ["b", {"scene": "../secret.toml"}]), "not here"),
        (script(None, ["s", -5]), "damaged"),
        (script(None, ["p", [float("nan"), 0.0]]), "no number"),
        (script(None, ["r", [[0.0, 0.0]] * 201]), "calibrates"),
        (script(None, ["c", {"servo": "magic"}]), "damaged"),
        (script(None, ["c", {"nothing": 1}]), "damaged"),
        (script({"transfer": "own"}), "only its author has"),
        (script(None, ["c", {"servo": "own"}]), "only its author has"),
        (script({"frames": 1000}), "averages"),
        (script({"body_points": [[2, 0.0, 0.0, 0.001 * k] for k in range(65)]}), "places"),
        (script({"noise_px": float("nan")}), "damaged"),
        (script({"scene": "extends = 'mine'\n"}), "no shipped scene"),
        (script({"scene": "extends = '../../secret'\n"}), "no shipped scene"),
        (script(None, ["c", {"scene": "extends = 'panda'\nrobot = '/root/x.urdf'\n"}]), "its robot"),
        (script(None, ["b", {"scene": "extends = 'panda'\nrobot = '../x'\n"}]), "its robot"),
        (script({"scene": "extends = 'panda'\nhead.focal = nan\n"}), "finite"),
        (script({"scene": "extends = 'panda'\nhead.image = [100000, 100000]\n"}), "image must be"),
        (script({"scene": "extends = 'panda'\nhead.baseline = 'wide'\n"}), "cannot be"),
        (script({"scene": f"extends = 'panda'\nx = {'[' * 9_000}\n"}), "cannot be"),
        (script({"scene": "x" * 100_000 + "\n"}), "characters"),
        (script({"scene": f"extends = 'panda'\npoints.65 = {[[1, 0.1, 0.1, 0.1]] * 65}\n"}), "points"),
        (script({"scene": "extends = 'panda'\n" + "\n".join(layout(k) for k in range(20, 40))}), "layouts"),
        (script({"scene": f"extends = 'panda'\ntitle = '{'x' * 201}'\n"}), "title"),
        (script({"scene": "extends = 'panda'\ntitle = \"\\u0001\"\n"}), "printed"),
        (script(None, *[["c", {"scene": f"extends = 'panda'\ntitle = '{k}'\n"}] for k in range(17)]), "scenes"),
        ({**script(), "speed": float("nan")}, "damaged"),
        ({**script(), "chosen": -1}, "damaged"),
        ({**script(), "lesson": ["x" * 1000, 0]}, "damaged"),
        ({**script(), "more": 1}, "damaged"),
        ([], "damaged"),
    ],
)
def test_hostile_links_are_refused_in_a_line(fields, says):
    with pytest.raises(ValueError, match=says) as refused:
        decode(packed(fields), Settings.paper())
    assert "\n" not in str(refused.value) and len(str(refused.value)) < 250


def test_a_small_link_that_unpacks_to_much_is_refused():
    text = "1" + base64.urlsafe_b64encode(zstandard.compress(bytes(1 << 24))).decode().rstrip("=")
    assert len(text) < link.MAX_LINK
    with pytest.raises(ValueError, match="damaged"):
        decode(text, Settings.paper())


def test_a_link_of_the_servers_own_scene_is_followed():
    begun = Settings.paper(scene="mine.toml")
    text = encode_link(
        page_of(Script(begun, (Steps(1), ChangeSettings({"noise_px": 0.5}), Calibrate(((0.1, 0.2),) * 4))))
    )
    assert decode(text, begun).settings == begun
    with pytest.raises(ValueError, match="not here"):
        decode(text, Settings.paper())


OWN = {
    "eyes": 'title = "Eyes apart"\nextends = "panda"\n[head]\nbaseline = 0.7654321012345678\n',
    "points": 'title = "Ten points"\nextends = "iiwa"\n[points]\n10 = '
    + str([[1 + k % 6, 0.1 / (k + 3), -0.2 / (k + 7), 0.01 * k] for k in range(10)]),
}


@pytest.mark.parametrize("name", OWN)
def test_a_link_of_ones_own_scene_opens_where_nobody_knows_it(name, tmp_path):
    """Its file is gone by then, and what was done in it, with others between, is done again to the last bit."""
    path = tmp_path / "mine.toml"
    path.write_text(OWN[name])
    session = Session(Settings.paper(scene="panda-toed"))
    session.begin(Settings.paper(scene=str(path)))
    session.run(3)
    session.change(scene="panda")
    session.step()
    session.change(scene=str(path), noise_px=0.25)
    session.run(4)
    linked = page_of(session.script)
    text = encode_link(linked)
    assert decode(text, Settings.paper(scene=str(path))) == linked  # where it is shown, it stays the file
    assert files_named(text) == [] and len(text) < 1_100  # with an origin, few enough for a QR code
    path.unlink()
    other = Session(Settings.paper())
    other.play(decode(text, Settings.paper(scene="iiwa")).present.runs[0].script)
    assert other.snapshot.theta.tobytes() == session.snapshot.theta.tobytes()
    assert other.snapshot.E == session.snapshot.E and other.world.scene == session.world.scene
    assert encode_link(page_of(other.script)) == text  # and is passed on


def test_scenes_that_no_link_can_hold_go_by_their_names(tmp_path):
    """With a robot of one's own, with more than a page is made to draw, with more than an address holds."""
    (tmp_path / "own.toml").write_text('extends = "panda"\nrobot = "arm.urdf"\n')
    (tmp_path / "arm.urdf").write_text('<robot name="arm"><link name="a"/></robot>')
    (tmp_path / "many.toml").write_text('extends = "panda"\n' + layout(65))
    rng, rows = random.Random(1), lambda n: [[1, rng.random(), rng.random(), rng.random()] for _ in range(n)]
    lines = "\n".join(f"points.{n} = {rows(n)}" for n in range(40, 45))
    (tmp_path / "long.toml").write_text(f'extends = "panda"\n{lines}\n')
    for name in ("own.toml", "many.toml", "long.toml"):
        begun = Settings.paper(scene=str(tmp_path / name))
        text = encode_link(page_of(Script(begun)))
        assert files_named(text) == [name] and decode(text, begun).settings == begun
        with pytest.raises(ValueError, match="not here"):
            decode(text, Settings.paper())
    assert load_scene(tmp_path / "long.toml").points["44"]  # nothing is wrong with it
    assert files_named(encode_link(page_of(Script(Settings.paper(robot="/x/arm.urdf"))))) == ["arm.urdf"]


def test_a_link_tells_no_folder_of_the_server():
    begun = Settings.paper(scene="/home/ada/my arms/arm.urdf", robot="C:\\arms\\arm 2.urdf")
    actions = (
        ChangeSettings({"scene": "panda", "robot": "iiwa"}),
        ChangeSettings({"scene": begun.scene, "robot": begun.robot}),
        Begin(begun),
    )
    linked = page_of(Script(begun, actions))
    text = encode_link(linked)
    plain = str(decode(text, begun.__class__(scene="arm.urdf", robot="arm 2.urdf")))
    assert "ada" not in plain and "arms" not in plain and "arm 2.urdf" in plain
    assert decode(text, begun) == linked
