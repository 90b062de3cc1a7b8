"""What a visitor has left behind comes back whole: the reset, the preset, the start and the other branch."""

from unittest.mock import Mock

import pytest
from page_fakes import Hands, quiet_model
from viewimit.app.model.choices import PRESETS
from viewimit.app.model.editing import MAX_ENTRIES

from viewimit.loop.settings import Settings

SETTINGS = Settings.paper(start_deg=(25, -45), noise_px=0.3)


@pytest.fixture
def visit():
    """A model after five motions, and its visitor."""
    model, queue = quiet_model(SETTINGS)
    visitor = Hands(model, queue)
    for _ in range(5):
        visitor.act("step")
    return model, visitor


def moments(model):
    return list(model.session.history), model.session.cursor


LOSSES = {
    "reset": lambda visitor: visitor.act("reset"),
    "preset": lambda visitor: visitor.set("preset", "Five points"),
    "another robot": lambda visitor: visitor.set("preset", "KUKA iiwa"),
    "start": lambda visitor: visitor.model.undoable.start_at((60, -60)),
    "joints": lambda visitor: visitor.set("joints", "all seven"),
    "points": lambda visitor: visitor.set("points", "16 points"),
}


@pytest.mark.parametrize("loss", LOSSES)
def test_undo_brings_back_what_a_loss_has_taken(visit, loss):
    model, visitor = visit
    before, preset, speed = moments(model), model.preset, model.player.speed
    LOSSES[loss](visitor)
    assert model.session.cursor == 0 and len(model.session.history) == 1
    visitor.act("step")
    visitor.act("undo")  # the motion first
    assert model.session.cursor == 0 and model.session.settings != before[0][-1].settings or loss == "reset"
    visitor.act("undo")
    assert moments(model) == before and (model.preset, model.player.speed) == (preset, speed)
    assert "5 steps" in model.message.text
    visitor.act("undo")
    assert model.session.cursor == 4


@pytest.mark.parametrize("loss", ["step", "play", "joint0", "noise_px"])
def test_motions_that_others_took_the_place_of_can_be_gone_back_to(visit, loss):
    model, visitor = visit
    other = list(model.session.history)
    visitor.set("history", 2)
    if loss in ("step", "play"):
        visitor.act(loss)
        model.player.advance(0.0)
        assert model.session.history[3] is not other[3]
        visitor.act("undo")
    else:
        visitor.set(loss, 70 if loss == "joint0" else 1)
    assert model.session.cursor == 2
    visitor.act("undo")
    assert moments(model) == (other, 2)
    visitor.set("history", 5)
    assert model.session.snapshot is other[5]


def test_losses_are_taken_back_one_after_the_other_and_only_so_many(visit):
    model, visitor = visit
    for k in range(MAX_ENTRIES + 3):
        visitor.set("preset", PRESETS[2 + k % 3].name)
    for k in reversed(range(MAX_ENTRIES + 2)):
        left = model.past.here
        visitor.act("undo")
        assert left is None or model.preset is PRESETS[2 + k % 3]
    assert model.past.here is None and model.preset is PRESETS[2 + 2 % 3]


def test_a_reset_in_a_duel_brings_back_both(visit):
    model, visitor = visit
    visitor.act("duel")
    model.player.playing = False
    for _ in range(3):
        visitor.act("step")
    both = [(list(session.history), session.cursor) for session in (model.session, model.duel.opponent)]
    visitor.act("reset")
    visitor.act("undo")
    assert [(list(session.history), session.cursor) for session in (model.session, model.duel.opponent)] == both
    visitor.act("reset")
    visitor.act("duel")  # ends it: what was left had two learners
    assert model.past.here is None


def test_a_preset_whose_duel_cannot_begin_is_still_the_one_that_is_chosen(visit, monkeypatch):
    model, visitor = visit
    monkeypatch.setattr(model.duel, "begin", Mock(side_effect=ValueError("no camera")))
    with pytest.raises(ValueError, match="no camera"):
        visitor.set("preset", "Five points")
    assert model.preset.name == "Five points" and model.session.settings.points == 5
