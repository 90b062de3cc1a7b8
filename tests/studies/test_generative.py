"""The learned generative model recovers images of a known chain at new postures, and the law arrives where they lead.

The chain and the cameras of the tests are written here by matrix exponentials, and share no code with the model.
"""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from generative import Generative, Visits, fit
from scipy.linalg import expm

from viewimit.estimation.transfers.transfer import conflict
from viewimit.experiments.bench.engine import run_once
from viewimit.servo import Observation
from viewimit.servo.observation import Visit
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World

LIMIT = np.radians(100.0)


def skew(a):
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


@dataclass
class Chain:
    """Twists S_j, points of m + 1 links, and two pinhole cameras P of any lenses that look at the arm from 3 m."""

    m: int
    seed: int
    per_link: int = 5
    px: float = 300.0

    def __post_init__(self):
        rng = np.random.default_rng(self.seed)
        self.twists = []
        for j in range(self.m):
            axis, through = rng.normal(size=3), np.array([0.3 * j, 0, 0]) + rng.normal(0, 0.05, 3)
            axis /= np.linalg.norm(axis)
            S = np.zeros((4, 4))
            S[:3, :3], S[:3, 3] = skew(axis), -np.cross(axis, through)
            self.twists.append(S)
        self.link = np.repeat(np.arange(self.m + 1), self.per_link)
        self.points = np.c_[0.3 * (self.link - 0.5), np.zeros((len(self.link), 2))] + rng.normal(
            0, 0.12, (len(self.link), 3)
        )
        self.P = []
        for side in (-0.4, 0.4):
            R = expm(skew(rng.normal(0, 0.05, 3))) @ expm(skew([0, np.arctan2(side, 3), 0]))  # toed in
            K = np.array([[self.px * rng.uniform(0.9, 1.1), 0, 320], [0, self.px, 240], [0, 0, 1]])
            centre = np.array([side + 0.15 * self.m, 0, -3.0])
            self.P.append(K @ np.c_[R, -R @ centre])

    def images(self, theta):
        """(N, 4) px."""
        T, found = np.eye(4), []
        for link in range(self.m + 1):
            X = np.c_[self.points[self.link == link], np.ones(self.per_link)] @ T.T
            homogeneous = [X @ P.T for P in self.P]
            found.append(np.concatenate([h[:, :2] / h[:, 2:] for h in homogeneous], 1))
            if link < self.m:
                T = T @ expm(self.twists[link] * theta[link])
        return np.concatenate(found)

    def observation(self, theta, motion=0, seen=None, target=None, noise_px=0.0, rng=None):
        own = self.images(theta) + (0 if rng is None else rng.normal(0, noise_px, (len(self.link), 4)))
        seen = np.ones((len(own), 2), bool) if seen is None else seen
        E = np.nan if target is None else float(conflict(own - target))
        limit = np.full(self.m, LIMIT)
        return Observation(own, seen, E, theta, -limit, limit, motion, noise_px)

    def visits(self, postures, seen=None, noise_px=0.0, rng=None):
        found = []
        for k, theta in enumerate(postures):
            one = self.observation(theta, noise_px=noise_px, rng=rng)
            found.append(Visit.of(theta, one.own, one.seen if seen is None else seen[k]))
        return Visits.of(tuple(found))


def probes(m):
    return np.cumsum(np.r_[[np.zeros(m)], np.radians(15.0) * np.eye(m)], 0)


@pytest.mark.parametrize("m, seed", [(1, 0), (2, 1), (2, 2), (3, 3), (4, 4)])
def test_after_one_probe_of_each_joint_and_two_visits_images_of_new_postures_are_recovered(m, seed):
    chain, rng = Chain(m, seed), np.random.default_rng(seed)
    visits = chain.visits([*probes(m), *rng.uniform(-LIMIT, LIMIT, (2, m))])
    model = fit(visits, 0.0, None)
    np.testing.assert_array_equal(model.link, chain.link)
    new = rng.uniform(-LIMIT, LIMIT, (6, m))
    error = model.predict(new) - np.stack([chain.images(theta) for theta in new])
    spread = np.std(np.stack([chain.images(theta) for theta in new]))
    assert np.sqrt((error**2).mean()) < 1e-3 * spread  # of a fit that stops within 0.02 px at its own visits
    again = fit(visits, 0.0, None)
    assert (again.parameters == model.parameters).all() and (again.points == model.points).all()


def test_a_fit_leaves_the_noise_and_predicts_better_than_the_images_it_was_given():
    chain, rng, noise = Chain(2, 5), np.random.default_rng(5), 0.5
    postures = [*probes(2), *rng.uniform(-LIMIT, LIMIT, (20, 2))]
    visits = chain.visits(postures, noise_px=noise, rng=rng)
    model = fit(visits, noise, None)
    n, freedom = visits.images.size, visits.images.size - (22 + 6 * 2 - 7 - 2 * 2 + 3 * len(chain.link))
    expected = noise * np.sqrt(freedom / n)
    assert visits.rms(model) == pytest.approx(expected, rel=3 * np.sqrt(0.5 / freedom) + 0.02)
    new = rng.uniform(-LIMIT, LIMIT, (10, 2))
    error = model.predict(new) - np.stack([chain.images(theta) for theta in new])
    assert np.sqrt((error**2).mean()) < noise


@pytest.mark.parametrize("m, seed", [(2, 11), (3, 12), (4, 13)])
def test_it_arrives_where_fixed_targets_are_seen_as_in_the_cited_paper(m, seed):
    chain, rng = Chain(m, seed), np.random.default_rng(seed)
    aim = rng.uniform(-LIMIT, LIMIT, m)
    target, law, theta, asked = chain.images(aim), Generative(), np.zeros(m), []
    residuals = Targets(target)
    state = law.start(chain.observation(theta, target=target))
    for motion in range(20):
        seen = chain.observation(theta, motion, target=target)
        state, step = law.step(state, seen, residuals)
        asked.append(step)
        if not step.any():
            break
        theta = theta + step
    assert state.status == "settled" and np.degrees(np.abs(theta - aim)).max() < 0.1
    assert [np.count_nonzero(step) for step in asked[:m]] == [1] * m and len(asked) <= m + 4


class Targets:
    """Residuals of own points from fixed targets; points that are NaN in any image are left out."""

    def __init__(self, target):
        self.target = target

    def __call__(self, own, transfer=None, noise_reference=None, rig=0):
        e = own - self.target
        return e[..., np.isfinite(e).all(-1).reshape(-1, len(self.target)).all(0), :]


def test_it_claims_nothing_and_repeats_to_the_last_bit(compared, exact):
    first, again = (run_once(compared[1], exact, "generative", 3, 1, 30) for _ in range(2))
    assert (
        repr(replace(first, cpu_s=0)) == repr(replace(again, cpu_s=0))
        and first.status == "settled"
        and first.error_deg < 0.2
    )
    assert np.isnan(first.expected_deg)


def test_the_model_of_a_simulated_arm_of_seven_joints_is_that_of_its_images():
    scene = load_scene("panda", joints=(1, 2, 3, 4, 5, 6, 7))
    world, rng = World(scene, 16), np.random.default_rng(8)
    rest = np.radians(np.array(scene.posture_deg)[scene.moving])
    images = lambda theta: world.own_images(tuple(rest + theta))[0]
    seen = np.ones((16, 2), bool)
    visits = Visits.of(
        tuple(Visit.of(theta, images(theta), seen) for theta in (*probes(7), *rng.uniform(-0.3, 0.3, (3, 7))))
    )
    model, new = fit(visits, 0.0, None), rng.uniform(-0.4, 0.4, (5, 7))
    error = model.predict(new) - np.stack([images(theta) for theta in new])
    assert np.abs(error).max() < 0.5
