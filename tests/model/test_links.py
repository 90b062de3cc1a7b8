"""A page becomes what a link holds, to the last bit, and Undo brings back what it was."""

import base64
from pathlib import Path
from types import SimpleNamespace

import msgspec
import numpy as np
import pytest
import zstandard
from drawn import QR_CODE
from quiet_page import QuietPage
from viewimit.app.jobs import threads
from viewimit.app.jobs.threads import ScriptPlayer
from viewimit.app.model.choices import AS_STARTED, PRESETS
from viewimit.app.model.keeping import saved_page
from viewimit.app.panels.share import share_html
from viewimit.app.sessions.link import Branch, Run, decode, described, encode_blocks, encode_link
from waiting import wait_until

from viewimit.drawing.export.citation import cite
from viewimit.drawing.export.replay import replay
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings

ROOT = Path(__file__).parents[2]
BY_POINTS = [preset for preset in PRESETS if preset.settings.sensor == "projected"]


def settled(page: QuietPage) -> None:
    """Until no link is followed, and no turn goes on beside the scheduler."""
    page.tick(0.1)
    page.tick_until(lambda: not page.page.model.following.goes_on)
    for _ in range(3):
        page.tick(0.1)
        page.settle()
    page.tick(0.1)


def linked_text(**fields) -> str:
    return encode_link(QuietPage(Settings.paper(**fields)).page.model.linked())


class Turns:
    """A session whose script is never whole: counts the passes that it is let make."""

    def __init__(self, whole_after=None):
        self.passed, self.whole_after = 0, whole_after

    def passes(self):
        while self.passed != self.whole_after:
            self.passed += 1
            yield


def test_scripts_that_never_end_hold_up_neither_their_pages_nor_a_short_one():
    """Two of them, and a third of ten passes: it is whole while they go on, in turns, each a slice of time."""
    spent = [0.0]  # s of processor time; each pass takes what the turn has

    def clock():
        spent[0] += 0.03
        return spent[0]

    player, endless, short, done = ScriptPlayer(clock), [Turns(), Turns()], Turns(10), []
    for page_id, turns in enumerate(endless):
        player.play(page_id, turns.passes(), done.append)
    wait_until(lambda: all(turns.passed for turns in endless))
    player.play(7, short.passes(), lambda error: done.extend([error, *(turns.passed for turns in endless)]))
    before = [turns.passed for turns in endless]
    wait_until(lambda: done)
    assert done[0] is None and not player.cancel(7)
    assert max(now - then for then, now in zip(before, done[1:])) <= short.passed + 3
    assert player.cancel(0) and not player.cancel(0) and player.cancel(1)
    player.stop()


def test_a_script_has_only_so_much_time():
    ticks = iter(range(1000))
    player, done = ScriptPlayer(lambda: float(next(ticks))), []
    player.play(0, Turns().passes(), done.append)
    wait_until(lambda: done)
    assert "more than 30 s" in str(done[0]) and isinstance(done[0], ValueError)
    player.stop()


def test_a_script_pauses_as_long_as_it_computed_and_not_as_long_as_it_waited(monkeypatch):
    """On a busy machine a turn of 0.03 s of processor time takes a second."""
    computed, wall, pauses, done = [0.0], [0.0], [], []
    clocks = SimpleNamespace(thread_time=lambda: computed[0], monotonic=lambda: wall[0], sleep=pauses.append)
    monkeypatch.setattr(threads, "time", clocks)

    def passes():
        for _ in range(5):
            computed[0] += 0.03
            wall[0] += 1.0
            yield

    player = ScriptPlayer(clocks.thread_time)
    player.play(0, passes(), done.append)
    wait_until(lambda: done)
    assert pauses[:5] == pytest.approx([0.03] * 5)
    player.stop()


@pytest.mark.parametrize("lets_go", ["dismiss", "undo"])
def test_a_link_that_is_followed_can_be_let_go(lets_go):
    scripts = Held()
    page = QuietPage(Settings.paper(), scripts=scripts)
    model = page.page.model
    before = model.session.snapshot
    page.page.queue.call("link", linked_text(transfer="linear"))
    page.tick(0.3)
    assert model.following.goes_on and "Press Esc to stop" in page.shown
    page.page.queue.call(lets_go)
    page.tick(0.3)
    assert not model.following.goes_on and "Press Esc to stop" not in page.shown
    list(scripts.passes)
    scripts.done(None)  # it was whole just then
    page.tick(0.3)
    assert model.session.snapshot is before


class Held:
    """A player of scripts that are whole when the test says so."""

    def play(self, page_id, passes, done):
        self.passes, self.done = passes, done

    def cancel(self, page_id):
        pass


@pytest.mark.parametrize("preset", BY_POINTS[:4], ids=lambda preset: preset.name)
def test_a_link_opens_the_same_state_and_undo_brings_back_the_old_one(preset):
    sender, receiver = QuietPage(preset.settings), QuietPage(Settings.paper())
    for page, motions in ((sender, 4), (receiver, 2)):
        for _ in range(motions):
            page.page.queue.call("step")
            page.tick(0.3)
    sender.page.model.session.pose(sender.page.model.session.snapshot.theta_demo * 0.97)
    left = receiver.page.model.session.snapshot
    sent = sender.page.model
    receiver.page.queue.call("link", encode_link(sent.linked()))
    settled(receiver)
    got = receiver.page.model
    assert got.session.snapshot.theta.tobytes() == sent.session.snapshot.theta.tobytes()
    assert got.session.settings == sent.session.settings and got.session.cursor == sent.session.cursor > 2
    assert got.session.snapshot.E == sent.session.snapshot.E
    for _ in range(sent.session.cursor + 1):
        receiver.page.queue.call("undo")
        receiver.tick(0.3)
    assert got.session.snapshot.theta.tobytes() == left.theta.tobytes() and got.session.cursor == 2


def test_a_link_into_a_lesson_of_an_earlier_version_says_where_lessons_are_now():
    packed = zstandard.compress(msgspec.msgpack.encode({"script": {"settings": {}}, "lesson": ["tour", 3]}))
    with pytest.raises(ValueError, match="in the lab now, at /lab/tour"):
        decode("1" + base64.urlsafe_b64encode(packed).decode().rstrip("="), Settings.paper())


def test_a_bad_link_says_why_and_changes_nothing():
    page = QuietPage(Settings.paper())
    before = page.page.model.session.snapshot
    page.page.queue.call("link", "1nonsense")
    settled(page)
    assert page.page.model.session.snapshot is before
    assert "the link is damaged" in page.page.model.message.text


def test_the_card_shows_link_and_code_of_the_moment_shown():
    page = QuietPage(Settings.paper())
    page.page.queue.call("step")
    page.tick(0.3)
    model = page.page.model
    shown = share_html(model, "http://here:8080")
    assert "http://here:8080/?preset=paper&amp;steps=1" in shown and QR_CODE in shown
    text = encode_link(model.linked())
    assert "session.step()" in shown and "--max-motions=1" in shown
    session = Session(Settings.paper())

    session.play(decode(text, Settings.paper()).scripts[0])
    assert np.array_equal(session.snapshot.theta, model.session.snapshot.theta)


def test_an_own_scene_opens_elsewhere_survives_a_reload_and_is_passed_on(tmp_path):
    """The card says nothing of a file, its QR code is there, and pictures are captioned by the scene's title."""
    path = tmp_path / "mine.toml"
    path.write_text('title = "Eyes <b>apart</b> &c"\nextends = "panda"\n[head]\nbaseline = 0.8\n')
    sender, receiver = QuietPage(Settings.paper(scene=str(path))), QuietPage(Settings.paper())
    for _ in range(3):
        sender.page.queue.call("step")
        sender.tick(0.3)
    sent, got = sender.page.model, receiver.page.model
    card, text = share_html(sent, "http://here:8080"), encode_link(sent.linked())
    assert f"/?s={text}" in card and 'aria-label="QR code' in card and "It opens only" not in card
    path.unlink()
    assert sent.preset.name == AS_STARTED
    receiver.page.queue.call("link", text)
    settled(receiver)
    assert got.session.snapshot.theta.tobytes() == sent.session.snapshot.theta.tobytes()
    assert got.session.snapshot.E == sent.session.snapshot.E and got.session.cursor == 3
    assert got.session.world.scene == sent.session.world.scene
    assert (
        encode_link(got.linked()).startswith("2.")
        and decode(encode_link(got.linked()), Settings.paper()) == got.linked()
    )
    card = share_html(got, "http://here:8080")
    assert "save the scene, and name its file" in card and "baseline = 0.8" in card and "<b>apart" not in card
    cited = cite(got.session)
    assert "Eyes <b>apart</b> &c, 10 points" in cited.conditions and cited.command is None and cited.python
    page = replay(got.session).html
    assert "<b>apart" not in page and "Eyes &lt;b&gt;apart&lt;/b&gt; &amp;c" in page
    other = QuietPage(Settings.paper())
    other.restore(".".join(encode_blocks(saved_page(got).renamed(described))))
    again = other.page.model
    assert again.session.snapshot.theta.tobytes() == got.session.snapshot.theta.tobytes()
    assert again.session.world.scene == got.session.world.scene and again.session.script == got.session.script


def test_what_is_too_much_for_a_link_is_said_in_python():
    page = QuietPage(Settings.paper()).page.model
    angles = np.random.default_rng(0).uniform((0, -140), (90, -40), (900, 2))
    for theta in np.radians(angles):
        page.session.pose(theta)
        page.session.step()
    card = share_html(page, "http://here:8080")
    assert (
        "too much was done for a link" in card and "The same in Python" in card and "as Python it can be said" in card
    )


def test_the_card_says_where_alone_a_link_with_a_robot_of_ones_own_opens():
    page = QuietPage(Settings.paper(scene=str(ROOT / "docs/gallery-arm.urdf")))
    card = share_html(page.page.model, "http://here:8080")
    assert "It opens only on a server that was started with gallery-arm.urdf" in card and "/?s=" in card


def test_what_a_link_began_with_is_its_own_and_not_what_this_server_was_started_with():
    sent = QuietPage(Settings.paper(seed=11, noise_px=0.125)).page.model.linked()
    page = QuietPage(Settings.paper(scene="iiwa", seed=3))
    assert sent.present.preset == page.page.model.preset.name == AS_STARTED
    scripts = [Session(Settings.paper(scene=scene)).script for scene in ("panda-facing", "panda-flat")]
    others = [
        msgspec.structs.replace(sent, present=Branch(runs=(Run(script=script, cursor=0),), preset="Elsewhere"))
        for script in scripts
    ]
    for linked in (sent, *others):
        page.page.queue.call("link", encode_link(linked))
        settled(page)
        model = page.page.model
        assert model.preset.name == "From a link" and not model.modified
    model.session.change(seed=4)
    assert model.modified
