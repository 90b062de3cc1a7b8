"""A page becomes what a link holds, to the last bit, and Undo brings back what it was."""

import msgspec
import numpy as np
import pytest
from quiet_page import QuietPage
from viewimit.app.control.commands.links import FollowLink
from viewimit.app.control.commands.session import Step, Undo
from viewimit.app.control.presets import PRESETS
from viewimit.app.panels.guide.share import share_html
from viewimit.app.sessions.link import read, written

from viewimit.session import Session
from viewimit.settings import Settings

BY_POINTS = [preset for preset in PRESETS if preset.settings.camera == "points"]


def settled(page: QuietPage) -> None:
    """Until no turn goes on beside the scheduler."""
    for _ in range(3):
        page.tick(0.1)
        assert page.page._commands.wait(60)
    page.tick(0.1)


@pytest.mark.parametrize("preset", BY_POINTS[:4], ids=lambda preset: preset.name)
def test_a_link_opens_the_same_state_and_undo_brings_back_the_old_one(preset):
    sender, receiver = QuietPage(preset.settings), QuietPage(Settings())
    for page, motions in ((sender, 4), (receiver, 2)):
        for _ in range(motions):
            page.page.put(Step())
            page.tick(0.3)
    sender.page.model.session.pose(sender.page.model.session.snapshot.theta_demo * 0.97)
    left = receiver.page.model.session.snapshot
    sent = sender.page.model
    receiver.page.put(FollowLink(written(sent.linked())))
    settled(receiver)
    got = receiver.page.model
    assert got.session.snapshot.theta.tobytes() == sent.session.snapshot.theta.tobytes()
    assert got.session.settings == sent.session.settings and got.session.cursor == 4
    assert got.session.snapshot.E == sent.session.snapshot.E
    for _ in range(5):
        receiver.page.put(Undo())
        receiver.tick(0.3)
    assert got.session.snapshot.theta.tobytes() == left.theta.tobytes() and got.session.cursor == 2


def test_a_link_made_in_a_lesson_opens_that_step_elsewhere():
    """The receiver's page is the sender's, below it; what the receiver answered before is kept; a lesson that is not
    there is refused, and a screen beyond the last is the last."""
    sender, receiver = QuietPage(Settings(), address="/touch/0.x"), QuietPage(Settings(), address="/touch/0.x")
    for page, verbs in ((sender, ("begin,tour", *["next"] * 4)), (receiver, ("begin,tour", "choose,1"))):
        page.page.put(Step())
        page.tick(0.3)
        for verb in verbs:
            page.page.touch("lesson", verb)
            page.tick(0.3)
    sent, got = sender.page.model, receiver.page.model
    shown = share_html(sent.state(0.0), "http://here:8080")
    assert f"/?s={written(sent.linked())}" in shown and "step of the lesson" in shown and "Python" not in shown
    receiver.page.put(FollowLink(written(sent.linked())))
    settled(receiver)
    assert got.guided.place == sent.guided.place == ("tour", 4) and got.guided.course.screen.id == "line"
    assert got.guided.course.progress.given["before 0"].choice == 1
    assert got.session.snapshot.theta.tobytes() == sent.session.snapshot.theta.tobytes()
    before = got.session.snapshot
    for lesson, says in ((("nowhere", 1), "not here"), (("tour", 99), None)):
        receiver.page.put(FollowLink(written(msgspec.structs.replace(sent.linked(), lesson=lesson))))
        settled(receiver)
        assert says is None or (says in got.message.text and got.session.snapshot is before)
        assert got.guided.place == (("tour", 4) if says else ("tour", len(got.guided.course.screens) - 1))


def test_a_bad_link_says_why_and_changes_nothing():
    page = QuietPage(Settings())
    before = page.page.model.session.snapshot
    page.page.put(FollowLink("1nonsense"))
    settled(page)
    assert page.page.model.session.snapshot is before
    assert "the link is damaged" in page.page.model.message.text


def test_the_card_shows_link_and_code_of_the_moment_shown():
    page = QuietPage(Settings(), address="/touch/0.x")
    page.page.put(Step())
    page.tick(0.3)
    model = page.page.model
    shown = share_html(model.state(0.0), "http://here:8080")
    text = written(model.linked())
    assert f"http://here:8080/?s={text}" in shown and "vi-qr" in shown
    assert "session.step()" in shown and "--max-motions=1" in shown
    session = Session()
    from viewimit.script_player import play

    play(read(text, Settings()).script, session)
    assert np.array_equal(session.snapshot.theta, model.session.snapshot.theta)
