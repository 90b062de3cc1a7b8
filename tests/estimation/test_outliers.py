"""Misplaced and swapped points are found and nothing else; clean images raise no alarm, and undecided cases say so."""

from itertools import product

import msgspec
import numpy as np
import pytest
from axle_markers import axle_markers

from viewimit.estimation.outliers import find_outliers, reject_outliers
from viewimit.estimation.views import FourViews
from viewimit.experiments.bench.draws import draw_scene, resize
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.simulation.disturbances import OUTLIER_PX
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World

# Tracked images


FRAMES = 10


def looks(world, rng, frames, noise_px=0.0, alike=True):
    """Both arms in random postures, the same in each frame or not."""
    low, high = world.scene.lower, world.scene.upper
    seen = []
    for theta in rng.uniform(low, high, (frames, len(low))):
        seen.append(world.look(theta, theta if alike else rng.uniform(low, high)))
    demo, own = (np.array([getattr(views, body) for views in seen]) for body in ("demo", "own"))
    noise = noise_px * rng.standard_normal((2, *demo.shape))
    return FourViews(demo + noise[0], own + noise[1], np.ones(demo.shape, bool))


def panda(points):
    return World(load_scene("panda"), points)


def named(views):
    return [(suspect.kind, suspect.points, suspect.views) for suspect in find_outliers(views).found]


@pytest.mark.parametrize("scenes", [3, pytest.param(200, marks=pytest.mark.slow)])
@pytest.mark.parametrize("any_head", [False, True], ids=["parallel", "any head"])
def test_clean_images_raise_no_alarm(any_head, scenes):
    """Of random scenes, one frame or ten, with and without noise, in the same postures and in others."""
    rng = np.random.default_rng(20)
    for _ in range(scenes):
        drawn = draw_scene(rng, any_head)
        world = World(drawn.scene, drawn.points)
        resize(world, drawn.size)
        for frames, noise_px, alike in product((1, FRAMES), (0.0, 0.5), (True, False)):
            assert find_outliers(looks(world, rng, frames, noise_px, alike)).found == ()


@pytest.mark.parametrize("count, frames, noise_px", [(10, 1, 0.0), (16, FRAMES, 0.5), (20, 1, 0.5)])
def test_only_the_misplaced_point_is_found(count, frames, noise_px):
    rng = np.random.default_rng(count)
    for column, pair in ((1, ("l", "r")), (3, ("l", "r")), (1, ("L", "R")), (3, ("L", "R"))):
        views, point = looks(panda(count), rng, frames, noise_px, alike=False), int(rng.integers(count))
        (views.demo if pair == ("l", "r") else views.own)[:, point, column] += rng.choice((-60, 60))
        (found,) = find_outliers(views).found
        assert (found.kind, found.points, found.views) == ("misplaced", (point,), pair)
        assert found.frames == tuple(range(frames)) and found.score > 20


def test_the_score_is_the_distance_in_standard_deviations_of_the_others():
    """Parallel axes: rows are one, and the distance of a match from its row is Δy/√2."""
    rng = np.random.default_rng(1)
    views = looks(panda(20), rng, FRAMES, 0.5)
    views.demo[3:5, 7, 1] += 40
    (found,) = find_outliers(views).found
    others = np.concatenate([views.demo, views.own], 1)
    rows = np.delete(others[..., 1] - others[..., 3], 7, axis=1)
    deviation = rows.std() / np.sqrt(2)
    off = np.sqrt(np.mean((views.demo[3:5, 7, 1] - views.demo[3:5, 7, 3]) ** 2) / 2)
    assert found.frames == (3, 4) and found.score == pytest.approx(off / deviation, rel=0.03)


@pytest.mark.parametrize("count", [10, 16, 20])
@pytest.mark.parametrize("frames", [1, FRAMES])
def test_only_the_swapped_pair_is_found_with_the_fall_of_E(count, frames):
    rng = np.random.default_rng(count)
    for _ in range(4):
        pair = tuple(sorted(rng.permutation(count)[:2].tolist()))
        clean = looks(panda(count), rng, frames)
        (found,) = find_outliers(clean.permuted((pair,))).found
        assert (found.kind, found.points, found.views) == ("swapped", pair, ("l", "r"))
        assert found.E > 10 * found.E_swapped and found.score >= 10


def test_a_misplaced_point_and_a_swapped_pair_are_distinguished():
    rng = np.random.default_rng(5)
    views = looks(panda(16), rng, FRAMES).permuted(((3, 8),))
    views.own[:, 11, 1] += 60
    assert named(views) == [("misplaced", (11,), ("L", "R")), ("swapped", (3, 8), ("l", "r"))]


def iiwa(body, head=""):
    scene = load_scene('extends = "iiwa"\nrange_deg = [[-50, 50], [-100, 100]]\n' + head)
    return World(scene, body=body(scene))


HEADS = {"parallel": "", "toed in": "[head]\ntoe_in_deg = 12\n"}


@pytest.mark.parametrize("head", HEADS.values(), ids=HEADS)
@pytest.mark.parametrize("noise_px", [0.0, 0.25])
def test_no_swap_is_found_that_makes_the_learner_a_mirror_image_of_the_demonstrator(head, noise_px):
    """With the exchange a reflection fits, and nothing does without it."""
    rng, world = np.random.default_rng(11), iiwa(axle_markers, head)
    thetas = rng.uniform(0.3, 0.8, (FRAMES, 2)) * rng.choice((-1, 1), (FRAMES, 2))
    seen = [world.look(theta, -theta) for theta in thetas]
    demo, own = (np.array([getattr(views, body) for views in seen]) for body in ("demo", "own"))
    noise = noise_px * rng.standard_normal((2, *demo.shape))
    views = FourViews(demo + noise[0], own + noise[1], np.ones(demo.shape, bool))
    report = find_outliers(views.permuted(((12, 13),)))
    assert (
        report.found == ()
        and "where it must not reflect; they show only with arms in one posture" in report.undecided[0]
    )


@pytest.mark.parametrize("noise_px", [0.05, 0.25, 1.0])
def test_the_reported_noise_is_that_of_an_image_coordinate(noise_px):
    views = looks(panda(16), np.random.default_rng(13), FRAMES, noise_px, alike=False)
    assert find_outliers(views).noise_px == pytest.approx(noise_px, rel=0.1)
    assert find_outliers(views.select(np.arange(5))).noise_px is not None
    few = FourViews(views.demo[:1], views.own[:1], views.visible[:1]).select(np.arange(5))
    assert find_outliers(few).noise_px is None


def test_invisible_points_have_no_effect():
    rng = np.random.default_rng(6)
    views = looks(panda(16), rng, FRAMES)
    views.demo[2, 4] = np.nan
    views.visible[2, 4] = False
    views.own[5] = 1e6
    views.visible[5] = False
    assert find_outliers(views).found == () == find_outliers(views).undecided


# Each look of the loop


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


@pytest.mark.parametrize("scene", ["panda", "panda-toed"])
def test_points_off_their_epipolar_lines_become_invisible_in_both_images(scene):
    session = Session(msgspec.structs.replace(ONE_FRAME, scene=scene, points=20))
    session.run(6)
    moments, rng = list(session.history), np.random.default_rng(3)
    views, wrong = spoilt(moments[-1].views, rng, 0.15)
    report = reject(views, moments[:-1], 0.0, 9)
    unseen = np.stack([~report.visible[:, :2].any(-1), ~report.visible[:, 2:].any(-1)])
    assert wrong.sum() >= 4 and np.array_equal(unseen, wrong)
    assert np.array_equal(report.demo, views.demo) and views.visible.all()


def test_with_a_tenth_of_the_points_misplaced_the_learner_arrives():
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
