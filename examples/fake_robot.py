"""An arm and eyes of your own, here in thirty lines of numpy: three joints and a pair of pinhole cameras.

    python examples/fake_robot.py
    python examples/fake_robot.py --noise-px 0.1 --runs 20

Nothing of this is known to the learner: it sends the arm to angles and sees image points. See `viewimit.Arm`, `Eyes`.
The second line runs it with noise in all images, drawn anew for each run, and prints how many runs converged, and their
motions, errors and travel.
"""

import argparse

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

    def __init__(self, demonstrator_deg, image_noise_px=0.0, seed=0):
        self.theta, self.demonstrator = self.start, np.radians(demonstrator_deg)
        self.image_noise_px, self.rng = image_noise_px, np.random.default_rng(seed)

    def move(self, theta):
        self.theta = theta
        return theta

    def look(self):
        demo = picture_points(self.demonstrator, (0.3, 3.0, -0.2), 2.8)
        images = np.array([*demo, *picture_points(self.theta, (-0.2, 2.2, -0.3), 0.4)])
        return FourViews.from_images(*(images + self.image_noise_px * self.rng.standard_normal(images.shape)))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--noise-px", type=float, default=0.0, help="of every image coordinate (%(default)s)")
    parser.add_argument("--runs", type=int, default=1, help="each with other noise (%(default)s)")
    asked = parser.parse_args()
    runs = []
    for seed in range(asked.runs):
        robot = FakeRobot((30, -45, 80), asked.noise_px, seed)
        ended = Session.of(robot, robot).run()
        runs.append(
            (ended.success, ended.motions, np.degrees(np.abs(ended.theta - robot.demonstrator).max()), ended.travel_deg)
        )
    if asked.runs == 1:
        print(f"{ended.status} at {np.degrees(ended.theta).round(1)} after {ended.motions} motions")
    else:
        success, *found = np.transpose(runs)
        print(f"{success.sum():.0f} of {asked.runs} converged")
        for what, unit, values in zip(("motions", "error", "travel"), ("", "°", "°"), found):
            print(f"{what}: median {np.median(values):.3g}{unit}, at most {values.max():.3g}{unit}")
