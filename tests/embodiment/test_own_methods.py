"""A transfer that is a plain function, and a servo with two methods, given to a session: all else has defaults."""

from dataclasses import dataclass

import numpy as np
import pytest

from viewimit import TRANSFERS, Session, Settings, conflict, replay
from viewimit.drawing.export.citation import cite
from viewimit.estimation.transfers import linear
from viewimit.loop.settings import OWN
from viewimit.servo import GaussNewton

START = {"demonstrator_deg": (45, -90), "start_deg": (25, -45)}


@dataclass
class Fitted:
    """What a newcomer writes: no base class, no batch, nothing but `recover`."""

    matrix: np.ndarray

    def recover(self, demo_left, demo_right):
        return np.hstack([demo_left, demo_right, np.ones((len(demo_left), 1))]) @ self.matrix


def affine_map(views):
    """Of one posture."""
    demo = np.hstack([views.demo_left, views.demo_right, np.ones((len(views.demo_left), 1))])
    assert demo.ndim == 2
    return Fitted(np.linalg.lstsq(demo, np.hstack([views.own_left, views.own_right]), rcond=None)[0])


class Law:
    """Damped Gauss-Newton, of which no more is told than needed."""

    def start(self, seen):
        return GaussNewton().start(seen)

    def step(self, state, seen, residuals):
        return GaussNewton().step(state, seen, residuals)


class Still:
    """Wants no motion, and says nothing of itself."""

    def start(self, seen):
        return {"asked": 0}

    def step(self, state, seen, residuals):
        return {"asked": state["asked"] + 1}, np.zeros_like(seen.displacement)


def test_the_E_of_a_plain_function_is_that_of_eq_6():
    now = Session(Settings.paper(**START), transfer=affine_map).snapshot
    demo = np.hstack([now.views.demo, np.ones((10, 1))])
    e = now.views.own - demo @ np.linalg.pinv(demo) @ now.views.own
    assert now.E == pytest.approx((e**2).sum() / 20, rel=1e-9)
    np.testing.assert_allclose(now.e, e, atol=1e-6)
    assert now.settings.transfer == OWN and now.method.title == "affine_map"


def test_a_function_that_does_what_a_named_transfer_does_leads_the_arm_the_same_way():
    named = Session(Settings.paper(**START, transfer="linear"))
    own = Session(Settings.paper(**START), transfer=lambda views: linear.fit(views))
    for session in (named, own):
        session.run(30)
    assert named.snapshot.motion == own.snapshot.motion > 3
    np.testing.assert_allclose(own.snapshot.theta, named.snapshot.theta, atol=1e-9)


def test_a_transfer_of_ones_own_serves_rectified_images_and_every_servo():
    for scene, servo in (("panda", "likelihood"), ("panda-toed", "likelihood"), ("panda", "gradient-retuned")):
        session = Session(Settings(scene=scene, servo=servo, **START), transfer=affine_map)
        assert session.snapshot.E > 0 and (session.snapshot.rectification is None) == (scene == "panda")
        before = session.snapshot.E
        session.run(20)
        assert session.snapshot.E < before


def test_a_servo_of_two_methods_moves_as_the_whole_one_does():
    own, named = Session(Settings(**START), servo=Law()), Session(Settings(**START, servo="gauss-newton"))
    for session in (own, named):
        session.run(30)
    assert own.snapshot.status == named.snapshot.status and own.snapshot.motion == named.snapshot.motion
    np.testing.assert_array_equal(own.snapshot.theta, named.snapshot.theta)
    own.pose(np.radians((40, -80)))  # it starts afresh
    assert own.step() and own.snapshot.probe


def test_a_servo_without_a_status_that_wants_no_motion_rests():
    session = Session(Settings(**START), servo=Still())
    assert not session.step()
    assert session.snapshot.status == "settled" and session.snapshot.servo_state == {"asked": 1}


def test_both_are_drawn_in_a_replay_and_go_on_in_a_copy_and_in_another_session():
    session = Session(Settings.paper(**START), transfer=affine_map, servo=Law())
    session.run(3)
    page = replay(session)
    assert "affine_map, Law" in page.html and cite(session).python is None and cite(session).command is None
    assert session.copy().snapshot.method.title == "affine_map"
    other = Session()
    other.resume(session.history, session.cursor)
    for each in (session, other):
        each.run(8)
    np.testing.assert_array_equal(other.snapshot.theta, session.snapshot.theta)
    other.begin(session.settings)  # it has them now
    assert other.snapshot.method is session.snapshot.method


def test_what_holds_neither_functions_nor_objects_says_so():
    session = Session(Settings.paper(**START), transfer=affine_map, servo=Law())
    session.step()
    with pytest.raises(ValueError, match="of your own, which no script, link or file can hold"):
        _ = session.script
    changed = Session(transfer=affine_map)
    changed.begin(Settings(**START))
    assert changed.script.settings.transfer == "projective"
    changed.change(transfer=OWN)
    with pytest.raises(ValueError, match="of your own, which no script, link or file can hold"):
        _ = changed.script
    with pytest.raises(ValueError, match=r"transfer 'own' is one of your own.*Session\(settings, transfer=…\)"):
        Session(session.settings)


def test_a_session_changes_from_its_own_to_a_named_one_and_back():
    session = Session(Settings.paper(**START), transfer=affine_map, servo=Law())
    E = session.snapshot.E
    session.change(transfer="projective", servo="broyden")
    assert session.snapshot.method is TRANSFERS["projective"] and session.step()
    session.undo()
    session.change(transfer=OWN, servo=OWN)
    assert session.snapshot.E == E and session.step()
    with pytest.raises(ValueError, match="servo 'own' is one of your own"):
        Session(Settings(**START)).change(servo=OWN)
    with pytest.raises(ValueError, match=r"transfer must be text.*Session\(settings, transfer=…\)"):
        session.change(transfer=affine_map)


@pytest.mark.parametrize(
    "given, error, said",
    [
        ({"transfer": 3}, TypeError, "a transfer is a function of FourViews or a TransferMethod, got 3"),
        ({"transfer": lambda views: None}, TypeError, r"must return an object with recover\(demo_left, demo_right\)"),
        ({"transfer": "magic"}, ValueError, "no transfer 'magic'"),
        ({"servo": Law}, TypeError, r"the servo Law is a class; make one, Law\(…\)"),
        ({"servo": object()}, TypeError, r"has no start\(observation\) and no step\(state, observation, residuals\)"),
        ({"settings": "panda"}, TypeError, r"settings must be Settings\(…\), got 'panda'"),
    ],
)
def test_what_cannot_be_one_is_refused_at_once(given, error, said):
    with pytest.raises(error, match=said):
        Session(**given)


def test_points_of_another_shape_and_motions_that_are_none_are_named():
    class Wrong(Fitted):
        def recover(self, demo_left, demo_right):
            return super().recover(demo_left, demo_right)[:, :2]

    with pytest.raises(ValueError, match=r"'wrong': recover must return \(10, 4\) px in \[L, R\], got .*10, 2"):

        def wrong(views):
            return Wrong(affine_map(views).matrix)

        Session(transfer=wrong)

    class Mover(Still):
        def __init__(self, motion):
            self.motion = motion

        def step(self, state, seen, residuals):
            return state, self.motion

    for motion in (0.1, [0.1, 0.2, 0.3], [np.nan, 0.0]):
        with pytest.raises(ValueError, match="the servo 'Mover' must return its state and 2 finite angles in rad"):
            Session(servo=Mover(motion)).step()
    law = Mover(None)
    law.step = lambda state, seen, residuals: state
    with pytest.raises(TypeError, match="the servo 'Mover' must return its state and its motion"):
        Session(servo=law).step()
    law = Mover([0.1, 0.0])
    law.start = lambda seen: type("State", (), {"status": "busy"})()
    with pytest.raises(
        ValueError, match="status must be one of moving, converged, settled, unobservable, no-progress, got 'busy'"
    ):
        Session(servo=law).step()


class Resting(Still):
    """Rests at once with a state of one's own."""

    def __init__(self, state):
        self.state = state

    def step(self, state, seen, residuals):
        return self.state, np.zeros_like(seen.displacement)


def test_a_servo_cannot_claim_to_have_converged_without_a_certificate():
    converged = type("State", (), {"status": "converged"})()
    with pytest.raises(ValueError, match="'converged', but its state has no certificate: report 'settled'"):
        Session(Settings(**START), servo=Resting(converged)).step()


class Asking:
    """Goes to random postures, and keeps what it observes and the residuals of that."""

    def __init__(self):
        self.asked = []

    def start(self, seen):
        return 0

    def step(self, state, seen, residuals):
        self.asked.append((seen, residuals(seen.own), residuals(np.stack([seen.own, seen.own + 1]))))
        goal = np.random.default_rng(state).uniform(seen.lower, seen.upper)
        return state + 1, goal - seen.displacement


@pytest.mark.parametrize("transfer, coordinates", [("projective", 4), ("epipolar", 4), ("rank3", 8)])
@pytest.mark.parametrize("changes", [{}, {"missing": 0.1, "points": 16, "frames": 1}])
def test_residuals_of_the_observed_images_have_one_shape_and_make_the_observed_E(transfer, coordinates, changes):
    asking = Asking()
    Session(Settings(transfer=transfer, **START, **changes), servo=asking).run(25)
    for seen, e, batch in asking.asked:
        assert np.isnan(seen.own).any() == (not seen.seen.all())
        assert batch.shape == (2, *e.shape) and e.shape[1] == coordinates
        assert conflict(e) == pytest.approx(seen.E, rel=1e-6)
    assert len(asking.asked) > 9


def test_a_transfer_that_gives_nan_and_a_class_that_does_not_fit_are_named():
    class Nowhere:
        def recover(self, demo_left, demo_right):
            return np.full((len(demo_left), 4), np.nan)

    with pytest.raises(ValueError, match="the transfer '<lambda>' maps visible points to NaN"):
        Session(Settings(**START), transfer=lambda views: Nowhere())
    with pytest.raises(TypeError, match=r"'Fitted' is a class, and Fitted\(views\) cannot recover points: give a func"):
        Session(Settings(**START), transfer=Fitted)

    class Fitting(Fitted):
        def __init__(self, views):
            super().__init__(affine_map(views).matrix)

    assert Session(Settings.paper(**START), transfer=Fitting).step()
