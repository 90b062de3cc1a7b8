"""A demonstrator that is no body like the own one: the reason is named, and another body's joint angles are found."""

import sys
from pathlib import Path

import msgspec
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from viewimit import Session, Settings
from viewimit.estimation.views import FourViews, permute
from viewimit.experiments.bench.demonstrators import OtherDemonstrator, StopsShort, stretched
from viewimit.geometry.kinematics.clusters import Observations
from viewimit.geometry.kinematics.own_body import exact_body
from viewimit.servo import Misfit, MisfitKind, Observation
from viewimit.servo.estimator.hypotheses import CLEAR
from viewimit.servo.estimator.reasons import explain
from viewimit.servo.estimator.swaps import swapped, transpositions, with_swaps
from viewimit.simulation.eyes import SimulatedEyes

sys.path.append(str(Path(__file__).parent.parent / "geometry" / "kinematics"))
from turning_body import TurningBody, seen  # noqa: E402

NOISE_PX, TRUTH, MIDDLE = 0.05, np.array([0.3, -0.4]), np.array([0.1, 0.0, 1.6])
ON = np.repeat([0, 1, 2], 6)
NOISY = {"noise_px": 0.25, "frames": 25, "points": 16}
SEEDS = pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2))])


def body_of(seed):
    return TurningBody(np.random.default_rng(seed), tuple(ON), 2)


def explained(seed, places=None, head=seen):
    """places: of the demonstrator's points before the head, (N, 3) m."""
    rng, body = np.random.default_rng([2, seed]), body_of(seed)
    noise = lambda: NOISE_PX * rng.standard_normal((len(ON), 4))
    shown = np.vstack([body.probes(0.4), rng.uniform(-0.7, 0.7, (5, 2))])
    own = np.array([body.images(one) + noise() for one in shown])
    visible = np.ones(own.shape[:2], bool)
    turn = Rotation.from_rotvec([0.1, 0.4, 0.05]).as_matrix()
    places = body.places(TRUTH) if places is None else places
    demo = head((places - MIDDLE) @ turn.T + MIDDLE + (-0.2, 0.1, 0.3)) + noise()
    limits = np.full(2, 1.5)
    both = np.repeat(visible[-1, :, None], 2, -1)
    observation = Observation(own[-1], both, 1.0, shown[-1], -limits, limits, 8, NOISE_PX, demo=demo)
    visits = Observations(shown, own, visible)
    return explain(exact_body(visits, NOISE_PX).kinematics, visits, observation, TRUTH + 0.05)


def wider(places):
    """Images by another head, of another focal length and baseline."""
    x, y, z = places.T
    return np.stack([360 * x / z + 120, 336 * y / z + 110, 504 * (x - 0.3) / z + 190, 336 * y / z + 110], 1)


@SEEDS
def test_a_body_like_the_own_one_needs_no_explanation(seed):
    assert explained(seed) is None


@SEEDS
def test_one_point_elsewhere_is_named_and_the_posture_is_found_without_it(seed):
    places = body_of(seed).places(TRUTH)
    places[7] += (0.015, -0.01, 0.01)
    found = explained(seed, places)
    assert found.misfit == Misfit(MisfitKind.POINT, (7,)) and found.margin > CLEAR
    assert (np.abs(found.estimate.theta - TRUTH) < 4 * found.estimate.std_error).all()


@SEEDS
def test_the_points_of_one_link_elsewhere_are_named(seed):
    places = body_of(seed).places(TRUTH)
    places[ON == 1] += 0.02 * np.random.default_rng(seed).normal(size=(6, 3))
    assert explained(seed, places).misfit == Misfit(MisfitKind.LINK_POINTS, tuple(np.flatnonzero(ON == 1).tolist()))


@SEEDS
def test_another_head_is_named(seed):
    assert explained(seed, head=wider).misfit.kind is MisfitKind.TWO_HEADS


@SEEDS
def test_a_mirror_image_is_named_and_its_posture_found(seed):
    places = (body_of(seed).places(TRUTH) - MIDDLE) * (1, -1, 1) + MIDDLE
    found = explained(seed, places)
    assert found.misfit.kind is MisfitKind.MIRRORED
    assert (np.abs(found.estimate.theta - TRUTH) < 4 * found.estimate.std_error).all()


def test_points_that_are_anywhere_have_no_known_reason():
    places = body_of(0).places(TRUTH) + 0.05 * np.random.default_rng(0).normal(size=(len(ON), 3))
    found = explained(0, places)
    assert found.misfit == Misfit(MisfitKind.NONE) and found.margin == 0


@SEEDS
def test_a_body_that_differs_a_little_everywhere_is_another_body(seed):
    places, spread = body_of(seed).places(TRUTH), 0.005
    found = explained(seed, places + spread * np.random.default_rng(seed).normal(size=places.shape))
    size = body_of(seed).places(np.zeros(2)).std(0).mean()
    assert found.misfit.kind is MisfitKind.ANOTHER_BODY and found.margin == 0  # nothing is claimed
    assert 0.5 < found.misfit.amount * size / spread < 1.5
    assert (np.abs(found.estimate.theta - TRUTH) < 4 * found.estimate.std_error).all()


def test_a_body_with_another_link_is_imitated_and_its_length_said():
    stretch = np.array([0.02, -0.04])
    settings = Settings(start_deg=(20, -120), demonstrator_deg=(60, -60), seed=3, **NOISY)
    robot = lambda scene, points: stretched(scene, Session(settings).world.robot, stretch)
    session = Session(settings, open_eyes=lambda camera, *scene: OtherDemonstrator(*scene, robot(*scene)))
    last = session.run(60).last
    assert last.status == "converged" and last.misfit.kind is MisfitKind.ANOTHER_BODY
    assert np.abs(last.theta - last.theta_demo).max() < 2 * last.expected_error < np.radians(0.6)
    (link,) = last.misfit.links
    assert link.joints == (0, 1) and abs(link.change - stretch[1]) < 4 * link.std < 0.05
    assert "link from joint 2 to 4" in last.misfit.describe((2, 4))


def test_another_body_is_imitated_in_each_posture():
    settings = Settings(start_deg=(20, -120), seed=3, **NOISY)
    robot = lambda scene, points: stretched(scene, Session(settings).world.robot, np.array((0.02, -0.04)))
    session = Session(settings, open_eyes=lambda camera, *scene: OtherDemonstrator(*scene, robot(*scene)))
    for demonstrator_deg in ((60, -60), (20, -40), (75, -110), (40, -140), (30, -90)):
        session.pose(np.radians(demonstrator_deg))
        last = session.run(60 + session.snapshot.motion).last
        assert last.status == "converged" and last.misfit.kind is MisfitKind.ANOTHER_BODY
        assert abs(last.misfit.links[0].change + 0.04) < 4 * last.misfit.links[0].std
        assert np.abs(last.theta - last.theta_demo).max() < 3 * last.expected_error


class OneAhead:
    """A body with two joints, and a demonstrator, before two cameras of which the right one is ahead of the left."""

    def __init__(self, aside_m, ahead_m, seed=0):
        self.body, self.rng, self.noise_px = body_of(seed), np.random.default_rng(seed), NOISE_PX
        self.theta = self.start = np.zeros(2)
        self.lower, self.upper = np.full(2, -0.7), np.full(2, 0.7)
        self.right = np.array([aside_m, 0, ahead_m])

    def move(self, theta):
        self.theta = np.asarray(theta)
        return self.theta

    def look(self):
        own = self.body.places(self.theta)
        demo = (self.body.places(TRUTH) - MIDDLE) @ Rotation.from_rotvec([0.1, 0.4, 0.05]).as_matrix().T + MIDDLE
        views = [300 * p[:, :2] / p[:, 2:] + (320, 240) for p in (demo, demo - self.right, own, own - self.right)]
        return FourViews.from_images(*(image + self.rng.normal(0, NOISE_PX, image.shape) for image in views))


@pytest.mark.parametrize("aside_m, ahead_m, reason", [(0.25, 0.4, None), (0.02, 0.4, MisfitKind.EPIPOLE)])
def test_with_one_camera_ahead_a_claim_is_honest_and_an_epipole_among_the_points_is_told(aside_m, ahead_m, reason):
    robot = OneAhead(aside_m, ahead_m)
    last = Session.of(robot, robot, frames=1).run(40).last
    assert (last.misfit.kind if last.misfit else None) is reason and (last.status == "converged") is (reason is None)
    assert reason or np.abs(last.theta - TRUTH).max() < 3 * last.expected_error < np.radians(1)


def test_points_mixed_up_in_a_cycle_are_put_right_and_named():
    order = np.arange(16)
    order[[2, 7, 9, 12]] = [7, 9, 12, 2]
    settings = Settings(start_deg=(20, -120), demonstrator_deg=(60, -60), **NOISY)
    session = Session(settings, open_eyes=lambda camera, *scene: OtherDemonstrator(*scene, order=order))
    last = session.run(60).last
    assert last.status == "converged" and last.misfit == Misfit(MisfitKind.MIXED_UP, (2, 7, 9, 12))
    assert np.abs(last.theta - last.theta_demo).max() < np.radians(0.5)


def test_swaps_one_after_the_other_make_any_order_and_their_reverse_undoes_it():
    rng = np.random.default_rng(0)
    for _ in range(20):
        order = rng.permutation(7)
        pairs = transpositions(order)
        np.testing.assert_array_equal(permute(np.arange(7), pairs), order)
        np.testing.assert_array_equal(permute(order, pairs[::-1]), np.arange(7))
        own, demo = rng.normal(size=(2, 7, 4))
        found = with_swaps(lambda own, demo=demo: own - demo, pairs)(own)
        np.testing.assert_array_equal(np.sort(found, 0), np.sort(own - swapped(demo, pairs), 0))


def test_an_arm_that_stops_short_is_noticed_sent_farther_and_claims_in_real_degrees():
    for seed in range(2):
        rng = np.random.default_rng([4, seed])
        share = rng.uniform(0.1, 0.3)
        start, demo = rng.uniform((5, -170), (85, -10), (2, 2)).tolist()
        session = Session(Settings(start_deg=tuple(start), demonstrator_deg=tuple(demo), seed=seed, **NOISY))
        session.embodiment.arm = StopsShort(session.scene, share)
        last = session.run(40).last
        assert last.misfit.kind is MisfitKind.ARM and abs(last.misfit.amount - share) < 0.02
        assert last.status == "converged" and last.motion < 15
        assert np.abs(last.theta - last.theta_demo).max() < 3 * last.expected_error < np.radians(0.75)
        assert f"stops short, by {100 * last.misfit.amount:.1f} %" in last.misfit.describe()


def test_an_arm_that_moves_as_it_is_told_does_not_stop_short():
    session = Session(Settings(start_deg=(20, -120), demonstrator_deg=(60, -60), **NOISY))
    assert session.run(40).last.misfit is None


def through_a_lens(k1):
    def eyes(camera, scene, points):
        left, right = (
            msgspec.structs.replace(eye, distortion=(k1, 0.0)) for eye in (scene.head.left, scene.head.right)
        )
        head = msgspec.structs.replace(scene.head, left=left, right=right)
        return SimulatedEyes(msgspec.structs.replace(scene, head=head), points)

    return eyes


@pytest.mark.parametrize("seed", [5, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (0, 1, 2, 4))])
def test_a_lens_is_named_and_the_joint_angles_found_in_spite_of_it(seed):
    settings = Settings(start_deg=(20, -120), demonstrator_deg=(60, -60), seed=seed, **NOISY)
    session = Session(settings, open_eyes=through_a_lens(-0.06))
    last = session.run(80).last
    assert last.misfit.kind is MisfitKind.LENS and last.status == "converged"
    assert np.abs(last.theta - last.theta_demo).max() < 3 * last.expected_error < np.radians(0.5)
    assert f"a lens bends the pictures, by up to {last.misfit.amount:.2g} px" == last.misfit.describe()
    # Points far from the middle move by k1 r³ focal lengths; a projective map makes up for a part of it.
    head = session.scene.head
    radius = np.hypot(*(np.array(head.image) / 2)) / head.focal
    assert 0.1 < last.misfit.amount < 2 * 0.06 * radius**3 * head.focal


@pytest.mark.slow
def test_points_near_a_plane_make_no_other_body_of_the_same_one():
    rng, links = np.random.default_rng(5), (0, 0, 1, 2, 2, 3, 4, 4, 5, 6, 6, 7, 7, 0, 3, 5)
    points = tuple((link, *rng.uniform(-0.004, 0.004, 3)) for link in links)  # m, about the joints' axes in one plane
    demonstrator, start = (tuple(rng.uniform((10, -170), (80, -10))) for _ in range(2))
    poses = {"demonstrator_deg": demonstrator, "start_deg": start}
    last = Session(Settings(body_points=points, noise_px=0.25, seed=0, **poses)).run(60).last
    assert last.misfit is None and last.status == "converged"
    assert np.abs(last.theta - last.theta_demo).max() < 3 * last.expected_error


def test_a_clear_misfit_spares_the_search_elsewhere():
    body = lambda camera, scene, points: OtherDemonstrator(scene, points, mirrored=True)
    last = Session(Settings(start_deg=(20, -120), demonstrator_deg=(60, -60), **NOISY), open_eyes=body).run(60).last
    assert last.misfit.kind is MisfitKind.MIRRORED and not last.status.is_claim and last.motion < 10
