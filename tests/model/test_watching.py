"""A learner that watches itself first imitates in fewer motions; the page says what it remembers, until it forgets."""

import itertools

import pytest
from page_fakes import Hands, quiet_model
from quiet_page import QuietPage
from sameness import assert_same
from viewimit.app.model.editing import Rehearsal

from viewimit.loop.self_calibration import DEFAULT_POSTURES
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.servo import SERVOS
from viewimit.wording import either

SETTINGS = Settings(start_deg=(25.0, -45.0), seed=7)
ABLE = either([servo.title for servo in SERVOS.values() if servo.predicts])
WATCH, STOP, FORGET = "Watch yourself first", "Stop", "Forget"


@pytest.fixture
def visit():
    """A model at the start, and its visitor."""
    model, queue = quiet_model(SETTINGS)
    return model, Hands(model, queue)


seconds = itertools.count()


def play(model, motions=100):
    """So many motions, or fewer if the servo rests."""
    for now, _ in zip(seconds, range(motions)):
        model.player.advance(float(now))


def said(model):
    return Rehearsal(model.session).words


def test_it_goes_through_the_postures_that_the_library_does_and_on_to_imitate(visit):
    model, visitor = visit
    visitor.act("rehearse")
    assert model.player.playing
    play(model)
    alone = Session(SETTINGS)
    body = alone.calibrate(DEFAULT_POSTURES, seed=7)
    assert_same(model.session.snapshot.calibration, body)
    alone.run()
    assert_same(model.session.snapshot, alone.snapshot)
    assert model.session.snapshot.status == "converged" and model.session.history.imitation_motions <= 6
    assert model.session.cursor == DEFAULT_POSTURES + model.session.history.imitation_motions


@pytest.mark.parametrize("servo", ["gradient", "gradient-retuned", "broyden"])
def test_where_the_servo_makes_no_use_of_it_it_is_refused_and_nothing_changes(visit, servo):
    model, visitor = visit
    model.undoable.change(servo=servo)
    before = model.session.snapshot
    with pytest.raises(ValueError, match=f"makes no use of a rehearsal; choose {ABLE}"):
        visitor.act("rehearse")
    assert model.session.snapshot is before and not model.player.playing
    assert said(model) == f"Only for {ABLE}."


@pytest.mark.parametrize("name, value", [("preset", "KUKA iiwa"), ("points", "16 points"), ("joints", "all seven")])
def test_another_body_knows_nothing_and_undo_brings_back_who_did(visit, name, value):
    model, visitor = visit
    visitor.act("rehearse")
    play(model, DEFAULT_POSTURES + 1)
    before = list(model.session.history)
    visitor.set(name, value)
    assert model.session.snapshot.calibration is None
    visitor.act("undo")
    assert list(model.session.history) == before and len(model.session.snapshot.calibration) == DEFAULT_POSTURES


def test_a_page_that_is_kept_goes_on_watching_to_the_last_bit():
    page, back = QuietPage(SETTINGS), QuietPage(SETTINGS)
    page.restore()
    page.choose("Speed", "10 a second")
    page.click(WATCH)
    for _ in range(5):
        page.tick(0.2)
    page.click("Pause")
    model = page.page.model
    Hands(model).set("history", 4)
    back.restore(page.kept)
    back.tick(1.0)
    assert "Watches itself: 4 of 12 poses." in back.shown and back.widget(STOP)
    for one in (model, back.page.model):
        Hands(one).act("play")
        play(one)
    assert_same(back.page.model.session.snapshot, model.session.snapshot)
    back.tick(1.0)
    assert "Remembers 12 poses, which hold. Imitated in" in back.shown


def test_the_button_is_what_can_be_done_now():
    page = QuietPage(Settings.paper(servo="broyden"))
    page.tick(1.0)
    button = page.widget(WATCH)
    assert button.disabled and f"Only for {ABLE}." in page.shown
    page.choose("Servo", "Likelihood of all pictures")
    page.tick(1.0)
    assert not button.disabled
    page.choose("Speed", "10 a second")
    page.click(WATCH)
    page.tick(0.2)
    assert button.label == STOP
    for _ in range(DEFAULT_POSTURES):
        page.tick(0.2)
    assert button.label == FORGET
    page.choose("Servo", "Broyden on pictures")
    page.tick(1.0)
    assert button.label == FORGET and not button.disabled  # what is held can be forgotten
    page.click(FORGET)
    page.tick(1.0)
    assert button.label == WATCH and button.disabled
