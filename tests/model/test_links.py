"""A link, or what a tab keeps, makes another page the same to the last bit; what is hostile or unknown is refused."""

import base64
import json
import zlib

import numpy as np
import pytest
from dearest_texts import MOST_S, TEXTS, cpu_of
from hypothesis import given, settings
from hypothesis import strategies as st
from page_fakes import Hands
from quiet_page import QuietPage
from sameness import assert_same
from viewimit.app.model.keeping import SEND_EVERY, share_link
from viewimit.app.model.link import read_link
from viewimit.app.model.page_model import PageModel

from viewimit.analysis.trajectory import encode_motion, make_motion
from viewimit.loop import link
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings

ACTS = st.lists(
    st.one_of(
        st.tuples(st.just("step"), st.integers(1, 3)),
        st.tuples(st.just("joint0"), st.sampled_from([50.0, 55.5, 61.0, 44.5])),
        st.tuples(st.just("undo"), st.integers(1, 3)),
        st.tuples(st.just("history"), st.integers(0, 4)),
        st.tuples(st.just("reset"), st.just(1)),
        st.tuples(st.just("preset"), st.sampled_from(["Noisy pictures", "Five points", "Seven joints"])),
        st.tuples(st.just("servo"), st.sampled_from(["Broyden’s rule", "Kalman filter"])),
        st.tuples(st.just("noise_px"), st.sampled_from([0.25, 1.0])),
        st.tuples(st.just("chosen"), st.sampled_from(["2", "3"])),
        st.tuples(st.just("rays"), st.booleans()),
        st.tuples(st.just("duel"), st.just(1)),
        st.tuples(st.just("rehearsal"), st.just(1)),
    ),
    max_size=10,
)  # fmt: skip


def do(hands: Hands, what: str, value) -> None:
    if what in ("step", "undo", "reset", "duel", "rehearsal"):
        for _ in range(value):
            hands.act(what)
            hands.model.player.pause()  # a duel begins to play
    else:
        hands.set(what, value)


def begun(kept: str = "", settings: Settings | None = None) -> QuietPage:
    """A page in a tab that has kept this."""
    page = QuietPage(settings or Settings.paper())
    page.restore(kept)
    return page


def visited(acts) -> QuietPage:
    page = begun()
    for what, value in acts:
        try:
            do(Hands(page.page.model), what, value)
        except (ValueError, KeyError, StopIteration):  # what cannot be here
            continue
        page.tick(SEND_EVERY)
    return page


def same(one: PageModel, other: PageModel) -> None:
    assert_same(tuple(one.session.history), tuple(other.session.history))
    assert one.session.cursor == other.session.cursor and one.view == other.view
    assert one.player.speed == other.player.speed
    assert (one.duel.opponent is None) == (other.duel.opponent is None)
    if one.duel.opponent is not None:
        assert_same(tuple(one.duel.opponent.history), tuple(other.duel.opponent.history))


@settings(max_examples=12)
@given(ACTS)
def test_whatever_was_done_comes_back_to_the_last_bit_in_a_tab_and_by_a_link(acts):
    assert_comes_back(acts)


@pytest.mark.slow
@settings(max_examples=100)
@given(ACTS)
def test_much_that_was_done_comes_back(acts):
    assert_comes_back(acts)


def assert_comes_back(acts):
    page = visited(acts)
    model = page.page.model
    if page.kept:
        assert len(page.kept) < 6000
        again = begun(page.kept)
        assert again.page.model.message is None and again.kept == page.kept, "as after one more reload"
        same(model, again.page.model)
    query = share_link(model)
    script = read_link(query, Settings()).script
    session = Session(script.settings)
    session.play(script)
    assert_same(tuple(session.history), tuple(model.session.history)[: model.session.cursor + 1])


def test_what_a_query_cannot_say_is_packed_and_comes_back():
    page = begun()
    model = page.page.model
    model.motions.load(encode_motion(_motion(model)))
    points = tuple((7, 0.01 * k, 0.02, 0.1 + 0.02 * k) for k in range(6))
    model.undoable.set_body_points(points)
    page.page.queue.call("step")
    page.tick(SEND_EVERY)
    assert "x=" in page.kept
    again = begun(page.kept).page.model
    same(model, again)
    assert again.session.settings.body_points == model.session.settings.body_points
    assert again.motions.recorded == model.motions.recorded


def _motion(model: PageModel):
    theta = model.session.snapshot.theta_demo + np.linspace(0, 0.2, 20)[:, None]
    return make_motion("mine", model.session.scene, theta)


def test_a_link_that_hides_shows_no_posture_and_opens_the_same():
    page = visited([("joint0", 55.5), ("step", 2)])
    hidden, shown = share_link(page.page.model, hides=True), share_link(page.page.model)
    assert "demo=55.5" in shown and "55" not in hidden
    for one in (hidden, shown):
        session = Session(read_link(one, Settings()).script.settings)
        session.play(read_link(one, Settings()).script)
        assert_same(tuple(session.history), tuple(page.page.model.session.history))


def test_what_comes_after_a_step_is_a_change_at_that_moment():
    script = read_link("preset=paper&demo=45,-90&start=25,-45&steps=8&noise=0.5&steps=4&demo=50,-90", Settings()).script
    session = Session(Settings.paper(demonstrator_deg=(45, -90), start_deg=(25, -45)))
    for _ in range(8):
        session.step()
    session.change(noise_px=0.5)
    for _ in range(4):
        session.step()
    session.pose(np.radians((50, -90)))
    again = Session(script.settings)
    again.play(script)
    assert_same(tuple(again.history), tuple(session.history))


REFUSED = {
    "s=2.abc": "version 0.2",
    "preset=nothing": "there are paper",
    "preset=paper&preset=paper": "twice",
    "demo=1,2&demo=1,2": "twice before a step",
    "colour=blue": "not known, 'colour'",
    "steps=-1": "whole number",
    "steps=1e9": "whole number",
    "demo=nan,1": "no number",
    "steps=1&demo=inf,1": "no number",
    "noise=-1": "noise_px",
    "scene=/etc/passwd": "a scene that is not here",
    "robot=../x.urdf": "a robot that is not here",
    "servo=own": "servo",
    "frames=101": "pictures",
    "rays=2": "must be one of 0, 1",
    "speed=3": "speed",
    "at=1.5": "whole number",
    "x=%%%": "damaged",
    "x=AAAA": "damaged",
    "x=AAAA&steps=1": "both",
    "a" * 14_001: "too long",
    "begin=&" * 600: "changes",
}


@pytest.mark.parametrize("query", REFUSED, ids=lambda query: query[:30])
def test_what_is_not_understood_or_not_allowed_is_refused_in_one_line(query):
    with pytest.raises(ValueError, match=REFUSED[query]) as refused:
        read_link(query, Settings.paper())
    assert "\n" not in str(refused.value) and len(str(refused.value)) < 700


def test_what_unpacks_to_too_much_is_refused_unread():
    bomb = zlib.compress(b"[" * 10**7)
    for data in (bomb, zlib.compress(json.dumps({"script": {"deeds": [["b", {}]] * 3000}}).encode())):
        text = base64.urlsafe_b64encode(data).decode().rstrip("=")
        with pytest.raises(ValueError, match="the link is damaged: more than"):
            link.unpacked(text)


@pytest.mark.parametrize("what", TEXTS)
def test_no_text_that_a_tab_may_send_takes_long_in_the_loop(what):
    """With ten times the room, as machines differ; `python tests/dearest_texts.py` prints the numbers."""
    assert cpu_of(TEXTS[what]()) < 10 * MOST_S


def test_the_command_plays_a_link_to_the_same_posture(ask_json):
    query = "preset=paper&demo=45,-90&start=25,-45&steps=4&noise=0.5&steps=3"
    script = read_link(query, Settings()).script
    session = Session(script.settings)
    session.play(script)
    status, found = ask_json("imitate", "--link", f"http://127.0.0.1:8080/?{query}")
    assert status == 1 and found["motions"] == 7
    np.testing.assert_allclose(found["final_deg"], np.degrees(session.snapshot.theta), atol=1e-6)


def test_a_tab_whose_text_cannot_be_restored_is_told_so():
    page = begun("preset=paper&start=400,0&steps=2")
    assert "what this tab has kept cannot be restored" in page.page.model.message.text
