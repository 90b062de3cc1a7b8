"""Names of earlier versions: each is still read, with a warning that gives the new one."""

import base64

import msgspec
import numpy as np
import pytest
import zstandard
from viewimit.app.lab.lessons.format import settings_of
from viewimit.app.lab.lessons.source import shipped
from viewimit.app.sessions.link import decode

from viewimit import Session, Settings
from viewimit.loop.self_calibration import SelfCalibration
from viewimit.loop.settings import FIELDS, option
from viewimit.sensing import renamed

VALUES = {"camera": ("points", "projected"), "quantum_deg": (0.5, 0.5)}  # by the old field: its value then and now


def test_every_old_name_has_a_new_one_that_exists():
    assert set(VALUES) == set(renamed.SETTINGS) and set(renamed.SETTINGS.values()) <= set(FIELDS)
    assert not set(renamed.SETTINGS) & set(FIELDS)
    assert not set(renamed.OPTIONS) & {option(name) for name in FIELDS}


def settings_in_a_link(**fields):
    script = {"settings": fields, "deeds": [["c", fields], ["b", fields]]}
    packed = zstandard.compress(msgspec.msgpack.encode({"script": script}))
    found = decode("1" + base64.urlsafe_b64encode(packed).decode().rstrip("="), Settings()).scripts[0]
    assert found.actions[1].settings == found.settings and found.actions[0].fields.keys() == set(new_fields(fields))
    return found.settings


def new_fields(fields):
    return [renamed.SETTINGS[name] for name in fields]


def changed(**fields):
    session = Session(Settings.paper())
    session.change(**fields)
    return session.settings


def in_a_lesson(**fields):
    lesson = shipped()["ray"]
    return settings_of(lesson, msgspec.structs.replace(lesson.step[0], settings=fields))


READERS = {
    "Settings": Settings,
    "Settings.paper": Settings.paper,
    "Session.change": changed,
    "a lesson": in_a_lesson,
    "a link": settings_in_a_link,
}


@pytest.mark.parametrize("old", VALUES)
@pytest.mark.parametrize("reader", READERS)
def test_an_old_field_is_read_with_a_warning(reader, old):
    (then, now), new = VALUES[old], renamed.SETTINGS[old]
    with pytest.warns(FutureWarning, match=f"{old} is now called {new}"):
        settings = READERS[reader](**{old: then})
    assert getattr(settings, new) == now
    with pytest.warns(FutureWarning, match=f"{old} is now called {new}"):
        assert getattr(settings, old) == now


def test_a_name_that_never_was_is_refused_as_ever():
    with pytest.raises(TypeError, match="seeed"):
        Settings(seeed=1)
    with pytest.raises(AttributeError, match="seeed"):
        Settings().seeed  # noqa: B018


@pytest.mark.parametrize("old, value", [("--camera", "points"), ("--points", 16), ("--quantum-deg", 0.5)])
@pytest.mark.parametrize("joined", [True, False], ids=["with =", "apart"])
def test_an_old_option_is_read_with_a_line_of_warning(ask, old, value, joined):
    new, now = renamed.OPTIONS[old], {"points": "projected"}.get(value, value)
    words = ("imitate", "--max-motions", 1)
    status, out, err = ask(*words, *([f"{old}={value}"] if joined else [old, value]))
    assert f"viewimit imitate: {old} is now called {new}; the old name will be gone\n" in err
    assert (status, out) == ask(*words, new, now)[:2]


def test_a_calibration_of_an_earlier_version_is_read(tmp_path):
    session = Session(Settings())
    kept = session.calibrate(4, seed=0)
    kept.save(tmp_path / "new.npz")
    table = dict(np.load(tmp_path / "new.npz"))
    del table["sensor"]
    np.savez(tmp_path / "old.npz", camera="points", **table)
    with pytest.warns(FutureWarning, match="camera is now called sensor"):
        old = SelfCalibration.load(tmp_path / "old.npz")
    assert old.body == kept.body
    session.use_calibration(old)
