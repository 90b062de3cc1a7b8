"""Leave-one-out errors of all transfers on tracked points: each point is predicted by a transfer fitted to the others.

They show which transfer suits the cameras, and whether rectification helps. For cameras with parallel axes a
fundamental matrix may fit the matches better than an affine one, because it also fits what the lenses have left there.
Its rectification then makes predictions worse. So a rectification is kept only if predictions become clearly better.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..estimation.outliers import select_matches
from ..estimation.transfers import TRANSFERS
from ..estimation.views import FourViews, dimensions
from ..geometry.affine import MIN_POINTS
from ..geometry.fundamental import DEGREES_OF_FREEDOM, fit_fundamental_with_prior, sampson_distance
from ..geometry.rectification import Rectification, fit_rectification, fit_rectification_with_prior, rectify

FRAMES, POINTS = 50, 50  # evenly spaced: frames, and points of each, that are left out one by one
MATCH_FRAMES, MAX_MATCHES = 200, 2000  # frames whose matches determine a rectification, and matches of those
BATCH_POINTS = 200_000  # points in fits made at a time, for memory's sake
JUDGE = "projective"  # the transfer whose errors decide: rectification makes it exact
MAX_RATIO, N_SIGMA = 0.95, 2.0  # bound of the ratio of rectified to raw error; standard errors in it
MAX_NOISE_RATIO, MIN_FIT_PX = 10.0, 0.1  # largest errors that fit the cameras: times the noise, and px
MIN_ERROR_PX = 1e-3  # smaller errors count as this
SPACE_DIMENSIONS = 3  # of points that determine a transfer


@dataclass(frozen=True)
class LeaveOneOut:
    """Leave-one-out errors, rms px over points, frames and the images [L] and [R]."""

    error_px: Mapping[str, float]  # by transfer, of the images as they are; empty if no frame has six usable points
    rectified_px: Mapping[str, float] | None = None  # by transfer, of rectified images; None if none were compared
    ratio: float | None = None  # rectified over raw error of JUDGE, the geometric mean over frames in which it fits
    ratio_bound: float | None = None  # N_SIGMA standard errors above the ratio; None without frames that fit
    rectification: Rectification | None = None  # the one that helps, or without a bound the matches' own; None to skip
    predictions: int = 0  # made
    of_predictions: int = 0  # points in all frames of six usable points or more
    frames: int = 0  # used
    of_frames: int = 0  # frames of six usable points or more
    sampled: bool = False  # whether evenly spaced frames or points stand for too many


def leave_one_out(views: FourViews, rectifying: bool = True) -> LeaveOneOut:
    """Measure the errors of every transfer, and find the rectification that lowers them. views: T frames of N points,
    (T, N, …); rectifying: whether to compare rectified images."""
    usable = np.flatnonzero(views.usable.sum(-1) > MIN_POINTS)
    frames = usable[_spaced(len(usable), FRAMES)]
    matches, points = _matches(views, np.union1d(frames, _spaced(len(views.demo), MATCH_FRAMES)))
    found = fit_rectification_with_prior(matches[:, :2], matches[:, 2:]) if rectifying else None
    made = _predictions(views, frames, None if found is None else _RectificationWithout(matches, points))
    ratio = bound = None
    if found is not None:
        ratio, bound = _ratio(made, MAX_NOISE_RATIO * _noise_px(matches))
        if bound is None:
            found = fit_rectification(*np.split(select_matches(views), 2, axis=1))
        elif bound > MAX_RATIO:
            found = None
    return LeaveOneOut(
        error_px=_rms(made.raw),
        rectified_px=_rms(made.rectified) if made.rectified else None,
        ratio=ratio,
        ratio_bound=bound,
        rectification=found,
        predictions=len(made.frame),
        of_predictions=(whole := int(views.usable[usable].sum())),
        frames=len(np.unique(made.frame)),
        of_frames=len(usable),
        sampled=made.asked < whole,
    )


@dataclass(frozen=True)
class _Predictions:
    """Errors of P predictions."""

    asked: int  # points left out; for P of them the others determine a transfer
    frame: NDArray  # (P,)
    point: NDArray  # (P,)
    raw: dict[str, NDArray]  # by transfer (P,) px, of the images as they are; empty if none was made
    rectified: dict[str, NDArray]  # the same of rectified images


class _RectificationWithout(dict[int, Rectification]):
    """By point: the rectification fitted to the matches of all other points. matches: (M, 4) px; points: (M,)."""

    def __init__(self, matches: NDArray, points: NDArray):
        self._matches, self._points = matches, points

    def __missing__(self, point: int) -> Rectification:
        left, right = np.split(self._matches[self._points != point], 2, axis=1)
        self[point] = rectify(fit_fundamental_with_prior(left, right), left, right)
        return self[point]


def _predictions(views: FourViews, frames: NDArray, without: _RectificationWithout | None) -> _Predictions:
    """Predict in the given frames; frames with the same usable points together."""
    asked, of = 0, [np.zeros((2, 0), int)]
    errors: tuple[dict[str, list[NDArray]], ...] = ({}, {})
    patterns, kind = np.unique(views.usable[frames], axis=0, return_inverse=True)
    for k, usable in enumerate(patterns):
        names, alike = np.flatnonzero(usable), frames[kind.ravel() == k]
        left_out = _spaced(len(names), min(POINTS, max(BATCH_POINTS // len(names), 1)))
        variants: list[list[Rectification | None]] = [[None] * len(left_out)]
        if without is not None:
            variants.append([without[int(name)] for name in names[left_out]])
        size = len(alike) * len(left_out) * len(names)
        for at in np.array_split(alike, -(-size // BATCH_POINTS)):
            some = FourViews(views.demo[at], views.own[at], views.visible[at]).select(names)
            determined = _determined(some, left_out)
            asked += len(determined)
            if not determined.any():
                continue
            of.append(np.stack([np.repeat(at, len(left_out)), np.tile(names[left_out], len(at))])[:, determined])
            for by, kept in zip(variants, errors):
                for name, px in _errors(some, left_out, determined, by).items():
                    kept.setdefault(name, []).append(px)
    raw, rectified = ({name: np.concatenate(px) for name, px in kept.items()} for kept in errors)
    frame, point = np.concatenate(of, 1)
    return _Predictions(asked, frame, point, raw, rectified)


def _determined(views: FourViews, left_out: NDArray) -> NDArray:
    """(T K,) bool: whether the points other than each of left_out, (K,), span space and so determine a transfer."""
    rest = _others(views.demo.shape[-2], left_out)
    fill = [dimensions(images[:, rest]) >= SPACE_DIMENSIONS for images in (views.demo, views.own)]
    return np.asarray((fill[0] & fill[1]).ravel())


def _errors(
    views: FourViews, left_out: NDArray, determined: NDArray, by: Sequence[Rectification | None]
) -> dict[str, NDArray]:
    """By transfer px, of the (T K,) predictions that `determined` selects. by: a rectification for each of the K."""
    rest = _others(views.demo.shape[-2], left_out)
    sides = [
        np.stack([images if one is None else one.apply(images) for one in by], 1) for images in (views.demo, views.own)
    ]
    demo, own = (np.take_along_axis(images, rest[None, ..., None], 2) for images in sides)
    demo, own = (images.reshape(-1, *images.shape[2:])[determined] for images in (demo, own))
    asked = np.take_along_axis(sides[0], left_out[None, :, None, None], 2).reshape(-1, 1, 4)[determined]
    truth = views.own[:, left_out].reshape(-1, 4)[determined]
    fitted_to = FourViews(demo, own, np.ones(demo.shape, bool))
    which = np.tile(np.arange(len(left_out)), len(views.demo))[determined]
    found = {}
    for name, method in TRANSFERS.items():
        predicted = method(fitted_to).recover(asked[..., :2], asked[..., 2:])[:, 0]
        for k, one in enumerate(by):
            if one is not None:
                predicted[which == k] = one.restore(predicted[which == k])
        found[name] = np.sqrt(np.square(truth - predicted).sum(-1) / 2)
    return found


def _others(count: int, left_out: NDArray) -> NDArray:
    """(K, count - 1): all points but one each."""
    return np.array([np.delete(np.arange(count), point) for point in left_out])


def _ratio(made: _Predictions, fit_px: float) -> tuple[float, float] | tuple[None, None]:
    """Ratio of rectified to raw errors of JUDGE, over frames where either is small, and its upper bound.

    Its standard error is that of points, because errors of one point in several frames are correlated.
    """
    if not made.rectified:
        return None, None
    raw, rectified = (np.log(np.maximum(errors[JUDGE], MIN_ERROR_PX)) for errors in (made.raw, made.rectified))
    fits = np.zeros(len(made.frame), bool)
    for frame in np.unique(made.frame):
        of = made.frame == frame
        fits[of] = np.exp(min(raw[of].mean(), rectified[of].mean())) <= max(fit_px, MIN_FIT_PX)
    if not fits.any():
        return None, None
    gain = (rectified - raw)[fits]
    _, point, count = np.unique(made.point[fits], return_inverse=True, return_counts=True)
    off = np.bincount(point, gain - gain.mean())  # (points,), summed over frames
    error = np.sqrt(off @ off * len(count) / max(len(count) - 1, 1)) / len(gain)
    return float(np.exp(gain.mean())), float(np.exp(gain.mean() + N_SIGMA * error))


def _rms(errors: Mapping[str, NDArray]) -> dict[str, float]:
    return {name: float(np.sqrt(np.mean(px**2))) for name, px in errors.items() if len(px)}


def _noise_px(matches: NDArray) -> float:
    """Standard deviation of matches from their fundamental matrix."""
    left, right = np.split(matches, 2, axis=1)
    away = sampson_distance(fit_fundamental_with_prior(left, right), left, right)
    return float(np.sqrt(away @ away / max(len(away) - DEGREES_OF_FREEDOM, 1)))


def _matches(views: FourViews, frames: NDArray) -> tuple[NDArray, NDArray]:
    """Distinct matches of left and right, (M, 4) px, of both bodies, and the point of each, (M,)."""
    found, points = [], []
    for images, seen in views.bodies:
        both = seen[frames].all(-1)
        found.append(images[frames][both])
        points.append(np.nonzero(both)[1])
    matches, first = np.unique(np.concatenate(found), axis=0, return_index=True)
    some = _spaced(len(matches), MAX_MATCHES)
    return matches[some], np.concatenate(points)[first[some]]


def _spaced(count: int, most: int) -> NDArray:
    """At most `most` indices below `count`, evenly spaced."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).astype(int))
