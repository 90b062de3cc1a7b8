"""How one point is transferred from [l], [r] to [L], [R], and how noise spreads its place there.

A transfer that intersects epipolar lines has an angle at which the lines from [l] and from [r] meet. Every other one
maps the shape: the steps from the centroid to the point along the shape's three principal directions are transferred.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..geometry.affine import LINE_VIEWS, POINT_VIEWS
from ..geometry.arrays import Floats
from ..loop.snapshot import Snapshot

FD_STEP_PX = 0.5
FD_OFFSETS = FD_STEP_PX * np.concatenate([np.eye(4), -np.eye(4), np.zeros((1, 4))])  # the last is the point itself
CHI2_95 = -2 * np.log(0.05)  # 95 % quantile of χ² with two degrees of freedom
SHAPE_RANK = 3  # of centred points in space
CROSSING = np.array(
    [[np.flatnonzero((LINE_VIEWS == into) & (POINT_VIEWS == eye))[0] for eye in (0, 1)] for into in (2, 3)]
)  # in L, R


@dataclass(frozen=True)
class Construction:
    """The transfer of one point. The 95 % ellipses are for noise of 1 px in each coordinate of [l], [r]."""

    recovered: Floats  # (2, 2) px in L, R
    half_axes: Floats  # (2, 2) px of the ellipses in L, R, the longer one first
    direction: Floats  # (2,) rad of the longer half axis
    angle: Floats | None  # (2,) rad, 0 … π/2, between the lines in L, R; None without lines
    steps: Floats | None  # (4, 5, 2) px in l, r, L, R, from the centroid to the point; None with lines


def construct(snapshot: Snapshot, point: int) -> Construction | None:
    """Construct the transfer of a point, given by index; None unless it is usable and a transfer is fitted."""
    transfer = snapshot.transfer
    if transfer is None or not snapshot.usable[point]:
        return None
    near = snapshot.views.demo[point] + FD_OFFSETS
    found = transfer.recover(near[:, :2], near[:, 2:])
    slope = (found[:4] - found[4:8]) / (2 * FD_STEP_PX)  # of [l r], of x and y in L and R
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


# Scalars instead of arrays: one numpy call takes as long as a whole ellipse computed number by number.
def _ellipse(xx: float, xy: float, yy: float) -> tuple[tuple[float, float], float]:
    """Return the half axes, px, the longer one first, and its direction, rad, of a covariance, px²."""
    mean, radius = (xx + yy) / 2, math.hypot((xx - yy) / 2, xy)
    longest = mean + radius
    shortest = (xx * yy - xy * xy) / longest if longest > 0 else 0.0  # mean - radius would cancel
    axes = math.sqrt(CHI2_95 * longest), math.sqrt(CHI2_95 * max(shortest, 0.0))
    return axes, math.atan2(2 * xy, xx - yy) / 2


def _angles(lines: NDArray) -> NDArray:
    """Angles, (2,) rad, between lines (12, 3) as of `Snapshot.epipolar_lines`."""
    sines = [
        abs(a * d - b * c) / max(math.hypot(a, b) * math.hypot(c, d), 1e-300)
        for (a, b), (c, d) in lines[CROSSING, :2].tolist()  # in L, R; from l, r; x, y
    ]
    return np.array([math.asin(min(sine, 1.0)) for sine in sines])


def _steps(snapshot: Snapshot, point: int) -> NDArray:
    """Partial sums of the point's principal components in [l r], and their transfer: (4, 5, 2) px.

    The last step is the remainder beyond rank 3, which is zero for affine cameras.
    """
    demo = snapshot.views.used.demo
    mean = demo.mean(0)
    directions = np.linalg.svd(demo - mean, full_matrices=False)[2][:SHAPE_RANK]
    away = snapshot.views.demo[point] - mean
    stops = mean + np.cumsum(np.concatenate([np.zeros((1, 4)), (directions @ away)[:, None] * directions]), 0)
    stops = np.concatenate([stops, snapshot.views.demo[point][None]])
    assert snapshot.transfer is not None
    images = np.concatenate([stops, snapshot.transfer.recover(stops[:, :2], stops[:, 2:])], 1)
    return images.reshape(-1, 4, 2).transpose(1, 0, 2)
