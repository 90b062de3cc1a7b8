"""The method on tracked points: how well pictures of two bodies agree; no model of a robot or a camera."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from ..estimation.outliers import OutlierReport, find_outliers, select_matches
from ..estimation.rectification import fit_transfer
from ..estimation.transfers import TRANSFERS, TransferMethod, default_transfer
from ..estimation.transfers.registry import ILL_CONDITIONED, PROJECTIVE_MIN_POINTS
from ..estimation.transfers.transfer import FLAT, FLATNESS, conflict
from ..estimation.views import VIEW_NAMES, VIEWS, FourViews, extents, why_degenerate
from ..geometry.affine import MIN_POINTS, fit_affine_fundamental
from ..geometry.arrays import Floats
from ..geometry.handedness import Handedness, principal_axes
from ..geometry.rectification import Rectification
from .leave_one_out import LeaveOneOut, leave_one_out
from .timing import TimeShift, find_time_shift

PAIRS = tuple(pair for pair in combinations(VIEWS, 2) if pair != ("l", "r"))  # Eq. (4); no constraint is of (l, r)
TOO_FEW = f"no {MIN_POINTS} points are seen in all four views"
TOGETHER = 2000  # frames at a time, for memory's sake
MAX_GAPS = 3  # frames of equal distance for each that is there
MIN_SPREAD = 6.0  # of σ₁/σ₄: noise alone gives 5 at most in 95 % of frames, arms give 24 and more at 1 px


@dataclass(frozen=True)
class Frame:
    """What one frame shows. Where no transfer can be fitted, `refused` says why, and the other values are None."""

    number: int
    usable: tuple[str, ...]  # names of the n points that all four views show
    refused: str | None = None
    E: float | None = None  # px²
    condition: float | None = None  # of the transfer
    flatness: float | None = None  # of the demonstrator's points
    rms_px: float | None = None  # of the n points in [L], [R]
    fundamental: Mapping[tuple[str, str], Floats] | None = None  # (5,) f13 f23 f31 f32 f33 by PAIRS
    seen: Mapping[str, Floats] | None = None  # (n, 2) px by the view's full name
    recovered: Mapping[str, Floats] | None = None  # (n, 2) px in the own views
    weak: str | None = None  # what speaks against the result
    mirrored: bool | None = None  # whether the fit is a reflection; None if the points are too flat to tell


@dataclass(frozen=True)
class Evaluation:
    """What T frames of tracked points say.

    Parameters
    ----------
    transfer
        Name of the transfer that was used.
    rectification
        Applied to the images; None if they are left as they are.
    points
        (N,) names.
    frames
        T frames.
    left_out
        Leave-one-out errors of all transfers.
    outliers
        Points that are likely wrong.
    time_shift
        Shows that the cameras are not in time; None if they are, or the images do not tell.
    """

    transfer: str
    rectification: Rectification | None
    points: tuple[str, ...]
    frames: tuple[Frame, ...]
    left_out: LeaveOneOut
    outliers: OutlierReport
    time_shift: TimeShift | None

    def table(self) -> str:
        """Return a line for each frame: its number, usable points, E, rms, condition and flatness."""
        width = max(7, *(2 + len(str(frame.number)) for frame in self.frames))
        lines = [f"{'frame':>{width}}{'usable':>8}{'E px²':>12}{'rms px':>9}{'condition':>11}{'flatness':>10}"]
        for one in self.frames:
            figures = (one.E, ".4g", 12), (one.rms_px, ".3g", 9), (one.condition, ".3g", 11), (one.flatness, ".3g", 10)
            cells = "".join(f"{'–' if value is None else f'{value:{form}}':>{size}}" for value, form, size in figures)
            lines.append(f"{one.number:>{width}}{len(one.usable):>8}{cells}{'  mirrored' if one.mirrored else ''}")
        return "\n".join(lines)


def evaluate(
    views: FourViews,
    points: Sequence[str] | None = None,
    frames: Sequence[int] | None = None,
    transfer: str | None = None,
    rectify: bool = True,
    rounding_px: float | None = None,
) -> Evaluation:
    """Estimate, recover and compare, as the paper does, on tracked points.

    Parameters
    ----------
    views : FourViews
        T frames of N points, (T, N, …) px, without lens distortion.
    points : sequence of str, optional
        N names; numbers by default.
    frames : sequence of int, optional
        T numbers; from 0 by default.
    transfer : str, optional
        Name of a transfer; by default the one that suits the number of points.
    rectify : bool, optional
        Whether to rectify the images where that predicts points better that are left out of the fit.
    rounding_px : float, optional
        Standard deviation that rounding has left in a coordinate; by default as the coordinates show it.

    Returns
    -------
    Evaluation
        Frames in which too few points are seen, or that are degenerate, say why they were refused.
    """
    numbers = list(range(len(views.demo))) if frames is None else list(frames)
    names = tuple(map(str, range(views.demo.shape[-2])) if points is None else points)
    transfer = transfer or default_transfer(_usual_count(views))
    outliers = find_outliers(views, rounding_px=rounding_px)
    without = outliers.corrected(views)
    compared = leave_one_out(without, rectify)
    # outliers are told, not removed: E is of the points as given
    found = evaluate_frames(numbers, names, views, transfer, compared.rectification)
    if outliers.noise_px is not None:
        found = _with_handedness(found, select_matches(without), compared.rectification, outliers.noise_px)
    shift = _time_shift(numbers, views)
    return Evaluation(transfer, compared.rectification, names, tuple(found), compared, outliers, shift)


def evaluate_frames(
    numbers: Sequence[int],
    points: Sequence[str],
    views: FourViews,
    transfer: str,
    rectification: Rectification | None = None,
) -> list[Frame]:
    """Evaluate T frames, (T, N, …), with one transfer. A frame that it cannot be fitted to says why in `refused`."""
    frames: dict[int, Frame] = {}
    patterns, of = np.unique(views.usable, axis=0, return_inverse=True)
    for k, usable in enumerate(patterns):
        names = tuple(name for name, seen in zip(points, usable) if seen)
        alike = np.flatnonzero(of.ravel() == k)
        for at in np.array_split(alike, -(-len(alike) // TOGETHER)):
            some = _frames(views, at).select(usable)
            why = why_degenerate(some) if len(names) >= MIN_POINTS else [TOO_FEW] * len(at)
            good = np.array([not words for words in why])
            results = iter(_evaluated(_frames(some, good), transfer, rectification) if good.any() else ())
            for index, words in zip(at.tolist(), why):
                found = {"refused": words} if words else next(results)
                frames[index] = Frame(numbers[index], names, **found)
    return [frames[index] for index in range(len(numbers))]


def _evaluated(seen: FourViews, transfer: str, rectification: Rectification | None) -> Iterator[dict]:
    """Of frames whose points are all seen, and no degenerate ones."""
    method = TRANSFERS[transfer]
    fitted = fit_transfer(method, seen, rectification)
    recovered = fitted.recover(seen.demo_left, seen.demo_right)
    image = dict(zip(VIEWS, (seen.demo_left, seen.demo_right, seen.own_left, seen.own_right)))
    fits = [fit_affine_fundamental(image[p], image[q]) for p, q in PAIRS]
    F = np.stack([np.concatenate([f, f33[..., None]], -1) for f, f33 in fits], -2)
    demo, own = extents(seen.demo), extents(seen.own)
    flat, condition = demo[:, 0] / demo[:, 2], np.broadcast_to(fitted.condition, len(F))
    E, rms = fitted.conflict(seen), np.sqrt(conflict(seen.own - recovered))
    for k in range(len(F)):
        yield {
            "E": float(E[k]),
            "condition": float(condition[k]),
            "flatness": float(flat[k]),
            "rms_px": float(rms[k]),
            "fundamental": dict(zip(PAIRS, F[k])),
            "seen": {VIEW_NAMES[view]: points[k] for view, points in image.items()},
            "recovered": {VIEW_NAMES["L"]: recovered[k, :, :2], VIEW_NAMES["R"]: recovered[k, :, 2:]},
            "weak": _weak(method, seen.own.shape[-2], float(condition[k]), demo[k], own[k]),
        }


def _with_handedness(
    frames: Sequence[Frame], matches: NDArray, rectification: Rectification | None, noise_px: float
) -> list[Frame]:
    """Find out which fits are reflections. matches: (M, 4) px of both bodies; noise_px: of a coordinate."""
    rectified = (lambda images: images) if rectification is None else rectification.apply
    axes = principal_axes(rectified(matches))

    def is_mirrored(frame: Frame) -> bool | None:
        if frame.seen is None:
            return None
        views = FourViews.from_images(*(frame.seen[name] for name in VIEW_NAMES.values()))
        handedness = Handedness.from_images(rectified(views.demo), axes, noise_px)
        return None if handedness is None else handedness.is_mirrored(rectified(views.own))

    return [replace(frame, mirrored=is_mirrored(frame)) for frame in frames]


def _weak(method: TransferMethod, count: int, condition: float, demo: NDArray, own: NDArray) -> str | None:
    """What speaks against the result of a frame of `count` points. demo, own: their extents, (4,) px each."""
    if method is TRANSFERS["projective"] and count < PROJECTIVE_MIN_POINTS:
        return f"{count} points: fewer than {PROJECTIVE_MIN_POINTS} fit the projective transfer wherever the arms are"
    if condition >= ILL_CONDITIONED:
        return f"{method.condition_name} {condition:.3g}: {method.degenerate_message}"
    for of, sigma in (("", demo), (" of [L R]", own)):
        if sigma[0] >= ILL_CONDITIONED * sigma[2]:
            return f"{FLATNESS}{of} {sigma[0] / sigma[2]:.3g}: {FLAT}"
        if sigma[0] < MIN_SPREAD * sigma[3]:
            return f"σ₁/σ₄{of} {sigma[0] / sigma[3]:.3g}: the spread is little more than noise, E may mislead"
    return None


def _usual_count(views: FourViews) -> int:
    """How many points are usable in half of the frames that have enough of them for a transfer; 0 without any."""
    counts = views.usable.sum(-1)
    enough = counts[counts >= MIN_POINTS]
    return int(np.median(enough)) if len(enough) else 0


def _time_shift(numbers: Sequence[int], views: FourViews) -> TimeShift | None:
    """Of both bodies together, as one head sees both, or else of one that moves. numbers: or time stamps."""
    steps = np.array([float(after - before) for before, after in zip(numbers, numbers[1:])])
    if not (len(steps) and (steps > 0).all()):
        return None
    at = np.append(0, np.cumsum(np.round(steps / np.median(steps)).clip(1))).astype(int)  # in frames of equal distance
    if at[-1] > MAX_GAPS * len(at):
        return None
    seen = [np.full((at[-1] + 1, *each.shape[1:]), np.nan) for each in (views.demo, views.own)]
    for each, given in zip(seen, (views.demo, views.own)):
        each[at] = given  # NaN, where a point is not seen
    shift = next(filter(None, map(find_time_shift, (np.concatenate(seen, 1), *seen))), None)
    if shift is None:
        return None
    return replace(shift, parts=tuple((int(np.searchsorted(at, first)), late) for first, late in shift.parts))


def _frames(views: FourViews, which: NDArray | int) -> FourViews:
    return FourViews(views.demo[which], views.own[which], views.visible[which])
