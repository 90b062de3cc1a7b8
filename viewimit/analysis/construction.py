"""How one point is recovered: what is known of it in [l], [r], and how surely that tells its place in [L], [R].

A transfer that crosses epipolar lines has an angle at which those from [l] and from [r] meet. Every other one is a
function of the shape: from the points' middle as many steps along each of the shape's three directions as lead to the
point in [l], [r], and the same steps carried over.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..geometry.pairs import INTO, SOURCE
from ..snapshot import Snapshot
from ..transfer import TRANSFERS

ASIDE = 0.5  # px, of the differences
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
    transfer, lines = snapshot.transfer, snapshot.epipolar_lines(point)
    if transfer is None or lines is None or not snapshot.usable[point]:
        return None
    demo = snapshot.views.demo[point]
    aside = ASIDE * np.eye(4)
    near = np.concatenate([demo + aside, demo - aside, demo[None]])
    found = transfer.recover(near[:, :2], near[:, 2:])
    slope = ((found[:4] - found[4:8]) / (2 * ASIDE)).reshape(4, 2, 2)  # of [l r], of L and R, of x and y
    half_axes, direction = _ellipses(np.einsum("koi,koj->oij", slope, slope))
    crossing = TRANSFERS[snapshot.settings.transfer].crosses_lines
    return Construction(
        recovered=found[8].reshape(2, 2),
        half_axes=half_axes,
        direction=direction,
        angle=_angles(lines) if crossing else None,
        steps=None if crossing else _steps(snapshot, point),
    )


def _ellipses(spread: NDArray) -> tuple[NDArray, NDArray]:
    """Half axes (k, 2) px and directions (k,) rad of covariances (k, 2, 2) px²."""
    squares, axes = np.linalg.eigh(spread)
    return np.sqrt(SURE * np.maximum(squares[:, ::-1], 0.0)), np.arctan2(axes[:, 1, 1], axes[:, 0, 1])


def _angles(lines: NDArray) -> NDArray:
    """lines: (12, 3), as `Snapshot.epipolar_lines` has them → (2,) rad"""
    normals = lines[MEET, :2]  # in L, R; from l, r; x, y
    lengths = np.linalg.norm(normals, axis=-1)
    across = np.abs(normals[:, 0, 0] * normals[:, 1, 1] - normals[:, 0, 1] * normals[:, 1, 0])
    return np.arcsin(np.clip(across / np.maximum(lengths.prod(-1), 1e-300), 0.0, 1.0))


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
