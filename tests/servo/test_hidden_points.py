"""Where surfaces hide points, another set at every posture: what is known of them leads on."""

import numpy as np
from sameness import error_deg

from viewimit.experiments.bench.draws import SurfaceEyes, surface_points
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.simulation.scene import load_scene


def session_with(seed, **settings):
    """20 points anywhere on the arms, hidden a little beyond the rim; enough in sight at the start."""
    rng = np.random.default_rng(seed)
    low, high = np.transpose(load_scene(Settings().scene).range_deg)
    demo, start = map(tuple, rng.uniform(low, high, (2, len(low))).tolist())
    chosen = Settings(demonstrator_deg=demo, start_deg=start, **settings)

    def eyes(camera, scene, points):
        return SurfaceEyes(scene, *surface_points(scene.robot, range(8), 20, rng), -0.3)

    while (session := Session(chosen, open_eyes=eyes)).snapshot.transfer is None:
        pass
    return session


def test_points_that_tell_too_little_send_the_learner_to_where_others_are_seen():
    """The five points in sight at first fit a posture that is far off: E is next to 0 there."""
    session = session_with([900, 10])
    last = session.run(60).last
    assert last.status == "converged" and error_deg(last) < 0.1
    assert last.usable.sum() > session.history[0].usable.sum()


def test_where_the_arm_stands_at_the_predicted_minimum_already_the_search_goes_on():
    """There is no step left to make, but E is small only where fewer points are seen."""
    last = session_with([900, 65]).run(60).last
    assert last.status.is_at_rest and error_deg(last) < 0.1


def test_where_too_few_own_points_are_seen_a_servo_that_predicts_goes_on_and_others_hold_still():
    session = session_with([900, 61])
    while session.snapshot.transfer is not None:
        assert session.step()
    assert session.snapshot.views.visible[:, :2].all(-1).sum() >= 5 and session.snapshot.motion == 1
    other = session.copy()
    other.change(servo="broyden")
    assert not other.step() and other.snapshot.status == "too-few-points"
    last = session.run(80).last
    assert last.status == "converged" and error_deg(last) < 0.1
