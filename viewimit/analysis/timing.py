"""Notice two cameras that are not in time, by points that move.

A camera that is late by δ frames shows a point where it was: its match misses the epipolar line by δ v, where v is the
point's speed across that line [px a frame]. So the misfit of left and right grows with the speed, and pairing each left
image with a later or earlier right one removes it. One fundamental matrix is fitted for each shift by whole frames, and
the rest of the shift is estimated by linear regression of the misfit on v. Parts of a run have their own shifts, as a
camera that loses a frame is late from then on only.
"""

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..geometry.arrays import Floats
from ..geometry.fundamental import MIN_MATCHES, fit_fundamental, sampson_distance

MAX_SHIFT = 15  # frames: half a second
MIN_FRAMES = 8  # of both cameras, with MIN_MATCHES matches or more in all
MAX_FRAMES = 120  # that are compared, evenly spaced
PARTS, MIN_PART = 4, 15  # parts of a run, at most, and frames of each
MIN_MOVING = 3  # points
MIN_MOTION = 5.0  # of the noise: standard deviation over time, from which a point moves
MIN_GAIN, GAIN_SIGMA = 0.12, 4.0  # relative fall of the rms misfit; in standard deviations of it
MIN_SHIFT = 0.2  # frames
SAME_SHARE = 0.25  # of a shift, or one frame, by which estimates may differ
MAX_LEFT_OUT = 3  # points
MAX_ROWS = 1.05  # relative misfit of parallel cameras, up to which they need no other geometry
ROUNDS = 3  # of choosing shifts and fitting the fundamental matrix
N_REWEIGHTINGS = 1  # of a fit
NOISE_FLOOR_PX = 1e-2  # rms misfit, below which nothing is doubted
TINY = 1e-12

Ints = NDArray[np.int_]
Fit = Callable[[Floats, Floats], Floats]  # of a fundamental matrix to matches
Parts = tuple[tuple[int, float], ...]


@dataclass(frozen=True)
class TimeShift:
    """How late the right camera is, in one or several parts of a run."""

    parts: Parts  # index of the first frame, and frames by which the right camera is late
    rms_px: float  # misfit of left and right as they are
    shifted_px: float  # and without the shift
    telling: int  # index of the point that shows it most

    def is_like(self, other: "TimeShift") -> bool:
        """Whether the largest shift is the same, but for noise."""
        return abs(self.largest - other.largest) <= max(1.0, SAME_SHARE * abs(self.largest))

    @property
    def largest(self) -> float:
        """Frames, of the part with the largest shift."""
        return max((late for _, late in self.parts), key=abs)


def find_time_shift(images: Floats) -> TimeShift | None:
    """Find out whether the right camera shows another moment than the left one. images: (T, N, 4) left and right image
    of one body's points in frames of equal distance [px], NaN where they are not seen. Returns None if they are in
    time, or the images do not tell: too few frames, or too little motion."""
    found, left = _search(images), images
    for _ in range(MAX_LEFT_OUT if found else 0):  # one misplaced point could feign a shift
        assert found is not None
        left = left[:, np.arange(left.shape[1]) != found.telling]
        again = _search(left, share=0.5)
        if again is None or found.is_like(again):
            return again and found
        found = again
    return None


def _search(images: Floats, share: float = 1.0) -> TimeShift | None:
    """As `find_time_shift`, of all points alike. share: of the usual gain, which is asked for."""
    n_frames = len(images)
    n_shifts = min(MAX_SHIFT, (n_frames - MIN_FRAMES) // 2)
    if n_shifts < 1:
        return None
    pairs = {shift: _pairs(images, shift) for shift in range(-n_shifts, n_shifts + 1)}
    pairs = {shift: each for shift, each in pairs.items() if each.are_enough}
    if 0 not in pairs:
        return None
    fit, fits, rests = _rows, *_fits(_rows, pairs)
    best = min(rests, key=lambda shift: rests[shift].rms_px)
    for_all, rests_for_all = _fits(_epipolar, pairs)
    if rests[best].rms_px > MAX_ROWS * min(rest.rms_px for rest in rests_for_all.values()):
        fit, fits, rests = _epipolar, for_all, rests_for_all
        best = min(rests, key=lambda shift: rests[shift].rms_px)
    plain_px = float(np.sqrt(np.mean(sampson_distance(fits[0], pairs[0].left, pairs[0].right) ** 2)))
    parts: Parts = ((0, best + rests[best].late),)
    rms_px = rests[best].rms_px
    for start in {0, best}:
        several = _of_parts(pairs, fit, fits[start], len(images))
        if several is not None and several[1] < rms_px * (1 - _least_gain(len(pairs[0].left) // len(several[0]))):
            parts, rms_px = several
    if plain_px < NOISE_FLOOR_PX:
        return None
    is_small = max(abs(late) for _, late in parts) < MIN_SHIFT
    least = share * _least_gain(len(pairs[0].left))
    if is_small or rms_px > plain_px * (1 - least) or _n_moving(images, rms_px) < MIN_MOVING:
        return None
    squares = [
        np.bincount(pairs[s].point, sampson_distance(fits[s], pairs[s].left, pairs[s].right) ** 2, images.shape[1])
        / np.bincount(pairs[s].point, minlength=images.shape[1]).clip(1)
        for s in (0, best if best else min(pairs, key=lambda s: abs(s - max((late for _, late in parts), key=abs))))
    ]
    gains = squares[0] - squares[1]
    return TimeShift(parts, plain_px, rms_px, int(gains.argmax()))


@dataclass(frozen=True)
class _Pairs:
    """M matches of a shift: left images of some frames, and right ones of later frames."""

    frame: Ints  # (M,) of the left image
    point: Ints  # (M,)
    left: Floats  # (M, 2) px
    right: Floats  # (M, 2) px
    speed: Floats  # (M, 2) px a frame, of the right image

    @property
    def are_enough(self) -> bool:
        return len(np.unique(self.frame)) >= MIN_FRAMES and len(self.left) >= MIN_MATCHES + MIN_FRAMES

    def within(self, first: int, last: int) -> "_Pairs":
        """Those of the frames from the first to before the last."""
        kept = (first <= self.frame) & (self.frame < last)
        return _Pairs(*(each[kept] for each in vars(self).values()))


@dataclass(frozen=True)
class _Rest:
    """What matches miss their epipolar lines by, without what their speed explains."""

    rms_px: float
    late: float  # frames, by which the right images show an earlier moment


def _pairs(images: Floats, shift: int) -> _Pairs:
    frames = np.arange(max(0, -shift), len(images) - max(0, shift))
    frames = frames[:: max(1, -(-len(frames) // MAX_FRAMES))]
    there = frames + shift
    left, right = images[frames, :, :2], images[there, :, 2:]
    v = (images[np.minimum(there + 1, len(images) - 1), :, 2:] - images[np.maximum(there - 1, 0), :, 2:]) / 2
    v[(there == 0) | (there == len(images) - 1)] = np.nan
    seen = np.isfinite(np.concatenate([left, right, v], -1)).all(-1)
    frame, point = np.nonzero(seen)
    return _Pairs(frames[frame], point, left[seen], right[seen], v[seen])


def _epipolar(left: Floats, right: Floats) -> Floats:
    """The fundamental matrix of any cameras."""
    return fit_fundamental(left, right, N_REWEIGHTINGS)


def _rows(left: Floats, right: Floats) -> Floats:
    """The fundamental matrix of parallel cameras, which see a point in the same row, but for a constant."""
    return np.array([[0, 0, 0], [0, 0, -1], [0, 1, float(np.mean(right[:, 1] - left[:, 1]))]])


def _fits(fit: Fit, pairs: Mapping[int, _Pairs]) -> tuple[dict[int, Floats], dict[int, _Rest]]:
    """The fundamental matrix of each shift, and what it leaves."""
    fits = {shift: fit(each.left, each.right) for shift, each in pairs.items()}
    return fits, {shift: _rest(fits[shift], pairs[shift]) for shift in pairs}


def _rest(F: Floats, pairs: _Pairs) -> _Rest:
    """Estimate how late the right images are, by linear regression of the distances from F's lines on the speed."""
    ends = [sampson_distance(F, pairs.left, pairs.right + sign * pairs.speed / 2) for sign in (1, -1)]
    distance, across = sampson_distance(F, pairs.left, pairs.right), ends[0] - ends[1]
    slope = float(np.clip(distance @ across / max(float(across @ across), TINY), -1, 1))
    return _Rest(float(np.sqrt(np.mean((distance - slope * across) ** 2))), -slope)


def _of_parts(pairs: Mapping[int, _Pairs], fit: Fit, F: Floats, n_frames: int) -> tuple[Parts, float] | None:
    """Shifts of parts of a run with one fundamental matrix, from an initial one, and the rms misfit [px].

    None for a run that is too short.
    """
    edges = np.linspace(0, n_frames, 1 + min(PARTS, n_frames // MIN_PART)).astype(int)
    if len(edges) < 3:
        return None
    parts = [{s: each.within(*ends) for s, each in pairs.items()} for ends in zip(edges, edges[1:])]
    parts = [{s: each for s, each in part.items() if each.are_enough} for part in parts]
    if not all(parts):
        return None
    for _ in range(ROUNDS):
        rests = [{s: _rest(F, each) for s, each in part.items()} for part in parts]
        chosen = [min(rest, key=lambda s: rest[s].rms_px) for rest in rests]
        those = [part[s] for part, s in zip(parts, chosen)]
        F = fit(np.concatenate([each.left for each in those]), np.concatenate([each.right for each in those]))
    found = [_rest(F, each) for each in those]
    counts = [len(each.left) for each in those]
    rms_px = float(np.sqrt(np.average([rest.rms_px**2 for rest in found], weights=counts)))
    return tuple((int(first), s + rest.late) for first, s, rest in zip(edges, chosen, found)), rms_px


def _n_moving(images: Floats, noise_px: float) -> int:
    """How many points move by more than noise."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of points that are never seen
        return int((np.nanstd(images, axis=0).max(-1) > MIN_MOTION * noise_px).sum())


def _least_gain(count: int) -> float:
    """Relative fall of the rms of `count` distances that is no chance."""
    return max(MIN_GAIN, GAIN_SIGMA / np.sqrt(2 * max(count, 1)))
