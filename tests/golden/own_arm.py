"""An arm and eyes of one's own for the golden runs, in numpy alone: nothing of it is the library's."""

import numpy as np

from viewimit import FourViews

LINKS = ((0.0, 0.0, 0.1), (0.0, 0.0, 0.3), (0.45, 0.0, 0.0))  # from the base and each joint to the next joint, m
AXES = "zyy"
# On the base and on each link, m in its frame
POINTS = np.random.default_rng(11).uniform((0, -0.1, -0.1), (0.4, 0.1, 0.1), (4, 6, 3))
EYES_M = (-0.1, 0.1)
FOCAL, CENTRE = 1100.0, (640.0, 480.0)  # px


def rotation(axis, angle):
    """About z or y, (3, 3)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]] if axis == "z" else [[c, 0, s], [0, 1, 0], [-s, 0, c]])


def body(theta, stands, yaw):
    """Points and outward normals of an arm that stands there, (3,) m, turned by yaw rad: (24, 3) m each.

    A normal leads from the middle line of the link to the point.
    """
    R, at = rotation("z", yaw), np.array(stands)
    points, normals = [], []
    turns = [np.eye(3), *(rotation(axis, angle) for axis, angle in zip(AXES, theta))]
    offsets = [np.zeros(3), *map(np.array, LINKS)]
    for turn, offset, local in zip(turns, offsets, POINTS):
        at, R = at + R @ offset, R @ turn
        points.append(local @ R.T + at)
        normals.append((local * (0, 1, 1)) @ R.T)
    return np.concatenate(points), np.concatenate(normals)


def image(points, eye):
    """(24, 2) px: the head looks along y."""
    x, depth, z = points.T
    return np.stack([CENTRE[0] + FOCAL * (x - eye) / depth, CENTRE[1] - FOCAL * z / depth], -1)


class OwnArm:
    """Arm and eyes at once.

    noise_added_px: standard deviation of the noise that its images have; grid_px: of its tracker, to which images are
    rounded; hides: cosine between a point's normal and the way to a camera up to which the point is hidden, None if all
    are seen; half_seen: share of the points each of which one image of the demonstrator lacks; late: by how many looks
    its images come late; offset_deg: how far from where it is sent it stands.
    """

    lower, upper = np.radians([-60, -70, 10]), np.radians([60, 20, 110])
    start = np.radians([-20, -20, 40])
    noise_px = 0.0

    def __init__(
        self, demonstrator_deg, noise_added_px=0.0, grid_px=0.0, hides=None, half_seen=0.0, late=0, offset_deg=0.0
    ):
        self.theta, self.demonstrator = self.start, np.radians(demonstrator_deg)
        self.noise, self.grid, self.hides, self.late = noise_added_px, grid_px, hides, late
        self.offset = np.radians(offset_deg)
        self.rng = np.random.default_rng(12)
        count = POINTS.shape[0] * POINTS.shape[1]
        self.lacks = np.zeros((count, 2), bool)
        chosen = self.rng.permutation(count)[: int(half_seen * count)]
        self.lacks[chosen, self.rng.integers(0, 2, len(chosen))] = True
        self.before = []

    def move(self, theta):
        self.theta = theta + self.offset
        return self.theta

    def look(self):
        demo = self.images(*body(self.demonstrator, (0.3, 3.0, -0.2), 2.8))
        own = self.images(*body(self.theta, (-0.2, 2.2, -0.3), 0.4))
        for k in range(2):
            demo[k][self.lacks[:, k]] = np.nan
        self.before.append(own)
        return FourViews.from_images(*demo, *self.before[max(len(self.before) - 1 - self.late, 0)])

    def images(self, points, normals):
        """Of a body in both cameras, two (24, 2) px, NaN where a point is hidden."""
        seen = []
        for eye in EYES_M:
            found = image(points, eye)
            if self.noise:
                found = found + self.noise * self.rng.standard_normal(found.shape)
            if self.grid:
                found = self.grid * np.round(found / self.grid)
            if self.hides is not None:
                ways = np.array([eye, 0.0, 0.0]) - points
                lengths = np.linalg.norm(normals, axis=1) * np.linalg.norm(ways, axis=1)
                found[(normals * ways).sum(1) <= self.hides * lengths] = np.nan
            seen.append(found)
        return seen
