"""The Cramér-Rao bound of what was seen, beside what the learner's own model of its body says, and its limits."""

import numpy as np
import pytest

from viewimit.experiments.bench.bound import bound
from viewimit.geometry.kinematics.adjustment import KinematicsCovariance
from viewimit.geometry.kinematics.clusters import Observations
from viewimit.geometry.kinematics.model import ProjectiveKinematics
from viewimit.geometry.kinematics.own_body import exact_body
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World

THERE = np.radians([40.0, -100.0])
SMALL = 1e-4  # of difference quotients
TINY = 1e-7  # px, of noise that is taken as linear


@pytest.fixture(scope="module")
def world():
    return World(load_scene("panda"), 10)


@pytest.fixture(scope="module")
def visited(world):
    probes = np.radians([[20.0, -60.0], [35.0, -60.0], [20.0, -75.0]])
    return np.vstack([probes, np.random.default_rng(0).uniform(world.scene.lower, world.scene.upper, (6, 2))])


def images(pair, points):
    return np.concatenate(list(pair.images(points)[0]), 1)


@pytest.mark.parametrize("visits", [4, 9])
def test_it_is_what_noise_of_the_demonstrator_and_of_learned_kinematics_leaves(world, visited, visits):
    """Second derivation: the images of the demonstrator differ by their noise, and by that of the own images foretold
    at its posture, whose covariance is that of fitted projective kinematics; θ and H are fitted to them."""
    visited = visited[:visits]
    own = np.array([world.own_images(tuple(theta))[0] for theta in visited])
    seen = Observations(visited - visited[0], own, np.ones(own.shape[:2], bool))
    kinematics = exact_body(seen, 0.0).kinematics
    assert kinematics is not None
    covariance = foretold_covariance(kinematics, KinematicsCovariance.estimate(kinematics, seen), THERE - visited[0])
    to_demo, J, J_H = demonstrator_derivatives(world)
    total = np.eye(len(J)) + to_demo @ covariance @ to_demo.T
    white = np.linalg.solve(np.linalg.cholesky(total), np.hstack([J, J_H]))
    inverse = np.linalg.pinv(white / np.linalg.norm(white, axis=0), rcond=1e-9)
    deviations = np.linalg.norm(inverse / np.linalg.norm(white, axis=0)[:, None], axis=1)[:2]
    more = deviations / bound(world, THERE, 1.0, list(visited))
    assert (more > 0.999).all() and (more < 1.07).all()  # a fitted joint may slide as it turns: one number more of each


def foretold_covariance(
    kinematics: ProjectiveKinematics, information: KinematicsCovariance, displacement: np.ndarray
) -> np.ndarray:
    """(4 N, 4 N) px², for noise of 1 px at the visits: what all points share, and what each has of its own."""
    parameters, points = information.columns(TINY)
    off = [
        ProjectiveKinematics(
            kinematics.parameters + p,
            kinematics.points + s,
            kinematics.moved_by,
            kinematics.reference,
            kinematics.frame,
        ).predict(displacement)
        - kinematics.predict(displacement)
        for p, s in zip(parameters, points)
    ]
    shared, alone = np.array(off[:-3]) / TINY, np.array(off[-3:]) / TINY
    covariance = np.einsum("knc,kmd->ncmd", shared, shared)
    for n in range(covariance.shape[0]):
        covariance[n, :, n] += np.einsum("kc,kd->cd", alone[:, n], alone[:, n])
    return covariance.reshape(2 * (4 * len(kinematics.points),))


def demonstrator_derivatives(world):
    """Of its images (4 N,): by the own images at its posture (4 N, 4 N), by θ (4 N, 2), by H about 1 (4 N, 16)."""
    own, demo = (world.points_world(THERE, T).copy() for T in (world.T_world_own, world.T_world_demo))
    own_to_demo = np.linalg.lstsq(np.c_[own, np.ones(len(own))], demo, rcond=None)[0][:3]
    to_demo = np.zeros((len(own), 4, len(own), 4))
    for n in range(len(own)):
        by_own = image_slopes(world.own_pair, own[n], np.eye(3))
        by_demo = image_slopes(world.demo_pair, demo[n], own_to_demo)
        to_demo[n, :, n] = by_demo @ np.linalg.pinv(by_own)
    J = slopes(lambda step: world.demo_images(tuple(THERE + step))[0], np.eye(2))
    J_H = slopes(lambda entries: mapped_images(world, demo, np.eye(4) + entries.reshape(4, 4)), np.eye(16))
    return to_demo.reshape(4 * len(own), -1), J, J_H


def image_slopes(pair, point, axes):
    return slopes(lambda step: images(pair, (point + step)[None]), axes)


def mapped_images(world, points, H):
    mapped = np.c_[points, np.ones(len(points))] @ H.T
    return images(world.demo_pair, mapped[:, :3] / mapped[:, 3:])


def slopes(of, steps):
    """(n, k) of a function's n values by k steps."""
    return np.array([(of(SMALL * step) - of(-SMALL * step)).ravel() / (2 * SMALL) for step in steps]).T


def test_the_more_is_seen_of_the_own_body_the_nearer_it_comes_to_own_images_that_are_granted(world, visited):
    granted = bound(world, THERE, 1.0)
    looks = [bound(world, THERE, 1.0, list(np.repeat(visited, times, 0))) for times in (1, 4, 32)]
    assert (looks[0] > 1.05 * granted).all()
    left = [look**2 - granted**2 for look in looks]  # the own images' share sinks as their number rises
    assert all((after < before).all() for before, after in zip(left, left[1:])) and (left[2] < left[0] / 16).all()
    assert (looks[2] > granted).all() and (looks[2] < 1.02 * granted).all()


def test_a_joint_is_lost_with_the_points_that_tell_it(world):
    """One image of a base point, of three numbers two, tells the first joint; without any nothing does."""
    whole, link = bound(world, THERE, 1.0), world.body.link
    seen = np.ones((10, 2), bool)
    np.testing.assert_array_equal(bound(world, THERE, 1.0, seen=seen), whole)
    base = link <= world.scene.moving[0]
    seen[base] = False
    first, second = bound(world, THERE, 1.0, seen=seen)
    assert np.isinf(first) and whole[1] < second < np.inf
    seen[np.flatnonzero(base)[0], 0] = True
    half = bound(world, THERE, 1.0, seen=seen)
    assert (whole < half).all() and np.isfinite(half).all()
    assert np.isinf(bound(world, THERE, 1.0, seen=np.zeros((10, 2), bool))).all()


def test_it_goes_with_the_noise(world, visited):
    np.testing.assert_allclose(
        bound(world, THERE, 3.0, list(visited)), 3 * bound(world, THERE, 1.0, list(visited)), rtol=1e-6
    )


def test_a_head_that_sees_both_bodies_tells_more_than_any_map_between_them(world, visited):
    by_E, one_head = bound(world, THERE, 1.0, list(visited)), bound(world, THERE, 1.0, list(visited), one_head=True)
    assert (one_head < by_E).all() and (one_head > 0.4 * by_E).all()
    another = bound(world, THERE, 1.0, list(visited), another_body=True)
    assert (one_head <= another * (1 + 1e-6)).all()  # shifted joints are unknown besides
