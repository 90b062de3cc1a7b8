"""Outliers among image points, found from image points alone: without a body, a camera or a posture.

Misplaced points. One rigid stereo head makes all pairs of images, so all matches of left and right, of both bodies and
of all looks, share one epipolar geometry. A match that contradicts it is an outlier. The loop rejects the outliers of
each look (`reject_outliers`). Tracked images are searched as a whole (`find_outliers`).

Swapped points. Two points are swapped if the demonstrator's images explain the learner's once both are permuted, and do
not before. That needs both arms in about one posture: elsewhere E is large for every permutation.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ..geometry.affine import MIN_POINTS
from ..geometry.handedness import Handedness, principal_axes
from ..geometry.rectification import Rectification, fit_rectification
from ..geometry.robust_fit import (
    MIN_MATCHES,
    MIN_MATCHES_F,
    GeometryFit,
    all_inliers,
    detect_outliers,
    fit_geometry,
    fit_row_geometry,
    inlier_std,
)
from .noise import views_rounding_std
from .rectification import fit_transfer
from .transfers.registry import TRANSFERS
from .transfers.transfer import conflict
from .views import VIEWS, FourViews, Pairs, permute, unique_matches, why_degenerate

PAST_LOOKS = 10  # whose matches are pooled with those of the present look
MAX_FRAMES, MAX_MATCHES = 200, 8000  # evenly spaced frames, and matches of those, from which the geometry is estimated
BODIES = ("l", "r"), ("L", "R")
METHOD = TRANSFERS["projective"]  # unbiased: with correct points in one posture, E is that of the noise
MIN_PERSISTENT = 0.5  # a point's rms over many frames is an outlier above this share of the threshold for one frame
SWAP_FRAMES = 20  # in which permutations are tried
SWAP_MIN_POINTS = 8  # of fewer, many permutations fit
SWAP_MAX_POINTS = 32  # of more, those with the largest residuals
MIN_FALL = 10.0  # factor by which E falls at least
EXPLAINED = 16.0  # E over the noise's variance, of correct points; the median is 7, less than 20 in 95 %
MIN_SIGNAL = 2e-3  # E that many permutations leave in other postures, over the mean square of the centred own images
AMBIGUOUS = 3.0  # other permutations that leave less than this multiple of the least E are listed as well
MAX_BATCH = 4000  # fits at a time, to bound memory


def reject_outliers(
    views: FourViews, past: Sequence[FourViews], rectification: Rectification | None, noise_px: float, seed: int
) -> FourViews:
    """Mark points invisible in both images of a body where left and right contradict the epipolar geometry.

    Parameters
    ----------
    views : FourViews
        The present look, one posture.
    past : sequence of FourViews
        Looks before it, the last one last.
    rectification : Rectification or None
        Of the last look.
    noise_px : float
        Standard deviation of an image coordinate [px].
    seed : int
        Seed of the random samples (least median of squares).

    Returns
    -------
    FourViews
        The same object if nothing is rejected.
    """
    now = views.matches
    matches = np.concatenate(now)
    if all_inliers(*_rectified_sides(matches, rectification), noise_px):
        return views
    sides = _rectified_sides(np.concatenate([matches, unique_matches(past[-PAST_LOOKS:])]), rectification)
    wrong = detect_outliers(*sides, noise_px, np.random.default_rng(seed))[: len(matches)]
    if not wrong.any():
        return views
    visible = views.visible.copy()
    for body, rejected in enumerate(np.split(wrong, [len(now[0])])):
        pair = visible[:, 2 * body : 2 * body + 2]
        pair[np.flatnonzero(pair.all(-1))[rejected]] = False
    return replace(views, visible=visible)


def _rectified_sides(
    matches: NDArray[np.float64], rectification: Rectification | None
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(M, 4) px → (M, 2) px of the left and the right image."""
    if rectification is not None:
        matches = rectification.apply(matches)
    return matches[:, :2], matches[:, 2:]


@dataclass(frozen=True)
class Outlier:
    """A misplaced point, or two swapped points, in some frames."""

    kind: Literal["misplaced", "swapped"]
    points: tuple[int, ...]  # one index, or two
    views: tuple[str, ...]  # "l", "r" or "L", "R": one of these is wrong, or both
    frames: tuple[int, ...]  # indices
    # misplaced: rms distance from the epipolar geometry in these frames, in standard deviations of the other matches;
    # swapped: factor by which the median E of the frames falls if the points are permuted
    score: float
    E: float = np.nan  # px², of the projective transfer that may not reflect; NaN for a misplaced point
    E_swapped: float = np.nan  # px², with the points permuted


@dataclass(frozen=True)
class OutlierReport:
    """Outliers of tracked images."""

    found: tuple[Outlier, ...]  # the likeliest of each kind first
    undecided: tuple[str, ...]  # one sentence for each kind that could not be searched: why not
    noise_px: float | None = field(default=None, compare=False)  # std of a coordinate, by inliers; None for too few

    def corrected(self, views: FourViews) -> FourViews:
        """Mark misplaced points invisible, and undo a swap that is the only one to explain the images."""
        visible = views.visible.copy()
        swaps = [outlier.points for outlier in self.found if outlier.kind == "swapped"]
        for outlier in self.found:
            if outlier.kind == "misplaced":
                first = VIEWS.index(outlier.views[0])
                visible[np.ix_(outlier.frames, outlier.points, range(first, first + 2))] = False
        corrected = replace(views, visible=visible)
        return corrected.permuted(((swaps[0][0], swaps[0][1]),)) if len(swaps) == 1 else corrected


def find_outliers(views: FourViews, seed: int = 0, rounding_px: float | None = None) -> OutlierReport:
    """Find misplaced and swapped points in tracked images.

    Parameters
    ----------
    views : FourViews
        T frames, (T, N, 4) px.
    seed : int
        Seed of the random samples.
    rounding_px : float, optional
        Standard deviation of a coordinate by rounding [px], for views that were undistorted after they were rounded. By
        default it is found from the coordinates.

    Returns
    -------
    OutlierReport
    """
    if rounding_px is None:
        rounding_px = views_rounding_std(views)
    geometry = _geometry(select_matches(views, seed), rounding_px, np.random.default_rng(seed))
    if geometry is None:
        needed = f"{MIN_MATCHES_F} matches of left and right, or {MIN_MATCHES} that lie in equal rows"
        few = f"misplaced points: they need {needed}"
        return OutlierReport((), (few, "swapped points: they need the noise, which is estimated from the same matches"))
    misplaced, visible = [], views.visible.copy()
    for body, (images, seen) in enumerate(views.bodies):
        found, wrong = _misplaced(images, np.asarray(seen.all(-1)), geometry, BODIES[body])
        misplaced += found
        visible[..., 2 * body : 2 * body + 2] &= ~wrong[..., None]
    swapped, reason = _swapped(replace(views, visible=visible), geometry.std_px)
    by_score = sorted(misplaced, key=lambda one: -one.score)
    return OutlierReport((*by_score, *swapped), (reason,) if reason else (), geometry.std_px)


def select_matches(views: FourViews, seed: int = 0) -> NDArray[np.float64]:
    """Select matches of left and right, of both bodies, that determine the head's epipolar geometry: (M, 4) px.

    Of very many matches a random sample is taken: more add little and take long. views: T frames, (T, N, 4) px.
    """
    matches = unique_matches(_frames(views, k) for k in _spaced(len(views.demo), MAX_FRAMES))
    if len(matches) <= MAX_MATCHES:
        return matches
    return matches[np.sort(np.random.default_rng(seed).choice(len(matches), MAX_MATCHES, replace=False))]


def _geometry(matches: NDArray[np.float64], rounding_px: float, rng: np.random.Generator) -> GeometryFit | None:
    """Fit the geometry of the inliers among matches (M, 4) px; None with too few of them."""
    left, right = matches[:, :2], matches[:, 2:]
    if len(matches) < MIN_MATCHES:
        return None
    if len(matches) < MIN_MATCHES_F:
        return fit_row_geometry(left, right, rounding_px)
    wrong = detect_outliers(left, right, max(inlier_std(left, right, rng), rounding_px), rng)
    return fit_geometry(left[~wrong], right[~wrong], rounding_px) if (~wrong).sum() >= MIN_MATCHES else None


def _misplaced(
    images: NDArray[np.float64], seen: NDArray[np.bool_], geometry: GeometryFit, views: tuple[str, ...]
) -> tuple[list[Outlier], NDArray[np.bool_]]:
    """Outliers of one body, and in which frames they are: (T, N) bool. images: (T, N, 4) px; seen: (T, N)."""
    distance = np.zeros(seen.shape)
    distance[seen] = geometry.distance(images[seen][:, :2], images[seen][:, 2:]) / geometry.std_px
    wrong = np.abs(distance) > geometry.threshold
    rest = seen & ~wrong
    n_frames = np.maximum(rest.sum(0), 1)
    rms = np.sqrt(np.square(distance).sum(0, where=rest) / n_frames)
    wrong |= rest & (rms > geometry.threshold * np.maximum(n_frames**-0.5, MIN_PERSISTENT))
    found = []
    for point in np.flatnonzero(wrong.any(0)):
        frames = np.flatnonzero(wrong[:, point])
        score = float(np.sqrt(np.mean(distance[frames, point] ** 2)))
        found.append(Outlier("misplaced", (int(point),), views, tuple(frames.tolist()), score))
    return found, wrong


def _swapped(views: FourViews, noise_px: float) -> tuple[list[Outlier], str]:
    """Swaps that explain the images, and why they could not be searched ("" if they could)."""
    frames, points = _common(views)
    count = int(points.sum())
    if count < SWAP_MIN_POINTS:
        return [], f"swapped points: no frame has {SWAP_MIN_POINTS} points or more that are right in all four views"
    some = _frames(views, frames).select(points)
    trial = _Permutations.of(some, noise_px)
    E = float(trial.median_E([()])[0])
    explained = EXPLAINED * noise_px**2
    if E <= explained:
        return [], ""  # as they are
    if explained > MIN_SIGNAL * float(some.own.var(-2).sum(-1).mean()):
        return [], f"swapped points: noise of {noise_px:.2g} px hides them"
    pairs = trial.candidates()
    E_swapped = trial.median_E(pairs)
    least = E_swapped.min()
    if least > explained or E < MIN_FALL * least:
        found_E = f"E of the projective transfer is {E:.3g} px², and at least {least:.3g} px² with any pair swapped"
        return [], f"swapped points: {found_E}, where it must not reflect; they show only with arms in one posture"
    names = np.flatnonzero(points)
    found = []
    for k in np.argsort(E_swapped):
        if E_swapped[k] <= min(explained, AMBIGUOUS * max(least, noise_px**2), E / MIN_FALL):
            (i, j), score = pairs[k][0], float(E / max(E_swapped[k], noise_px**2))
            pair, which = (int(names[i]), int(names[j])), tuple(frames.tolist())
            found.append(Outlier("swapped", pair, BODIES[0], which, score, E, float(E_swapped[k])))
    return found, ""


def _common(views: FourViews) -> tuple[NDArray[np.int_], NDArray[np.bool_]]:
    """Indices of frames, and the points (N,) bool that are usable in all of these: those of most frames. Frames whose
    points lie in a plane are left out."""
    points = views.usable.mean(0) > 0.5
    frames = np.flatnonzero(views.usable[:, points].all(-1))
    if points.sum() < MIN_POINTS or not len(frames):
        return frames, np.zeros_like(points)
    frames = frames[_spaced(len(frames), SWAP_FRAMES)]
    good = [not reason for reason in why_degenerate(_frames(views, frames).select(points))]
    return frames[good], points if any(good) else np.zeros_like(points)


@dataclass(frozen=True)
class _Permutations:
    """E of the projective transfer with points permuted. Where a transfer reflects the body, E counts what the nearest
    one that does not would leave."""

    views: FourViews  # of T frames, all points visible
    rectification: Rectification | None
    handedness: list[Handedness | None]  # of the demonstrator in each frame, None where it is too flat

    @classmethod
    def of(cls, views: FourViews, noise_px: float) -> "_Permutations":
        """noise_px: standard deviation of an image coordinate."""
        matches = unique_matches(_frames(views, k) for k in range(len(views.demo)))
        by = fit_rectification(*np.split(matches, 2, axis=1))  # which no permutation changes
        demo = views.demo if by is None else by.apply(views.demo)
        axes = principal_axes(matches if by is None else by.apply(matches))
        return cls(views, by, [Handedness.from_images(one, axes, noise_px) for one in demo])

    def candidates(self) -> list[Pairs]:
        """All pairs of the points with the largest residuals."""
        e = fit_transfer(METHOD, self.views, self.rectification).residual(self.views)
        size = np.square(e).sum(-1).mean(0)
        return [(pair,) for pair in combinations(np.sort(np.argsort(-size)[:SWAP_MAX_POINTS]).tolist(), 2)]

    def median_E(self, permutations: Sequence[Pairs]) -> NDArray[np.float64]:
        """The median over frames [px²] with each of the permutations: (P,)."""
        several = max(MAX_BATCH // len(self.views.demo), 1)
        blocks = [permutations[first : first + several] for first in range(0, len(permutations), several)]
        return np.concatenate([np.median(self._E(block), -1) for block in blocks])

    def _E(self, permutations: Sequence[Pairs]) -> NDArray[np.float64]:
        """(P, T) px²; own points are permuted, which is equivalent."""
        order = np.arange(self.views.own.shape[-2])
        own = np.stack([self.views.own[:, permute(order, pairs)] for pairs in permutations])
        demo, visible = np.broadcast_to(self.views.demo, own.shape), np.broadcast_to(self.views.visible, own.shape)
        some = FourViews(demo, own, visible)
        E = np.asarray(fit_transfer(METHOD, some, self.rectification).conflict(some))
        for k, handedness in enumerate(self.handedness):
            images = own[:, k] if self.rectification is None else self.rectification.apply(own[:, k])
            missing = None if handedness is None else handedness.mirror_residual(images)
            if missing is not None:
                E[:, k] += conflict(missing)
        return E


def _spaced(count: int, most: int) -> NDArray[np.int_]:
    """At most `most` indices below count, evenly spaced."""
    return np.unique(np.linspace(0, count - 1, most).astype(int))


def _frames(views: FourViews, which: NDArray[np.int_] | int) -> FourViews:
    return FourViews(views.demo[which], views.own[which], views.visible[which])
