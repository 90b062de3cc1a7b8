"""Fig. 10's imitation in the scene and in the images: what was imitated is seen, and nothing of the session moves."""

import numpy as np
import pytest
from page_fakes import call, quiet_model
from viewimit.app.jobs.experiments import Run

from viewimit.analysis.trajectory import Imitation
from viewimit.loop.settings import Settings

FRAMES, STEP_S, BEGUN = 5, 0.5, 100.0


@pytest.fixture
def model():
    """One whose experiment has made an imitation, which is seen since BEGUN."""
    model, _ = quiet_model(Settings.paper(start_deg=(25, -45)))
    model.session.run()
    theta = model.session.snapshot.theta + np.linspace(0, 0.3, FRAMES)[:, None]
    made = model.session.settings, model.session.snapshot.transfer, STEP_S
    model.experiments.chosen = "fig10"
    model.experiments.take(Run("fig10", "done", imitation=Imitation("Fig. 10", *made, theta + 0.02, theta)))
    call("imitation").apply(model, BEGUN)
    return model


def test_each_frame_is_seen_in_its_time_and_the_session_stays_as_it_is(model):
    imitation, present = model.experiments.shown.imitation, model.session.snapshot
    for frame in range(FRAMES):
        now = BEGUN + (frame + 0.5) * STEP_S
        learner, demonstrator = model.display.poses(now)
        assert np.array_equal(learner, imitation.theta[frame])
        assert np.array_equal(demonstrator, imitation.theta_demo[frame])
        state = model.refresh(now)
        assert (
            state.image_snapshot is state.scene_snapshot
            and state.scene_snapshot.theta is learner
            and state.present is present
        )
        assert f"{frame * STEP_S:.1f} of 2.0 s" in state.playback
    over = BEGUN + FRAMES * STEP_S
    assert model.refresh(over).playback is None and model.refresh(over).scene_snapshot is present
    assert np.array_equal(model.display.poses(over)[0], present.theta)


def test_points_are_recovered_by_the_transfer_that_was_frozen(model):
    frozen, seen = model.session.snapshot.transfer, model.refresh(BEGUN + 1.1 * STEP_S).scene_snapshot
    demo, own = seen.views.demo, seen.views.own
    assert np.allclose(seen.recovered, frozen.recover(demo[:, :2], demo[:, 2:]))
    assert seen.E == pytest.approx(((own - seen.recovered) ** 2).sum() / (2 * len(own)))
    assert not np.allclose(seen.recovered, model.session.observe(seen.theta, seen).recovered)
