"""What a servo may ask about images that it predicts, and how a demonstrator goes on."""

import numpy as np

from viewimit.estimation.residuals import PredictedResiduals
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings


def predicted(now, **more):
    return PredictedResiduals(now.views, now.method, converged=now.converged_transfer, **more)


def test_residuals_are_those_of_the_points_that_are_known():
    now = Session(Settings.paper(transfer="epipolar")).snapshot
    ask, own = predicted(now), now.views.own
    np.testing.assert_allclose(ask(own), now.e)
    unknown = own.copy()
    unknown[3] = np.nan
    assert ask(unknown).shape == (9, 4)
    assert np.isposinf(ask(np.full_like(own, np.nan))).all()  # no points are known


def test_a_batch_equals_the_loop():
    now = Session(Settings.paper(transfer="projective")).snapshot
    ask, own = predicted(now), now.views.own
    batch = own + np.random.default_rng(0).normal(0, 2, (2, 3, *own.shape))
    together = ask(batch)
    for index in np.ndindex(2, 3):
        np.testing.assert_allclose(together[index], ask(batch[index]), atol=1e-8)


def test_residuals_use_the_points_of_a_moving_demonstrator_at_the_next_look():
    now = Session(Settings.paper(transfer="linear")).snapshot
    drift = np.random.default_rng(0).normal(0, 3.0, now.views.demo.shape)
    ahead = now.with_fields(views=type(now.views)(now.views.demo + drift, now.views.own, now.views.visible))
    np.testing.assert_allclose(predicted(now, velocity=drift)(now.views.own), ahead.e)


def test_behind_a_moving_demonstrator_with_noise_the_converged_transfer_is_used():
    first = Session(Settings.paper(transfer="linear", start_deg=(25, -45)))
    then = first.snapshot.transfer
    now = first.run().last.with_fields(converged_transfer=then)
    own, drift = now.views.own, np.ones_like(now.views.demo)

    def of_frozen(by_px):
        return own - then.recover(now.views.demo_left + by_px, now.views.demo_right + by_px)

    np.testing.assert_allclose(predicted(now, velocity=drift, noise_px=0.5)(own), of_frozen(1.0))
    assert not np.allclose(predicted(now, velocity=drift)(own), of_frozen(1.0), atol=0.1)
    assert not np.allclose(predicted(now, noise_px=0.5)(own), of_frozen(0.0), atol=0.1)
