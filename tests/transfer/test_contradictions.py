"""What one camera shows of a point and the other contradicts is rejected; what agrees is left as it is."""

import msgspec
import numpy as np
import pytest

from viewimit.estimation.outliers import reject_outliers
from viewimit.estimation.views import FourViews
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.simulation.disturbances import OUTLIER_PX

ONE_FRAME = Settings(points=16, frames=1)


def spoilt(views, rng, share):
    """Points moved in one image each; which of them, (2 bodies, N)."""
    wrong = rng.random((2, len(views.own))) < share
    moved = [images.copy() for images, _ in views.bodies]
    for images, these in zip(moved, wrong):
        images[these, 2:] += rng.uniform(-OUTLIER_PX, OUTLIER_PX, (these.sum(), 2))
    return FourViews(*moved, views.visible), wrong


def reject(views, moments, noise_px, seed):
    return reject_outliers(views, [moment.views for moment in moments], moments[-1].rectification, noise_px, seed)


@pytest.mark.parametrize("scene", ["panda", "panda-toed", "panda-verged", "panda-facing"])
@pytest.mark.parametrize("noise_px", [0.0, 0.25])
def test_a_look_that_agrees_with_itself_and_those_before_is_the_very_same(scene, noise_px):
    settings = msgspec.structs.replace(ONE_FRAME, scene=scene, noise_px=noise_px)
    moments = list(Session(settings).history)
    session = Session(settings)
    session.run(8)
    for now in session.history:
        assert reject(now.views, moments, noise_px, now.look) is now.views
        moments.append(now)


@pytest.mark.parametrize("scene", ["panda", "panda-toed"])
def test_points_that_are_moved_out_of_their_epipolar_lines_are_unseen_in_both_images(scene):
    session = Session(msgspec.structs.replace(ONE_FRAME, scene=scene, points=20))
    session.run(6)
    moments, rng = list(session.history), np.random.default_rng(3)
    views, wrong = spoilt(moments[-1].views, rng, 0.15)
    told = reject(views, moments[:-1], 0.0, 9)
    unseen = np.stack([~told.visible[:, :2].any(-1), ~told.visible[:, 2:].any(-1)])
    assert wrong.sum() >= 4 and np.array_equal(unseen, wrong)
    assert np.array_equal(told.demo, views.demo) and views.visible.all()


def test_with_every_tenth_point_at_a_wrong_place_in_a_single_frame_the_learner_arrives():
    """Of 90 runs with 10, 16 and 20 points 97, 97 and 93 % were within 0.5°; without this step none of 40."""
    ended = []
    for seed in range(6):
        start, demo = np.random.default_rng(seed).uniform((0, -140), (90, -40), (2, 2)).tolist()
        last = (
            Session(
                msgspec.structs.replace(
                    ONE_FRAME, outliers=0.1, seed=seed, start_deg=tuple(start), demonstrator_deg=tuple(demo)
                )
            )
            .run(80, 20)
            .last
        )
        ended.append(np.degrees(np.abs(last.theta - last.theta_demo).max()))
    assert sum(error < 0.5 for error in ended) >= 5
