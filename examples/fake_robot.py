"""An arm and eyes of your own, here in thirty lines of numpy: three joints and a pair of pinhole cameras.

    python examples/fake_robot.py

Nothing of this is known to the learner: it sends the arm to angles and sees image points. See `viewimit.Arm`, `Eyes`.
"""

import numpy as np

from viewimit import FourViews, Session

LINKS = ((0.0, 0.0, 0.1), (0.0, 0.0, 0.3), (0.45, 0.0, 0.0))  # from the base and each joint to the next joint, m
# Five on the base and on each link, m. Without those on the base nothing would tell the first joint: turning the whole
# body is no other image of it than moving the head is
POINTS = np.random.default_rng(5).uniform((0, -0.1, -0.1), (0.4, 0.1, 0.1), (4, 5, 3))


def turn(axis, angle):
    """Rotation about z or y, (3, 3)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]] if axis == "z" else [[c, 0, s], [0, 1, 0], [-s, 0, c]])


def picture_points(theta, stands, yaw):
    """Of a body that stands there, (3,) m, turned by yaw, rad: what both cameras see of its points, two (20, 2) px."""
    R, at = turn("z", yaw), np.array(stands)
    placed = [POINTS[0] @ R.T + at]
    for axis, angle, link, points in zip("zyy", theta, LINKS, POINTS[1:]):
        at, R = at + R @ link, R @ turn(axis, angle)
        placed.append(points @ R.T + at)
    x, depth, z = np.concatenate(placed).T  # the head looks along y
    return [np.stack([640 + 1100 * (x - eye) / depth, 480 - 1100 * z / depth], -1) for eye in (-0.1, 0.1)]


class FakeRobot:
    """Arm and eyes at once; they may as well be two objects."""

    lower, upper = np.radians([-60, -70, 10]), np.radians([60, 20, 110])
    start = np.radians([-20, -20, 40])
    noise_px = 0.0

    def __init__(self, demonstrator_deg):
        self.theta, self.demonstrator = self.start, np.radians(demonstrator_deg)

    def move(self, theta):
        self.theta = theta
        return theta

    def look(self):
        demo = picture_points(self.demonstrator, (0.3, 3.0, -0.2), 2.8)
        return FourViews.from_images(*demo, *picture_points(self.theta, (-0.2, 2.2, -0.3), 0.4))


if __name__ == "__main__":
    robot = FakeRobot(demonstrator_deg=(30, -45, 80))
    ended = Session.of(robot, robot).run()
    print(f"{ended.status} at {np.degrees(ended.theta).round(1)} after {ended.motions} motions")
