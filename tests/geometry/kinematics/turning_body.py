"""A body of links in a chain before two cameras, posed by a plain loop: which kinematics must predict."""

import numpy as np

from viewimit.geometry.kinematics.clusters import Observations


class TurningBody:
    """on: for each point how many of the joints move it. sliding: joints that slide instead of turning. slip: share by
    which each point turns farther than the one before it, as no rigid body does. The cameras have parallel axes, and
    unlike focal lengths and centres. Displacements are measured from `at`, rad."""

    def __init__(self, rng, on, joints, sliding=(), slip=0.0):
        self.on, self.joints, self.sliding, self.slip = on, joints, sliding, slip
        self.axes = rng.normal(size=(joints, 3))
        self.axes /= np.linalg.norm(self.axes, axis=1, keepdims=True)
        self.through = np.array([0.1, 0.0, 1.6]) + rng.uniform(-0.2, 0.2, (joints, 3))
        self.points = np.array([0.1, 0.0, 1.6]) + rng.uniform(-0.3, 0.3, (len(on), 3))
        self.at = rng.uniform(-0.5, 0.5, joints)

    def images(self, displacement):
        """(N, 4) px"""
        return seen(self.places(displacement))

    def places(self, displacement):
        """(N, 3) m, before the cameras."""
        found = []
        for k, (point, on) in enumerate(zip(self.points, self.on)):
            for joint in reversed(range(on)):
                angle = (self.at + displacement)[joint] * (1 + self.slip * k)
                if joint in self.sliding:
                    point = point + 0.2 * angle * self.axes[joint]
                else:
                    point = self.through[joint] + rotated(point - self.through[joint], self.axes[joint], angle)
            found.append(point)
        return np.array(found)

    def observations(self, displacements, visible=None, noise=0.0):
        images = np.array([self.images(d) for d in displacements]) + noise
        visible = np.ones(images.shape[:2], bool) if visible is None else visible
        return Observations(np.array(displacements), np.where(visible[..., None], images, np.nan), visible)

    def probes(self, turn=0.26):
        """(m + 1, m): where it begins, and on by each joint in turn."""
        return np.vstack([np.zeros(self.joints), np.cumsum(turn * np.eye(self.joints), axis=0)])


def seen(places):
    """Images of points (N, 3) m, (N, 4) px."""
    x, y, z = places.T
    return np.stack([300 * x / z + 150, 280 * y / z + 110, 420 * (x - 0.4) / z + 170, 280 * y / z + 110], 1)


def rotated(vector, axis, angle):
    """Rodrigues' formula."""
    cos, sin = np.cos(angle), np.sin(angle)
    return cos * vector + sin * np.cross(axis, vector) + (1 - cos) * (axis @ vector) * axis
