"""What comes from elsewhere is read as if the worst had written it."""

import math

import msgspec
import pytest
from viewimit.app.classroom.messages import (
    MOST_BYTES,
    MOST_NAME,
    MOST_PATH,
    Answer,
    Copy,
    Orders,
    Roster,
    Round,
    Summary,
    decode,
    encode,
)
from viewimit.app.control.classroom.summaries import name_of
from viewimit.app.panels.classroom.lecturer import tile_of

from viewimit.drawing.classroom.tile import draw_tile

ID = "0123456789abcdef"
SUMMARY = Summary(id=ID, name="Mira", state="moving", E=1.5, off=2.0, motions=3, path=(1, 2, 3, 4), demo=(5, 6))


def built(**fields):
    return msgspec.msgpack.encode({"students": [{"id": ID, **fields}]})


def test_what_was_told_is_read():
    orders = Orders(leader=ID, frozen=True, rounds=(Round(number=1, lesson="1-tour", step="eyes"),))
    for message in (Roster(students=(SUMMARY,)), orders, Answer(choice=1), Copy(text="1abc")):
        assert decode(type(message), encode(message)) == message
    assert decode(Roster, built()) == Roster(students=(Summary(id=ID),))


HOSTILE = {
    "an id that is markup": {"id": "<script>abcdefgh"},
    "a long name": {"name": "n" * (MOST_NAME + 1)},
    "a state of its own": {"state": "<b>"},
    "E below nothing": {"E": -1.0},
    "E that is no number": {"E": math.nan},
    "an endless E": {"E": math.inf},
    "a long path": {"path": [0] * (2 * MOST_PATH + 2)},
    "a path of words": {"path": ["<svg>"]},
    "angles without bounds": {"path": [10**9, 0]},
    "a large picture": {"hills": b"x" * 5_000},
    "another field": {"html": "<img>"},
    "a lesson that is long": {"lesson": ["l" * 81, 1, 2]},
    "counts below nothing": {"motions": -1},
}


@pytest.mark.parametrize("what", HOSTILE)
def test_what_no_page_tells_is_refused(what):
    with pytest.raises(ValueError, match="no Roster"):
        decode(Roster, built(**HOSTILE[what]))


@pytest.mark.parametrize("data", [b"", b"\xc1", b"\xff" * 50, b"\x81" * 5_000, b"\xa1\xff", b"{}"])
def test_bytes_that_are_no_message_are_refused(data):
    for kind in (Roster, Orders, Answer, Copy):
        with pytest.raises(ValueError):
            decode(kind, data)


def test_what_is_too_large_or_of_another_version_is_refused():
    with pytest.raises(ValueError, match="bytes"):
        decode(Answer, b"\x00" * (MOST_BYTES[Answer] + 1))
    with pytest.raises(ValueError, match="version"):
        decode(Answer, msgspec.msgpack.encode({"choice": 1, "version": 2}))
    with pytest.raises(ValueError):
        decode(Answer, msgspec.msgpack.encode({"place": [math.nan, 1.0]}))


def test_a_name_is_a_short_line_and_no_markup():
    assert name_of("  Mira \n\t M.  ") == "Mira M."
    assert name_of("\x00\u202e\u200bMira") == "Mira"
    assert len(name_of("n" * 500)) == MOST_NAME
    drawn = draw_tile(tile_of(msgspec.structs.replace(SUMMARY, name="<img src=x>", lesson=("<b>", 1, 2)), {}))
    assert "<img" not in drawn and "<b><" not in drawn and "&lt;img src=x&gt;" in drawn


@pytest.mark.parametrize("plane", [(0, 0, 0, 0), (5, -5, 0, 1), (0, 1, 1, 1)])
def test_a_plane_that_cannot_be_is_drawn_without_one(plane):
    assert "nan" not in draw_tile(tile_of(msgspec.structs.replace(SUMMARY, plane=plane), {}))
