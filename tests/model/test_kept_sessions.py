"""What a tab keeps of its page makes another page the same to the last bit; what it cannot, that page says."""

import base64

import msgspec
import numpy as np
import pytest
import zstandard
from hypothesis import given, settings
from hypothesis import strategies as st
from page_fakes import Hands
from quiet_page import QuietPage
from sameness import assert_same
from viewimit.app.jobs import threads as scripts
from viewimit.app.model.keeping import AT_ONCE, SEND_EVERY
from viewimit.app.model.page_model import PageModel
from viewimit.app.sessions import link
from viewimit.app.sessions.link import MAX_TEXT, decode

from viewimit.analysis.trajectory import encode_motion, make_motion
from viewimit.loop.settings import Settings

REPLACE = msgspec.structs.replace
DEEDS = st.lists(
    st.one_of(
        st.tuples(st.just("step"), st.integers(1, 3)),
        st.tuples(st.just("joint0"), st.sampled_from([50.0, 55.5, 61.0, 44.5])),
        st.tuples(st.just("undo"), st.integers(1, 3)),
        st.tuples(st.just("history"), st.integers(0, 4)),
        st.tuples(st.just("reset"), st.just(1)),
        st.tuples(st.just("preset"), st.sampled_from(["Half a pixel of noise", "Few points", "Seven joints"])),
        st.tuples(st.just("servo"), st.sampled_from(["Broyden’s rule", "Kalman filter"])),
        st.tuples(st.just("chosen"), st.sampled_from(["2", "3"])),
        st.tuples(st.just("rays"), st.booleans()),
        st.tuples(st.just("duel"), st.just(1)),
    ),
    max_size=10,
)  # fmt: skip


def begun(settings=None, **options) -> QuietPage:
    """A page in a new tab."""
    page = QuietPage(settings or Settings.paper(), **options)
    page.restore()
    return page


def restored(kept: str, settings=None) -> QuietPage:
    page = QuietPage(settings or Settings.paper())
    page.restore(kept)
    return page


def same(one: PageModel, other: PageModel) -> None:
    """What is shown, and all that Undo goes back to."""
    assert_same(tuple(one.session.history), tuple(other.session.history))
    assert one.session.cursor == other.session.cursor and one.view == other.view
    assert (one.preset.name, one.player.speed) == (other.preset.name, other.player.speed)
    assert (one.duel.opponent is None) == (other.duel.opponent is None)
    if one.duel.opponent is not None:
        assert_same(tuple(one.duel.opponent.history), tuple(other.duel.opponent.history))
    assert len(one.past.everything) == len(other.past.everything)
    for left, found in zip(one.past.everything, other.past.everything):
        assert (left.at, left.preset.name, left.speed) == (found.at, found.preset.name, found.speed)
        for (moments, cursor, _), (others, at, _) in zip(left.runs, found.runs, strict=True):
            assert cursor == at
            assert_same(moments, others)


def do(hands: Hands, what: str, value) -> None:
    if what in ("step", "undo", "reset", "duel"):
        for _ in range(value):
            hands.act(what)
            hands.model.player.pause()  # a duel begins to play
    else:
        hands.set(what, value)


@settings(max_examples=30, deadline=None)
@given(DEEDS)
def test_whatever_was_done_comes_back_to_the_last_bit_and_can_be_undone(deeds):
    page = begun()
    hands = Hands(page.page.model)
    for what, value in deeds:
        try:
            do(hands, what, value)
        except ValueError:  # what cannot be here
            continue
        page.tick(SEND_EVERY)
    other = restored(page.kept)
    model, again = page.page.model, other.page.model
    assert again.message is None
    if page.kept:
        same(model, again)
    for _ in range(4):
        for one in (page, other):
            one.page.queue.call("undo")
            one.tick(SEND_EVERY)
    same(model, again)


def test_the_tab_keeps_what_it_kept_when_a_page_is_restored_and_goes_on_from_there():
    page = begun()
    for k in range(250):
        Hands(page.page.model).set("joint0", 50 + 0.5 * (k % 20))
        Hands(page.page.model).act("step")
    kept = page.kept
    other = restored(kept)
    other.page.queue.call("step")
    again = restored(other.kept)
    assert again.page.model.session.cursor == 251
    same(other.page.model, again.page.model)


def test_only_what_is_new_is_sent_and_seldom():
    page = begun()
    hands, sent = Hands(page.page.model), []
    for k in range(200):  # ten seconds
        hands.set("joint0", 50 + 0.5 * (k % 20))
        hands.act("step")
        page.tick(0.05)
        part = page.widget("vi-session").value
        sent += [part] if part and part not in sent[-1:] else []
    assert len(sent) <= AT_ONCE + 10 / SEND_EVERY + 1
    last = msgspec.json.decode(sent[-1])
    assert last["at"] >= 4 and sum(map(len, last["blocks"])) < len(page.kept) / 2


def test_a_new_tab_is_sent_nothing_before_something_is_done():
    page = begun()
    for _ in range(10):
        page.tick(1.0)
    assert page.kept == ""
    page.act("point", "5")
    assert decode(page.kept, Settings.paper()).chosen == 5


def test_what_is_done_before_a_new_tab_has_told_that_it_stores_nothing_is_kept_too():
    page = QuietPage(Settings.paper())
    page.choose("θ₂", 70.0)
    page.act("session", "")
    assert decode(page.kept, Settings.paper()).present.runs
    same(page.page.model, restored(page.kept).page.model)


def test_a_page_sends_nothing_to_a_tab_that_has_not_told_what_it_has():
    page = QuietPage(Settings.paper())
    page.page.queue.call("step")
    assert page.kept == ""


def test_a_tab_that_has_missed_a_part_gets_all_again():
    page = begun()
    page.page.queue.call("step")
    kept = page.kept
    page.act("resend", "0")
    page.tick(1.0)
    assert page.kept == kept and msgspec.json.decode(page.widget("vi-session").value)["at"] == 0


def test_a_recorded_motion_comes_back_or_is_said_to_be_too_long(monkeypatch):
    page = begun()
    model = page.page.model
    theta = np.linspace((0.7, -1.5), (0.8, -1.4), 20)
    model.motions.load(encode_motion(make_motion("mine", model.session.scene, theta)))
    kept = page.kept
    assert restored(kept).page.model.motions.recorded.name == "mine"
    monkeypatch.setattr("viewimit.app.model.keeping.MAX_MOTION", 100)
    model.view = REPLACE(model.view) if isinstance(model.view, msgspec.Struct) else model.view
    page.act("point", "3")
    other = restored(page.kept).page.model
    assert other.motions.recorded is None and "recorded motion is too long" in other.message.text


def stands_where(page: QuietPage, other: QuietPage) -> None:
    """Posture and settings."""
    one, two = (each.page.model.session for each in (page, other))
    np.testing.assert_allclose(two.snapshot.theta, one.snapshot.theta, atol=1e-9)
    np.testing.assert_array_equal(two.snapshot.theta_demo, one.snapshot.theta_demo)
    ignored = {"start_deg": None}
    assert REPLACE(two.settings, **ignored) == REPLACE(one.settings, **ignored)


@pytest.fixture
def worked() -> QuietPage:
    """A page on which something was done."""
    page = begun(Settings.paper(noise_px=0.25))
    Hands(page.page.model).set("joint0", 55.5)
    for _ in range(4):
        Hands(page.page.model).act("step")
    page.act("point", "4")
    return page


def packed(content) -> str:
    data = zstandard.ZstdCompressor(dict_data=link.COMMON).compress(msgspec.msgpack.encode(content))
    return base64.urlsafe_b64encode(data).decode().rstrip("=")


def unpacked(block: str):
    data = base64.urlsafe_b64decode(block + "===")
    plain = zstandard.ZstdDecompressor(dict_data=link.COMMON).decompress(data, max_output_size=1 << 20)
    return msgspec.msgpack.decode(plain)


def test_of_a_newer_format_posture_and_settings_are_taken_and_the_rest_is_said(worked):
    *_, head = worked.kept.split(".")
    newer = unpacked(head) | {"version": "9.1", "something": ["new"], "branches": "otherwise"}
    newer["settings"] |= {"gravity": 3}
    other = restored(f"3.what.is.new.{packed(newer)}")
    said = other.page.model.message.text
    assert "newer version of viewimit, 9.1" in said and "only its posture and settings are here" in said
    stands_where(worked, other)


def test_of_damaged_motions_posture_and_settings_are_taken(worked):
    blocks = worked.kept.split(".")
    blocks[1] = blocks[1][:-6] + "AAAAAA"
    other = restored(".".join(blocks))
    assert "its motions are damaged" in other.page.model.message.text
    stands_where(worked, other)


def test_what_takes_too_long_is_not_continued_but_for_posture_and_settings(worked, monkeypatch):
    monkeypatch.setattr(scripts, "MAX_CPU_S", 0.0)
    other = restored(worked.kept)
    assert "more than 0 s to compute" in other.page.model.message.text
    stands_where(worked, other)


def test_what_the_tab_has_kept_is_not_written_over_where_it_could_not_be_continued(worked, monkeypatch):
    kept = worked.kept
    with monkeypatch.context() as slow:
        slow.setattr(scripts, "MAX_CPU_S", 0.0)
        other = QuietPage(Settings.paper())
        other.restore(kept)
    other.tick(5.0)
    assert other.kept == "", "the tab still has it"
    other.page.queue.call("step")
    assert other.kept != ""


def test_another_computation_is_told_from_the_same(worked):
    *blocks, head = worked.kept.split(".")
    told = unpacked(head)
    told["commanded"][0] += 1e-3
    other = restored(".".join([*blocks, packed(told)]))
    assert "computed again here, the arm is 0.057° from where it was" in other.page.model.message.text
    assert other.page.model.session.cursor == 4


def test_what_is_no_session_begins_anew_and_says_why(worked):
    for text in ("nonsense", "2.nonsense", worked.kept[:-3] + "AAA", "2." + "x" * MAX_TEXT):
        other = restored(text)
        assert "so the session begins again" in other.page.model.message.text
        assert other.page.model.session.cursor == 0


class Held:
    """A player of scripts that are whole when the test says so."""

    def play(self, page_id, passes, done):
        self.passes, self.done = passes, done

    def cancel(self, page_id):
        pass


@pytest.mark.parametrize("lets_go", ["dismiss", "undo"])
def test_a_session_that_is_restored_can_be_let_go_and_what_is_clicked_meanwhile_waits(worked, lets_go):
    held = Held()
    page = QuietPage(Settings.paper(), scripts=held)
    page.act("session", worked.kept)
    page.page.queue.call("step")
    page.tick(0.3)
    assert "this tab’s session" in page.shown and page.page.model.session.cursor == 0, "a motion waits"
    page.page.queue.call(lets_go)
    page.tick(0.3)
    page.tick(0.3)
    assert page.page.model.session.cursor == 1 and not page.page.model.following.goes_on
    list(held.passes)
    held.done(None)
    page.tick(0.3)
    assert page.page.model.session.cursor == 1


def test_what_is_clicked_while_a_session_is_restored_is_done_to_it(worked):
    held = Held()
    page = QuietPage(Settings.paper(), scripts=held)
    page.act("session", worked.kept)
    page.page.queue.call("step")
    page.tick(0.3)
    list(held.passes)
    held.done(None)
    page.tick(0.3)
    page.tick(0.3)
    assert page.page.model.session.cursor == 5


def test_a_link_in_the_address_is_followed_after_the_tab_s_own_session_which_undo_brings_back(worked):
    sent = begun(Settings.paper(transfer="linear"))
    text = link.encode_link(sent.page.model.linked())
    page = QuietPage(Settings.paper())
    page.act("session", worked.kept)
    page.act("link", text)
    page.tick_until(lambda: page.page.model.session.settings.transfer == "linear")
    page.page.queue.call("undo")
    page.tick(1.0)
    assert page.page.model.session.cursor == 4 and page.page.model.session.settings.transfer == "epipolar"


def test_a_tab_that_cannot_store_says_so(worked):
    worked.act("unsaved", "storage")
    worked.tick(1.0)
    worked.tick(1.0)
    assert "full or forbidden: a reload would lose this session." in worked.shown.replace("&#x27;", "'")


def test_a_hostile_session_costs_no_more_than_its_time(monkeypatch):
    """More motions than anybody waits for, and blocks that unpack to much."""
    page = begun()
    *_, head = (page.act("point", "3"), page.kept)[1].split(".")
    told = unpacked(head) | {"branches": [{"runs": [[0, 1]]}]}
    endless = packed([told["settings"], "s", [10**9], [], []])
    monkeypatch.setattr(scripts, "MAX_CPU_S", 0.05)
    assert "to compute" in restored(f"2.{endless}.{packed(told)}").page.model.message.text
    many = packed([told["settings"], "l" * 50_000, [1] * 50_000, [], []])
    assert "more than 20000 actions" in restored(f"2.{many}.{packed(told)}").page.model.message.text
    bomb = base64.urlsafe_b64encode(zstandard.compress(bytes(1 << 24))).decode().rstrip("=")
    assert "damaged" in restored(f"2.{bomb}.{packed(told)}").page.model.message.text
