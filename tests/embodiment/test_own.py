"""A session with an arm and eyes of one's own: it needs postures and looks, and nothing else."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from viewimit import FourViews, Session
from viewimit.analysis.self_assessment import assess
from viewimit.estimation.transfers import TRANSFERS
from viewimit.loop.self_calibration import SelfCalibration
from viewimit.loop.settings import Settings
from viewimit.sensing.frames import MAX_LATENCY_LOOKS
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World

ONE = Settings(frames=1)
DEMO = np.radians((45.0, -90.0))


class Robot:
    """Arm and eyes before the shipped scene, of which the session is not told. late: pictures a look lags behind."""

    noise_px = 0.0

    def __init__(self, demo=DEMO, noise_px=0.0, late=0, offset=0.0, points=10):
        self.world, self.rng = World(load_scene("panda"), points), np.random.default_rng(0)
        self.lower, self.upper = self.world.scene.lower, self.world.scene.upper
        self.start, self.demo = np.radians((25.0, -45.0)), demo
        self.sigma, self.late, self.offset = noise_px, late, offset
        self.sent, self.pictures, self.looks = [], [], 0
        self.hidden = ()

    def move(self, theta):
        self.sent.append(theta)
        return theta + self.offset

    def look(self):
        self.looks += 1
        stands = self.sent[-1] if self.sent else self.start
        self.pictures.append(self.world.look(self.demo, stands))
        seen = self.pictures[max(len(self.pictures) - 1 - self.late, 0)]
        own, demo = (image + self.sigma * self.rng.standard_normal(image.shape) for image in (seen.own, seen.demo))
        visible = seen.visible.copy()
        visible[list(self.hidden)] = False
        return FourViews(demo, own, visible)


def session(robot, settings=ONE, **options):
    return Session.of(robot, robot, **options, **msgspec.structs.asdict(settings))


def error_deg(last, demo=DEMO):
    return np.degrees(np.abs(last.commanded - demo)).max()


def test_it_makes_the_same_run_as_a_session_that_knows_the_scene():
    one, other = (
        session(Robot()),
        Session(msgspec.structs.replace(ONE, demonstrator_deg=(45, -90), start_deg=(25, -45))),
    )
    last, known = one.run(60).last, other.run(60).last
    assert last.status == known.status == "converged" and last.motion == known.motion
    np.testing.assert_allclose(last.theta, known.theta, atol=1e-9)
    assert last.certificate.observable.all() and assess(one).certificate is last.certificate
    assert last.certificate.simultaneous_std_error == pytest.approx(known.certificate.simultaneous_std_error, rel=1e-3)


def test_nobody_knows_where_the_demonstrator_is_and_there_is_no_scene():
    one = session(Robot(), name="mine")
    assert np.isnan(one.snapshot.theta_demo).all() and one.settings.demonstrator_deg is None
    assert one.settings.scene == "mine" and one.settings.points == 10
    for ask in (lambda: one.world, lambda: one.scene, lambda: one.eyes):
        with pytest.raises(ValueError, match="no scene, no world and no truth"):
            ask()
    with pytest.raises(ValueError, match=r"session\.look\(\)"):
        one.pose(DEMO)


@pytest.mark.parametrize("offset", [0.0, 0.02])
def test_the_arm_is_sent_where_the_learner_wants_and_stands_where_it_says(offset):
    robot = Robot(offset=offset)
    one = session(robot)
    one.run(20)
    np.testing.assert_array_equal(robot.sent, [moment.commanded for moment in one.history])
    np.testing.assert_allclose([m.theta - m.commanded for m in one.history], offset, atol=1e-12)
    assert all(((robot.lower <= theta) & (theta <= robot.upper)).all() for theta in robot.sent)


def test_a_demonstrator_that_has_moved_is_seen_and_imitated_anew():
    robot = Robot()
    one = session(robot)
    assert one.run(60).status == "converged" and not one.look() and one.snapshot.status == "converged"
    assert not one.step()
    robot.demo = np.radians((60.0, -60.0))
    assert one.look() and one.snapshot.status == "moving"
    assert error_deg(one.run(120).last, robot.demo) < 0.5 and one.snapshot.status == "converged"


def test_a_demonstrator_that_keeps_moving_is_followed():
    robot = Robot()
    one = session(robot)
    one.run(60)
    away = []
    for k in range(1, 31):
        robot.demo = DEMO + np.radians((0.5, 1.0)) * k
        one.look()
        one.step()
        away.append(error_deg(one.snapshot, robot.demo))
    assert max(away[3:]) < 1.1  # a degree a motion: as far ahead as it looks


def test_noise_keeps_the_demonstrators_images_and_is_measured_at_rest():
    robot = Robot(noise_px=0.3, points=20)
    one = session(robot, Settings(frames=9))
    assert one.observer.image_noise_std(one.settings) == pytest.approx(0.3 / 3, rel=0.25)  # 560 degrees of freedom
    one.run(60)
    assert all(moment.views.demo is one.history[0].views.demo for moment in one.history)
    assert not one.look() and error_deg(one.snapshot) < 1.0
    assert one.observer.image_noise_std(Settings(frames=1)) == pytest.approx(0.3, rel=0.25)
    robot.noise_px = 4.0  # as its maker states it
    one.reset()
    assert one.observer.image_noise_std(one.settings) == pytest.approx(4 / 3, rel=0.05)


class WholePixels(Robot):
    """Its tracker gives whole pixels."""

    def look(self):
        seen = super().look()
        return FourViews(np.round(seen.demo), np.round(seen.own), seen.visible)


@pytest.mark.parametrize("frames", [1, 25])
def test_rounding_is_noise_that_pictures_at_rest_do_not_show_and_that_more_of_them_do_not_lessen(frames):
    settings = Settings(frames=frames)
    for sigma in (0.0, 0.1):
        one = session(WholePixels(noise_px=sigma), settings)
        assert one.observer.image_noise_std(one.settings) == pytest.approx(1 / np.sqrt(12), rel=0.1)
    mixed = session(WholePixels(noise_px=2.0, points=20), settings)  # noise of steps and more is averaged, as any is
    assert mixed.observer.image_noise_std(mixed.settings) == pytest.approx(2 / np.sqrt(frames), rel=0.25)


@pytest.mark.parametrize("noise_px", [pytest.param(0.0, marks=pytest.mark.slow), 0.2])
def test_whole_pixels_are_believed_and_the_learner_arrives_as_near_as_they_tell(noise_px):
    """A point that does not move is rounded alike at each visit: taken for independent noise, claims are false."""
    for seed in range(2):
        start, demo = np.radians(np.random.default_rng(seed).uniform((0, -140), (90, -40), (2, 2)))
        robot = WholePixels(demo, noise_px, points=16)
        robot.start = start
        one = session(robot)
        last = one.run(40).last
        assert all(moment.views.complete for moment in one.history)
        assert last.status.is_at_rest and error_deg(last, demo) < 2.5
        assert not last.status.is_claim or error_deg(last, demo) < 3 * np.degrees(last.expected_error)


@pytest.mark.parametrize("late", range(MAX_LATENCY_LOOKS + 1))
def test_the_first_motion_tells_how_late_pictures_come_and_as_many_are_let_pass(late):
    robot = Robot(late=late)
    one = session(robot)
    last = one.run(60).last
    assert last.lag == late and last.status == "converged" and error_deg(last) < 0.5
    for moment in one.history:
        np.testing.assert_array_equal(moment.views.own, robot.world.own_images(moment.commanded)[0])


def test_points_that_are_not_seen_hold_the_arm_and_more_points_of_the_demonstrator_are_taken():
    robot = Robot()
    robot.hidden = range(6)
    one = session(robot)
    sent = len(robot.sent)
    assert one.run(patience=3).status == "too-few-points" and len(robot.sent) == sent
    robot.hidden = (0,)
    assert one.step() and one.snapshot.usable.sum() == 9
    robot.hidden = ()
    assert one.step() and one.snapshot.usable.sum() == 10
    assert one.run(60).status == "converged"


def test_it_rehearses_without_a_demonstrator_and_begins_with_that(tmp_path):
    robot = Robot(demo=DEMO)
    one = session(robot, name="mine")
    body = one.calibrate(12, seed=0)
    body.save(tmp_path / "body.npz")
    other = session(Robot(), name="mine")
    other.use_calibration(SelfCalibration.load(tmp_path / "body.npz"))
    last = other.run(60).last
    assert last.status == "converged" and last.calibration_holds and last.motion < session(Robot()).run(60).last.motion
    with pytest.raises(ValueError, match="rehearsed with robot mine, here it is yours"):
        session(Robot(), name="yours").use_calibration(body)


@pytest.mark.parametrize(
    "fields",
    [{"noise_px": 0.1}, {"sensor": "rendered"}, {"demonstrator_deg": (45, -90)}, {"joints": (1, 2)}, {"delay": 1}],
    ids=str,
)
def test_what_only_a_scene_has_is_refused_and_all_stays(fields):
    robot = Robot()
    with pytest.raises(ValueError, match=f"{next(iter(fields))} is of a simulated scene"):
        session(robot, msgspec.structs.replace(ONE, **fields))
    assert not robot.sent
    one = session(robot)
    before, sent = one.snapshot, len(robot.sent)
    with pytest.raises(ValueError, match="is of a simulated scene"):
        one.change(**fields)
    assert one.snapshot is before and len(robot.sent) == sent


@pytest.mark.parametrize(
    "field, value, says",
    [
        ("lower", np.zeros(3), "limits must be finite angles in rad, one a joint"),
        ("lower", np.array([0.0, np.nan]), "limits must be finite"),
        ("lower", np.array((-60.0, -180.0)), r"limits must be in rad: .* are beyond 4 turns"),
        ("lower", np.radians((95.0, -180.0)), "joint 1: limits 95° … 90° are empty"),
        ("start", np.radians((25.0, 10.0)), "the start joint 2 at 10° is outside its limits -180° … 0°"),
        ("start", np.zeros(3), "the start posture needs 2 angles, got 3"),
        ("lower", ["a", "b"], "limits must be finite angles in rad"),
        ("start", "home", "the start posture needs 2 angles, got home"),
        ("move", lambda theta: None, r"move\(\) must return where the arm stands, 2 finite angles in rad, got None"),
        ("move", lambda theta: [0.4, [0.1]], r"move\(\) must return where the arm stands, 2 finite angles"),
        ("move", np.degrees, r"move\(\) must return where the arm stands, in rad: .* is beyond its limits by a turn"),
        ("noise_px", np.nan, "noise_px must be a finite number of pixels from 0, got nan"),
        ("noise_px", -0.1, "noise_px must be a finite number of pixels from 0, got -0.1"),
        ("noise_px", None, "noise_px must be a finite number of pixels from 0, got None"),
        ("look", lambda: None, r"look\(\) must return FourViews of N points"),
    ],
)
def test_an_arm_or_eyes_that_cannot_be_are_told_so(field, value, says):
    robot = Robot()
    setattr(robot, field, value)
    with pytest.raises(ValueError, match=says):
        session(robot)


@pytest.mark.parametrize(
    "arm, eyes, says",
    [
        (None, Robot(), "the arm, None, has no lower and no upper and no start and no move: viewimit.Arm says"),
        (
            Robot(),
            object(),
            "the eyes, .*, has no noise_px and no look: viewimit.Eyes says what to write, noise_px, look",
        ),
        (Robot, Robot(), r"the arm: Robot is a class; make one, Robot\(…\)"),
    ],
)
def test_what_is_no_arm_or_no_eyes_is_told_what_it_lacks(arm, eyes, says):
    with pytest.raises(TypeError, match=says):
        Session.of(arm, eyes)


@pytest.mark.parametrize(
    "field, wrong, says",
    [
        ("own", lambda own: own[:-1], r"its own is of shape \(9, 4\), float64"),
        ("demo", lambda demo: demo[:, :3], r"its demo is of shape \(10, 3\), float64"),
        ("demo", np.ndarray.tolist, "its demo is a list"),
        ("own", lambda own: own + 0j, r"its own is of shape \(10, 4\), complex128"),
        ("visible", lambda visible: visible[:, 0], r"its visible is of shape \(10,\), bool"),
        ("visible", lambda visible: 0.3 * visible, r"its visible is of shape \(10, 4\), float64"),
        ("visible", lambda visible: visible.astype(int), r"its visible is of shape \(10, 4\), int64"),
    ],
)
def test_looks_of_another_shape_or_kind_are_told_so(field, wrong, says):
    robot = Robot()
    seen = robot.look
    robot.look = lambda: replace(views := seen(), **{field: wrong(getattr(views, field))})
    with pytest.raises(ValueError, match=rf"look\(\) must return FourViews of N points, .*: {says}"):
        session(robot)
    assert not robot.sent


def test_looks_that_do_not_match_the_first_are_told_so():
    robot = Robot()
    one, whole = session(robot), robot.look
    robot.look = lambda: whole().select(np.arange(9))
    with pytest.raises(ValueError, match="9 points, at first 10: they are matched by index"):
        one.step()
    robot.look = lambda: whole().with_own(np.full((10, 4), np.nan))
    with pytest.raises(ValueError, match="visible whose coordinates are not finite"):
        one.step()


OTHERS = [pytest.param(name, marks=pytest.mark.slow) for name in TRANSFERS if name != "projective"]


@pytest.mark.parametrize("place", [(-1, -1), (1e5, 1e5)], ids=str)
@pytest.mark.parametrize("transfer", ["projective", *OTHERS])
def test_points_that_a_tracker_has_lost_are_not_seen(transfer, place):
    """One in ten, by turns, of either body: a loop that took them for seen fits them, and at 1e5 px claims falsely."""
    settings = Settings.paper(transfer=transfer, servo="likelihood", frames=1)
    told, marked = Robot(points=16), Robot(points=16)

    def marking(robot, mark):
        whole, rng = robot.look, np.random.default_rng(0)

        def look():
            views, hit = whole(), rng.random((16, 2)) < 0.1  # of the demonstrator, of the own body
            demo, own = (np.where(of[:, None], np.tile(mark, 2), im) for of, im in zip(hit.T, (views.demo, views.own)))
            return FourViews.from_images(demo[:, :2], demo[:, 2:], own[:, :2], own[:, 2:])

        return look

    told.look, marked.look = marking(told, (np.nan, np.nan)), marking(marked, place)
    expected, last = session(told, settings).run(60).last, session(marked, settings).run(60).last
    assert last.status == expected.status
    np.testing.assert_array_equal(last.commanded, expected.commanded)


@pytest.mark.parametrize("transfer", ["projective", *OTHERS])
@pytest.mark.parametrize("own", [np.zeros((10, 4)), np.outer(np.arange(10.0), (1, 2, 1, 3))], ids=["place", "line"])
def test_a_body_whose_points_are_lost_to_one_place_is_no_evidence(transfer, own):
    """As trackers write what they have lost; E of it would be 0 wherever the arm is."""
    settings = Settings.paper(transfer=transfer, servo="likelihood")
    robot, whole = Robot(), Robot()
    seen, expected = robot.look, session(whole, settings).run(60).last
    robot.look = lambda: seen().with_own(own) if robot.looks == 13 else seen()
    last = session(robot, settings).run(60).last
    assert np.degrees(np.abs(last.commanded - expected.commanded)).max() < 0.5 and last.status == expected.status
    robot.look = lambda: seen().with_own(own)
    held = session(robot, settings)
    assert not held.step() and held.snapshot.status == "too-few-points" and np.isnan(held.snapshot.E)
