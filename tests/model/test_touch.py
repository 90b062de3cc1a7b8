"""What links of the drawings ask for: points, postures, moments; a look that moves nothing."""

import numpy as np
import pytest
from page_fakes import Hands, link, quiet_model
from sameness import assert_same
from viewimit.app.model.choices import NO_POINT

from viewimit.loop.session import Session
from viewimit.loop.settings import Settings

NOISY = Settings.paper(start_deg=(25, -45), noise_px=0.5)


@pytest.fixture
def visit():
    """A model and its visitor."""
    model, queue = quiet_model(NOISY)
    return model, Hands(model, queue)


def touch(model, control, value):
    link(control, value).apply(model, 0.0)


def test_a_point_is_chosen_and_chosen_again_is_none(visit):
    model, visitor = visit
    visitor.set("chosen", NO_POINT)
    for value, chosen in (("3", 3), ("4", 4), ("4", None)):
        touch(model, "point", value)
        assert model.view.chosen == chosen
    with pytest.raises(ValueError, match="no point 10"):
        touch(model, "point", "10")


def test_the_learner_starts_where_the_landscape_is_touched(visit):
    model, visitor = visit
    visitor.act("step")
    touch(model, "posture", "70,-140")
    assert np.allclose(np.degrees(model.session.snapshot.theta), [70, -140]) and model.session.snapshot.motion == 0
    assert model.session.settings.start_deg == (70, -140) and model.generation == 0  # the same world


@pytest.mark.parametrize("value", ["", "1", "1,2,3", "91,-90", "45,1e9", "45,--", "1,,2"])
@pytest.mark.parametrize("look_only", [False, True])
def test_a_posture_that_cannot_be_is_refused_and_changes_nothing(visit, value, look_only):
    model, visitor = visit
    visitor.set_view(look_only=look_only)
    before = model.session.snapshot
    with pytest.raises(ValueError):
        touch(model, "posture", value)
    assert model.session.snapshot is before and model.display.preview.moment is None


def test_a_look_shows_what_would_be_seen_and_disturbs_nothing(visit):
    model, visitor = visit
    alone = Session(NOISY)
    visitor.set_view(look_only=True)
    for k in range(4):
        touch(model, "posture", f"{20 + 10 * k},-60")
        state = model.refresh(0.0)
        there = Session(Settings.paper(start_deg=(20 + 10 * k, -60), noise_px=0.5)).snapshot
        if k == 0:  # the first look of a session that starts there has the same noise
            assert state.preview.E == there.E
        assert state.image_snapshot is state.scene_snapshot is state.preview and np.array_equal(
            state.scene_snapshot.theta, there.theta
        )
        assert state.present is model.session.snapshot and state.interpolated_theta is None
        assert_same(model.session.snapshot, alone.snapshot)
        model.session.step()
        alone.step()
