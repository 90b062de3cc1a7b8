"""What a learner tells of its posture agrees with what the simulation knows, though it is told none of it."""

import numpy as np
import pytest

from viewimit.analysis.observability import joint_uncertainty
from viewimit.analysis.self_assessment import assess
from viewimit.drawing.status import describe
from viewimit.loop.history import History
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings


def rested(settings):
    session = Session(settings)
    session.run(400)
    return session


@pytest.mark.parametrize(
    "settings",
    [
        Settings.paper(),
        Settings.paper(transfer="linear", start_deg=(75, -150)),
        Settings.paper(scene="panda-verged", start_deg=(25, -45)),
        Settings.paper(scene="panda-facing", start_deg=(25, -45)),
        Settings.paper(scene="iiwa", start_deg=(25, -25)),
    ],
    ids=lambda settings: f"{settings.scene} {settings.transfer}",
)
def test_what_a_pixel_costs_is_known_from_the_own_motions(settings):
    session = rested(settings)
    now = session.snapshot
    views = now.views
    true = joint_uncertainty(session.world, now.fit, views.demo, views.visible[:, :2], now.theta)
    assert assess(session).std_per_px == pytest.approx(true, rel=0.1)


@pytest.mark.parametrize("noise_px, seed", [(0.5, 13), (0.25, 1)])
def test_what_the_visits_under_noise_leave_open_is_not_said_of_the_points(noise_px, seed):
    session = rested(Settings.paper(noise_px=noise_px, seed=seed, start_deg=(25, -45)))
    now, found = session.snapshot, assess(session)
    views = now.views
    true = joint_uncertainty(session.world, now.fit, views.demo, views.visible[:, :2], now.theta)
    assert (true < np.radians(3)).all() and (found is None or found.unobservable == [])
    assert describe(now, assessment=found, joints=(2, 4)).state == now.status


def test_only_an_E_that_leaves_no_room_is_a_claim():
    sure, bent = rested(Settings()), rested(Settings.paper(scene="panda-facing", start_deg=(25, -45)))
    off = np.abs(bent.snapshot.theta - bent.snapshot.theta_demo).max()
    found = assess(bent)
    assert sure.snapshot.status == "converged" and assess(sure).max_displacement < np.radians(0.3)
    assert bent.snapshot.status == "settled" and found.at_local_minimum and off < found.max_displacement


@pytest.mark.parametrize("points", [5, 10])
def test_the_assessment_of_a_servo_that_knows_is_its_own(points):
    """What the page says of a posture can be nothing else than what the servo claims."""
    session = rested(Settings(points=points))
    assert assess(session).certificate is session.snapshot.certificate


def test_it_is_told_no_posture():
    """Only what was seen, and how far it has moved itself."""
    session = rested(Settings())
    expected = assess(session)
    unknown = np.full(2, np.nan)
    hidden = [moment.with_fields(theta=unknown, theta_demo=unknown) for moment in session.history]
    session.history = History(hidden, session.cursor)
    found = assess(session)
    assert found.max_displacement == expected.max_displacement and (found.std_per_px == expected.std_per_px).all()
