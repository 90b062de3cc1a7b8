"""Leave-one-out errors of all transfers on tracked points: each point is predicted by a transfer fitted to the others.

They tell which transfer fits the cameras, and whether rectified images serve it better. A fundamental matrix may fit
matches of cameras with parallel axes better than an affine one, as it also fits what lenses have left there, and yet
its rectification makes predictions worse. So it is kept only where predictions become clearly better by it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..estimation.outliers import select_matches
from ..estimation.transfers import TRANSFERS
from ..estimation.views import FourViews, dimensions
from ..geometry.affine import MIN_POINTS
from ..geometry.fundamental import FREE, fit_fundamental_with_prior, sampson_distance
from ..geometry.rectification import Rectification, rectification_of, rectification_with_prior, rectify

FRAMES, POINTS = 50, 50  # evenly spaced: frames, and points of each, that are left out one by one
POOLED, MATCHES = 200, 2000  # frames whose matches tell a rectification, and matches of those
TOGETHER = 200_000  # points in fits made at a time, for memory's sake
JUDGE = "projective"  # the transfer whose errors decide: rectification makes it exact
GAIN, SURE = 0.95, 2.0  # rectified over raw errors: so many standard errors below it images are rectified
ALIKE, ALIKE_PX = 10.0, 0.1  # times the noise of matches, and px: larger errors tell little of the cameras
EXACT_PX = 1e-3  # errors below it are compared as if they were as large
SPACE = 3  # dimensions of points that tell a transfer


@dataclass(frozen=True)
class LeaveOneOut:
    """Leave-one-out errors, rms px over points, frames and the images [L] and [R].

    error_px: by transfer, of the images as they are; empty if no frame has six usable points.
    rectified_px: by transfer, of rectified images; None where nothing can or need be rectified, or that was not asked.
    ratio: rectified over raw error of the `JUDGE`, the geometric mean over predictions in the frames in which it fits;
    ratio_bound: what that is at most, `SURE` standard errors higher. None if there is no such frame, or nothing was
    compared.
    rectification: by which the bound is below `GAIN`; where there is none, that which the matches ask for; None if
    images are best left as they are.
    predictions, of_predictions: how many were made, of how many points in all frames of six usable points or more;
    frames, of_frames: how many of these were used, of how many; sampled: they, or points, are too many, and evenly
    spaced ones were taken.
    """

    error_px: Mapping[str, float]
    rectified_px: Mapping[str, float] | None = None
    ratio: float | None = None
    ratio_bound: float | None = None
    rectification: Rectification | None = None
    predictions: int = 0
    of_predictions: int = 0
    frames: int = 0
    of_frames: int = 0
    sampled: bool = False


def leave_one_out(views: FourViews, rectifying: bool = True) -> LeaveOneOut:
    """Errors of every transfer, and the rectification that lowers them.

    views: of T frames, (T, N, …). rectifying: whether rectified images are compared.
    """
    usable = np.flatnonzero(views.usable.sum(-1) > MIN_POINTS)
    frames = usable[_spaced(len(usable), FRAMES)]
    matches, points = _matches(views, np.union1d(frames, _spaced(len(views.demo), POOLED)))
    found = rectification_with_prior(matches[:, :2], matches[:, 2:]) if rectifying else None
    made = _predictions(views, frames, None if found is None else _Without(matches, points))
    ratio = bound = None
    if found is not None:
        ratio, bound = _ratio(made, ALIKE * _noise_px(matches))
        if bound is None:
            found = rectification_of(*np.split(select_matches(views), 2, axis=1))
        elif bound > GAIN:
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
    """Errors of P predictions.

    asked: how many points were left out; the others tell a transfer for P of them. frame, point: (P,), of each.
    raw, rectified: by transfer (P,) px, of the images as they are and of rectified ones; empty if none was made.
    """

    asked: int
    frame: NDArray
    point: NDArray
    raw: dict[str, NDArray]
    rectified: dict[str, NDArray]


class _Without(dict[int, Rectification]):
    """By point: the rectification that the matches of all other points tell. matches: (M, 4) px; points: (M,)."""

    def __init__(self, matches: NDArray, points: NDArray):
        self._matches, self._points = matches, points

    def __missing__(self, point: int) -> Rectification:
        left, right = np.split(self._matches[self._points != point], 2, axis=1)
        self[point] = rectify(fit_fundamental_with_prior(left, right), left, right)
        return self[point]


def _predictions(views: FourViews, frames: NDArray, without: _Without | None) -> _Predictions:
    """Of some frames, those whose points are seen alike together."""
    asked, of = 0, [np.zeros((2, 0), int)]
    errors: tuple[dict[str, list[NDArray]], ...] = ({}, {})
    patterns, kind = np.unique(views.usable[frames], axis=0, return_inverse=True)
    for k, usable in enumerate(patterns):
        names, alike = np.flatnonzero(usable), frames[kind.ravel() == k]
        left_out = _spaced(len(names), min(POINTS, max(TOGETHER // len(names), 1)))
        ways: list[list[Rectification | None]] = [[None] * len(left_out)]
        if without is not None:
            ways.append([without[int(name)] for name in names[left_out]])
        size = len(alike) * len(left_out) * len(names)
        for at in np.array_split(alike, -(-size // TOGETHER)):
            some = FourViews(views.demo[at], views.own[at], views.visible[at]).select(names)
            tells = _tells(some, left_out)
            asked += len(tells)
            if not tells.any():
                continue
            of.append(np.stack([np.repeat(at, len(left_out)), np.tile(names[left_out], len(at))])[:, tells])
            for by, kept in zip(ways, errors):
                for name, px in _errors(some, left_out, tells, by).items():
                    kept.setdefault(name, []).append(px)
    raw, rectified = ({name: np.concatenate(px) for name, px in kept.items()} for kept in errors)
    frame, point = np.concatenate(of, 1)
    return _Predictions(asked, frame, point, raw, rectified)


def _tells(views: FourViews, left_out: NDArray) -> NDArray:
    """(T K,) bool: whether the other points than each of left_out, (K,), tell a transfer: they fill space."""
    rest = _others(views.demo.shape[-2], left_out)
    fill = [dimensions(images[:, rest]) >= SPACE for images in (views.demo, views.own)]
    return np.asarray((fill[0] & fill[1]).ravel())


def _errors(
    views: FourViews, left_out: NDArray, tells: NDArray, by: Sequence[Rectification | None]
) -> dict[str, NDArray]:
    """By transfer px, of those of the (T K,) predictions that `tells` selects. by: a rectification each of the K."""
    rest = _others(views.demo.shape[-2], left_out)
    sides = [
        np.stack([images if one is None else one.apply(images) for one in by], 1) for images in (views.demo, views.own)
    ]
    demo, own = (np.take_along_axis(images, rest[None, ..., None], 2) for images in sides)
    demo, own = (images.reshape(-1, *images.shape[2:])[tells] for images in (demo, own))
    asked = np.take_along_axis(sides[0], left_out[None, :, None, None], 2).reshape(-1, 1, 4)[tells]
    truth = views.own[:, left_out].reshape(-1, 4)[tells]
    fitted_to = FourViews(demo, own, np.ones(demo.shape, bool))
    which = np.tile(np.arange(len(left_out)), len(views.demo))[tells]
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


def _ratio(made: _Predictions, alike_px: float) -> tuple[float, float] | tuple[None, None]:
    """Rectified over raw errors of the JUDGE, where either is no more than noise, and what that ratio is at most.

    Its standard error is that of points, as the errors of one in several frames have much in common.
    """
    if not made.rectified:
        return None, None
    raw, rectified = (np.log(np.maximum(errors[JUDGE], EXACT_PX)) for errors in (made.raw, made.rectified))
    fits = np.zeros(len(made.frame), bool)
    for frame in np.unique(made.frame):
        of = made.frame == frame
        fits[of] = np.exp(min(raw[of].mean(), rectified[of].mean())) <= max(alike_px, ALIKE_PX)
    if not fits.any():
        return None, None
    gain = (rectified - raw)[fits]
    _, point, count = np.unique(made.point[fits], return_inverse=True, return_counts=True)
    off = np.bincount(point, gain - gain.mean())  # (points,), summed over frames
    error = np.sqrt(off @ off * len(count) / max(len(count) - 1, 1)) / len(gain)
    return float(np.exp(gain.mean())), float(np.exp(gain.mean() + SURE * error))


def _rms(errors: Mapping[str, NDArray]) -> dict[str, float]:
    return {name: float(np.sqrt(np.mean(px**2))) for name, px in errors.items() if len(px)}


def _noise_px(matches: NDArray) -> float:
    """Standard deviation of matches from their fundamental matrix."""
    left, right = np.split(matches, 2, axis=1)
    away = sampson_distance(fit_fundamental_with_prior(left, right), left, right)
    return float(np.sqrt(away @ away / max(len(away) - FREE, 1)))


def _matches(views: FourViews, frames: NDArray) -> tuple[NDArray, NDArray]:
    """Different matches of left and right, (M, 4) px, of both bodies, and of which point each is, (M,)."""
    found, points = [], []
    for images, seen in views.bodies:
        both = seen[frames].all(-1)
        found.append(images[frames][both])
        points.append(np.nonzero(both)[1])
    matches, first = np.unique(np.concatenate(found), axis=0, return_index=True)
    some = _spaced(len(matches), MATCHES)
    return matches[some], np.concatenate(points)[first[some]]


def _spaced(count: int, most: int) -> NDArray:
    """At most so many indices below count, evenly spaced."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).astype(int))
