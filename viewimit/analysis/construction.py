"""How one point is recovered: what is known of it in [l], [r], and how surely that tells its place in [L], [R].

A transfer that crosses epipolar lines has an angle at which those from [l] and from [r] meet. Every other one is a
function of the shape: from the points' middle as many steps along each of the shape's three directions as lead to the
point in [l], [r], and the same steps carried over.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..geometry.affine import INTO, SOURCE
from ..loop.snapshot import Snapshot

ASIDE = 0.5  # px, of the differences
NEAR = ASIDE * np.concatenate([np.eye(4), -np.eye(4), np.zeros((1, 4))])  # each coordinate aside, and the point itself
SURE = -2 * np.log(0.05)  # the squared distance, in standard deviations, within which 95 % of a plane's normal lie
DIRECTIONS = 3  # of a shape in space
MEET = np.array([[np.flatnonzero((INTO == into) & (SOURCE == eye))[0] for eye in (0, 1)] for into in (2, 3)])  # in L, R


@dataclass(frozen=True)
class Construction:
    """recovered: (2, 2) px in L, R; half_axes: (2, 2) px in L, R, the longer one first, and direction: (2,) rad of
    that: where it is in 95 % of cases if each coordinate in [l], [r] is 1 px off, standard deviation, and the transfer
    as it is;
    angle: (2,) rad, 0 … π/2, at which the lines from [l] and [r]
    cross in L and in R, None if none do; steps: (4, 5, 2) px in l, r, L, R, from the points' middle to the point, None
    if lines are crossed."""

    recovered: NDArray
    half_axes: NDArray
    direction: NDArray
    angle: NDArray | None
    steps: NDArray | None


def construct(snapshot: Snapshot, point: int) -> Construction | None:
    """Of a point by its index; None unless it is seen in all four views, and enough others are."""
    transfer = snapshot.transfer
    if transfer is None or not snapshot.usable[point]:
        return None
    near = snapshot.views.demo[point] + NEAR
    found = transfer.recover(near[:, :2], near[:, 2:])
    slope = (found[:4] - found[4:8]) / (2 * ASIDE)  # of [l r], of x and y in L and R
    spread = (slope.T @ slope).tolist()
    ellipses = [_ellipse(spread[x][x], spread[x][x + 1], spread[x + 1][x + 1]) for x in (0, 2)]
    crossing = snapshot.method.crosses_lines
    lines = snapshot.epipolar_lines(point) if crossing else None
    return Construction(
        recovered=found[8].reshape(2, 2),
        half_axes=np.array([half_axes for half_axes, _ in ellipses]),
        direction=np.array([direction for _, direction in ellipses]),
        angle=None if lines is None else _angles(lines),
        steps=None if crossing else _steps(snapshot, point),
    )


# one point's two ellipses and angles are soon told number by number: each call of numpy takes as long as one of them
def _ellipse(xx: float, xy: float, yy: float) -> tuple[tuple[float, float], float]:
    """Half axes px, the longer one first, and its direction, rad, of a covariance, px²."""
    middle, apart = (xx + yy) / 2, math.hypot((xx - yy) / 2, xy)
    longest = middle + apart
    shortest = (xx * yy - xy * xy) / longest if longest > 0 else 0.0  # middle - apart would cancel
    axes = math.sqrt(SURE * longest), math.sqrt(SURE * max(shortest, 0.0))
    return axes, math.atan2(2 * xy, xx - yy) / 2


def _angles(lines: NDArray) -> NDArray:
    """lines: (12, 3), as `Snapshot.epipolar_lines` has them → (2,) rad"""
    sines = [
        abs(a * d - b * c) / max(math.hypot(a, b) * math.hypot(c, d), 1e-300)
        for (a, b), (c, d) in lines[MEET, :2].tolist()  # in L, R; from l, r; x, y
    ]
    return np.array([math.asin(min(sine, 1.0)) for sine in sines])


def _steps(snapshot: Snapshot, point: int) -> NDArray:
    """The point's centred coordinates in [l r], direction by direction of the shape, and what the transfer makes of
    each stop: (4, 5, 2) px. The last step is what the shape leaves over: affine cameras leave nothing."""
    demo = snapshot.views.used.demo
    mean = demo.mean(0)
    directions = np.linalg.svd(demo - mean, full_matrices=False)[2][:DIRECTIONS]
    away = snapshot.views.demo[point] - mean
    stops = mean + np.cumsum(np.concatenate([np.zeros((1, 4)), (directions @ away)[:, None] * directions]), 0)
    stops = np.concatenate([stops, snapshot.views.demo[point][None]])
    assert snapshot.transfer is not None
    images = np.concatenate([stops, snapshot.transfer.recover(stops[:, :2], stops[:, 2:])], 1)
    return images.reshape(-1, 4, 2).transpose(1, 0, 2)
