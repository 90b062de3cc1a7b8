"""What a servo may ask about images that it predicts, and how a demonstrator goes on."""

import numpy as np

from viewimit.estimation.noise import HomographyResiduals
from viewimit.estimation.residuals import NoiseReference
from viewimit.estimation.views import FourViews
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings


def test_residuals_by_another_transfer_of_unknown_points_and_whitened():
    session = Session(Settings.paper(transfer="epipolar"))
    now = session.snapshot
    ask, own = now.predicted_residuals(), now.views.own
    np.testing.assert_allclose(ask(own), now.e)
    other = Session(Settings.paper(transfer="linear")).snapshot
    np.testing.assert_allclose(ask(own, "linear"), other.e)
    unknown = own.copy()
    unknown[3] = np.nan
    assert ask(unknown).shape == (9, 4)
    assert np.isposinf(ask(np.full_like(own, np.nan))).all()  # no points are known
    weighed = ask(own, None, NoiseReference(own, 1.0))
    assert 0 < np.abs(weighed).sum() < np.abs(now.e).sum()


def partially_visible(session, points):
    """Its present, [r] of these points hidden."""
    views = session.snapshot.views
    visible, demo = views.visible.copy(), views.demo.copy()
    visible[points, 1], demo[points, 2:] = False, np.nan
    return session.snapshot.with_fields(views=FourViews(demo, views.own, visible))


def test_partially_visible_points_are_whitened_near_the_demonstrator_and_unweighted_elsewhere():
    session = Session(Settings.paper(transfer="projective", scene="panda-toed", points=16, noise_px=0.2))
    while session.snapshot.rectification is None and session.step():
        pass
    there = session.observe(session.snapshot.theta_demo, session.snapshot).views.own
    now = partially_visible(session, [1, 4, 9])
    ask, own = now.predicted_residuals(noise_px=0.2).with_partially_visible(), now.views.own
    for like, weighed in ((there, True), (own + 40 * np.sin(own), False)):
        views = FourViews(now.views.demo, like, now.views.visible)
        by = (
            HomographyResiduals.whitened_at(views, now.rectification, 0.1)
            if weighed
            else HomographyResiduals.unweighted(views, now.rectification)
        )
        np.testing.assert_array_equal(
            ask(there, noise_reference=NoiseReference(like, 0.1)), by.residual(views.with_own(there))
        )


def test_a_batch_equals_the_loop():
    now = Session(Settings.paper(transfer="projective")).snapshot
    ask, own = now.predicted_residuals(), now.views.own
    batch = own + np.random.default_rng(0).normal(0, 2, (2, 3, *own.shape))
    for by in (None, "epipolar"):
        together = ask(batch, by)
        for index in np.ndindex(2, 3):
            np.testing.assert_allclose(together[index], ask(batch[index], by), atol=1e-8)


def test_residuals_use_the_points_of_a_moving_demonstrator_at_the_next_look():
    now = Session(Settings.paper(transfer="linear")).snapshot
    drift = np.random.default_rng(0).normal(0, 3.0, now.views.demo.shape)
    ahead = now.with_fields(views=type(now.views)(now.views.demo + drift, now.views.own, now.views.visible))
    np.testing.assert_allclose(now.predicted_residuals(drift)(now.views.own), ahead.e)


def test_behind_a_moving_demonstrator_with_noise_the_converged_transfer_is_used():
    first = Session(Settings.paper(transfer="linear", start_deg=(25, -45)))
    then = first.snapshot.transfer
    now = first.run().last.with_fields(converged_transfer=then)
    own, drift = now.views.own, np.ones_like(now.views.demo)

    def of_frozen(by_px):
        return own - then.recover(now.views.demo_left + by_px, now.views.demo_right + by_px)

    np.testing.assert_allclose(now.predicted_residuals(drift, noise_px=0.5)(own), of_frozen(1.0))
    assert not np.allclose(now.predicted_residuals(drift, noise_px=0.5)(own, "epipolar"), of_frozen(1.0), atol=0.1)
    assert not np.allclose(now.predicted_residuals(drift)(own), of_frozen(1.0), atol=0.1)
    assert not np.allclose(now.predicted_residuals(noise_px=0.5)(own), of_frozen(0.0), atol=0.1)
