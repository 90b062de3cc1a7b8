"""What a pixel costs: against draws of noise, the robot's geometric Jacobian, and what no image can tell."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from viewimit.analysis.observability import joint_uncertainty, uncertainty
from viewimit.estimation.transfers import TRANSFERS
from viewimit.estimation.views import FourViews
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings

SEVEN = Settings.paper(joints=tuple(range(1, 8)), points=16, demonstrator_deg=(10, 40, -10, -80, 15, 100, 30))


def asked(session, transfer):
    snapshot = session.snapshot
    views = snapshot.views
    return joint_uncertainty(session.world, TRANSFERS[transfer], views.demo, views.visible[:, :2], snapshot.theta_demo)


def test_it_is_the_spread_of_least_squares_under_noise():
    rng = np.random.default_rng(0)
    J = rng.standard_normal((30, 4)) * (1, 2, 5, 0.1)
    fits = np.linalg.lstsq(J, rng.standard_normal((30, 5000)), rcond=None)[0]
    assert uncertainty(J) == pytest.approx(fits.std(1), rel=0.04)


@pytest.mark.parametrize("transfer", ["linear", "projective"])
def test_it_is_the_spread_of_the_smallest_E_under_noise_in_the_own_images(transfer):
    session = Session(Settings.paper())
    demo, theta_demo = session.snapshot.views.demo, session.snapshot.theta_demo
    rng, sigma = np.random.default_rng(1), 0.01

    def minimum(noise):
        def e(theta):
            views = FourViews(demo, session.world.own_images(theta)[0] + noise, np.ones(1, bool))
            return TRANSFERS[transfer](views).residual(views).ravel()

        return least_squares(e, theta_demo, xtol=1e-12, ftol=1e-12).x

    ends = np.array([minimum(sigma * rng.standard_normal(demo.shape)) for _ in range(150)])
    assert asked(session, transfer) == pytest.approx(ends.std(0) / sigma, rel=0.2)


def test_the_linear_transfers_jacobian_is_that_of_the_arm_beyond_the_demonstrators_shape():
    """e = (I - H H⁺) y, so that J = (I - H H⁺) ∂y/∂θ; and a point turns about a joint by its axis times its arm."""
    session = Session(SEVEN)
    world, demo, theta = session.world, session.snapshot.views.demo, session.snapshot.theta_demo
    frames = world.link_frames(theta, world.T_world_own)
    points = world.points_world(theta, world.T_world_own)
    columns = []
    for j, joint in enumerate(world.robot.joints):
        axis = frames[j + 1, :3, :3] @ joint.axis
        velocity = np.cross(axis, points - frames[j + 1, :3, 3]) * (world.body.link > j)[:, None]
        images = []
        for camera in world.own_cameras:
            R, t = camera.T_world_camera[:3, :3], camera.T_world_camera[:3, 3]
            (x, y, z), (vx, vy, vz) = ((points - t) @ R).T, (velocity @ R).T
            fx, fy = camera.lens.focal
            images += [fx * (vx - x / z * vz) / z, fy * (vy - y / z * vz) / z]
        columns.append(np.stack(images, -1))
    U = np.linalg.svd(demo - demo.mean(0))[0][:, :3]  # the first three: the demonstrator's affine shape
    H = np.column_stack([np.ones(len(U)), U])
    beyond = np.eye(len(H)) - H @ np.linalg.pinv(H)
    expected = np.stack([(beyond @ column).ravel() for column in columns], -1)
    assert asked(session, "linear") == pytest.approx(np.sqrt(np.diag(np.linalg.inv(expected.T @ expected))), rel=1e-4)


def test_what_no_residual_tells_costs_infinitely_much():
    J = np.zeros((8, 4))
    J[:, 0], J[:, 1], J[:, 3] = 1.0, np.arange(8), np.arange(8)  # 2 moves nothing, 1 and 3 move the same
    found = uncertainty(J)
    assert np.isfinite(found[0]) and np.isinf(found[1:]).all()
    assert np.isinf(uncertainty(np.zeros((8, 2)))).all()
    assert np.isinf(uncertainty(np.ones((1, 2)))).all()  # one residual, two angles
