"""Which of the postures visited is the best, where other points are seen at each."""

import numpy as np

from viewimit.servo.outlook import measure
from viewimit.servo.visit import Visit

POINTS, FEW, MANY = 14, 7, 12
FAR = np.radians((40.0, 0.0))  # what was seen there tells next to nothing here


def visit(away, count):
    """The first so many of the points are seen."""
    seen = np.repeat((np.arange(POINTS) < count)[:, None], 2, 1)
    return Visit.of(away, np.zeros((POINTS, 4)), seen)


def test_what_seven_points_contradict_counts_for_more_than_what_twelve_do():
    """3 coordinates each, of which a homography of space and two joints fit 17 at any posture: 4 of 21 are left, and 19
    of 36. An E that is half as large is no evidence of a better posture then, but one a tenth as large is."""
    visits = visit(np.zeros(2), FEW), visit(FAR, MANY)

    def conflict(share):
        def residual(own, by=None, like=None, head=0):
            known = np.isfinite(own).all(-1)
            size = share if known.sum() == FEW else 1.0
            return np.full((int(known.sum()), 4), np.sqrt(size))

        return residual

    for share, best in ((0.5, 1), (0.1, 0)):
        measured = measure(visits, 0.0, conflict(share), None)
        assert measured.count.tolist() == [FEW, MANY] and measured.best == best
