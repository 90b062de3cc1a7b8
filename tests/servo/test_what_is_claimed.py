"""What a claim must pass besides a small E: goals inside the joint limits, and images of rigid links."""

import numpy as np
import pytest

from viewimit import FourViews, Session, Settings
from viewimit.geometry.kinematics.two_bodies import reverses_orientation

DEMONSTRATOR = (41.9, -102.6)


@pytest.mark.parametrize(("beyond_deg", "claims"), [(0.0, True), (1.0, False), (1.25, False)])
def test_a_goal_beyond_a_joint_limit_is_not_claimed_and_the_limit_is_told(beyond_deg, claims):
    limits = ((0, 90), (-180, DEMONSTRATOR[1] - beyond_deg))
    settings = Settings(
        demonstrator_deg=DEMONSTRATOR, start_deg=(62.7, -161.3), workspace_deg=limits, noise_px=0.25, frames=25,
        points=16, seed=90001,
    )  # fmt: skip
    found = Session(settings).run(60)
    assert found.success == claims
    if not claims:
        (limit,) = found.last.misfit.limits
        assert limit.joint == 1 and abs(np.degrees(limit.beyond) - beyond_deg) < 3 * np.degrees(limit.std) + 0.1
        assert "joint 4" in found.message  # its number in the scene


class SlippingArm:
    """Two joints; the points on the links slip by `slip_m` at each motion. Noise of 0.25 px in each image."""

    lower, upper = np.radians([-60.0, -120.0]), np.radians([70.0, 60.0])
    noise_px = 0.0

    def __init__(self, demonstrator, seed, slip_m):
        self.demonstrator, self.theta, self.slip_m = demonstrator, np.radians([10.0, -20.0]), slip_m
        self.start, self.rng, self.slip = self.theta, np.random.default_rng(seed), np.zeros((12, 3))
        places = np.random.default_rng(5)
        spread = lambda n, size, z: places.uniform(-size, size, (n, 3)) + (0, 0, z)
        self.base, self.upper_arm, self.forearm = spread(4, 0.1, 0.1), spread(6, 0.09, 0.2), spread(6, 0.09, 0.25)

    def move(self, theta):
        self.theta, self.slip = np.array(theta), self.slip_m * self.rng.standard_normal((12, 3))
        return self.theta

    def body(self, theta, slip):
        turn = lambda a: np.array([[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]])
        R, Q = turn(theta[0]), turn(theta[0] + theta[1])
        first = (0, 0, 0.3) + (self.upper_arm + slip[:6]) @ R.T
        return np.vstack([self.base, first, (0, 0, 0.3) + R @ (0, 0, 0.45) + (self.forearm + slip[6:]) @ Q.T])

    def look(self):
        def pair(points, at, yaw):
            c, s = np.cos(yaw), np.sin(yaw)
            x, y, z = (points @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T + at).T
            return [np.column_stack([320 + 256 * (x - b) / y, 120 - 256 * z / y]) for b in (-0.3, 0.3)]

        demo = pair(self.body(self.demonstrator, 0 * self.slip), (0.3, 1.6, -0.5), 2.6)
        images = np.array([*demo, *pair(self.body(self.theta, self.slip), (-0.2, 1.3, -0.5), 0.4)])
        return FourViews.from_images(*(images + 0.25 * self.rng.standard_normal(images.shape)))


@pytest.mark.parametrize(("slip_m", "claims"), [(0.0, True), (0.003, False)])
def test_an_arm_whose_points_slip_claims_nothing_and_says_why(slip_m, claims):
    rng = np.random.default_rng([90001, 7])
    arm = SlippingArm(rng.uniform(np.radians([-50, -110]), np.radians([60, 50])), 90008, slip_m)
    found = Session.of(arm, arm, frames=25).run(100)
    assert found.success == claims
    assert (found.last.misfit is None) == claims and ("rigid" in found.message) != claims


def test_a_map_of_space_mirrors_where_its_jacobian_does_whatever_the_sign_of_the_depth():
    rng = np.random.default_rng(0)
    H, x, steps = rng.normal(size=(200, 4, 4)), rng.normal(size=(200, 3)), 1e-6 * np.eye(3)

    def mapped(x):
        y = np.einsum("kij,kj->ki", H, np.column_stack([x, np.ones(len(x))]))
        return y[:, :3] / y[:, 3:]

    jacobian = np.stack([mapped(x + step) - mapped(x - step) for step in steps], -1)
    np.testing.assert_array_equal(reverses_orientation(H), np.linalg.det(jacobian) < 0)
