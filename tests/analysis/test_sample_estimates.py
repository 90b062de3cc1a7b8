"""Where E is least under noise: as theory has it of small noise, at a minimum each time, and nearer the more images."""

import numpy as np
import pytest

from viewimit.analysis.observability import joint_uncertainty, sample_estimates
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings

RUNS = 400
SESSION = Session(Settings.paper(transfer="projective", points=16, demonstrator_deg=(45, -90)))
MOMENT = SESSION.snapshot
WORLD, DEMO = SESSION.world, MOMENT.theta_demo


def found(noise_px, frames=1, runs=RUNS, seed=3, **more):
    return sample_estimates(WORLD, MOMENT.fit, DEMO, noise_px, frames, runs, np.random.default_rng(seed), **more)


def test_without_noise_it_is_the_demonstrators_posture():
    assert np.abs(found(0.0, runs=2) - DEMO).max() < np.radians(1e-3)


def test_noise_of_the_own_images_alone_costs_what_the_curvature_of_E_tells():
    """An independent way: √diag((JᵀJ)⁻¹), of the linear transfer, whose residual is a projection of the own images."""
    session = Session(Settings.paper(transfer="linear", demonstrator_deg=(45, -90)))
    moment, noise_px = session.snapshot, 0.02
    rng = np.random.default_rng(1)
    theta = sample_estimates(session.world, moment.fit, DEMO, noise_px, 1, RUNS, rng, noisy_demo=False)
    views = moment.views
    about = theta.mean(0)
    told = joint_uncertainty(session.world, moment.fit, views.demo, views.visible[:, :2], about)
    assert theta.std(0) / noise_px == pytest.approx(told, rel=4 / np.sqrt(2 * RUNS))


def test_averaged_images_bring_the_postures_nearer_by_the_root_of_their_number():
    one, nine = found(0.2), found(0.2, frames=9, seed=4)
    assert one.std(0) / nine.std(0) == pytest.approx(np.full(2, 3.0), rel=4 / np.sqrt(RUNS))


def test_a_point_out_of_sight_is_refused():
    rng = np.random.default_rng(0)
    world = Session(Settings.paper(demonstrator_deg=(45, -90))).world
    world.own_images = lambda theta: (np.zeros((10, 4)), np.zeros((10, 2), bool))
    with pytest.raises(ValueError, match="all points must be in all four images"):
        sample_estimates(world, MOMENT.fit, DEMO, 0.5, 1, 2, rng)
