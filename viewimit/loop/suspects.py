"""Which points of tracked images are likely wrong: told by image points alone, without a body, a camera or a posture.

A point is misplaced where the two cameras of the head contradict each other about it: all matches of both bodies and of
all frames share one epipolar geometry, whatever the postures are. Two points are swapped where the demonstrator's
images explain the learner's once both are exchanged, and do not before. That needs both arms in about one posture:
elsewhere E is large whoever is exchanged, and nothing is told.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from ..estimation.residuals import conflict
from ..estimation.transfers import TRANSFERS
from ..estimation.transfers.rectified import fit
from ..estimation.views import VIEWS, FourViews, Pairs, exchange
from ..geometry.affine import MIN_POINTS
from ..geometry.handedness import Handedness, principal_axes
from ..geometry.rectification import Rectification, rectification_of
from ..geometry.robust_fit import FEWEST, FEWEST_OF_F, Fit, contradicting, geometry_of, rows_of, spread
from ..sensing.point_checks import rounding_std, why_degenerate
from .rectifying import pooled

POOLED, MATCHES = 200, 8000  # frames, evenly spaced, and matches of those, that tell the geometry
BODIES = ("l", "r"), ("L", "R")
METHOD = TRANSFERS["projective"]  # which has no bias: of points that are right, in one posture, E is that of the noise
ALWAYS = 0.5  # of what contradicts in a frame: what does as the rms of all frames, be they ever so many
FRAMES = 20  # in which exchanges are tried
FEWEST_POINTS = 8  # of fewer, many exchanges fit
MOST_POINTS = 32  # those with the largest residuals, of more
DECISIVE = 10.0  # times that E falls at least
EXPLAINED = 16.0  # times the square of the noise: E of points that are right; its median is 7, less than 20 in 95 %
TELLING = 2e-3  # of the mean square of the centred own images: E that many exchanges leave in other postures
AMBIGUOUS = 3.0  # times the least E, which other exchanges leave as well
TOGETHER = 4000  # fits at a time, for memory's sake


@dataclass(frozen=True)
class Suspect:
    """kind: misplaced, or exchanged for each other; points: one index, or two; views: one of these is wrong, or both;
    frames: in which, by index.

    score: of a misplaced point, its rms distance from the epipolar geometry of the others in these frames, in standard
    deviations of theirs; of swapped points, by how many times the median E of the frames falls if they are exchanged.
    E, E_exchanged: px², of the projective transfer that may not reflect, NaN of a misplaced point.
    """

    kind: str
    points: tuple[int, ...]
    views: tuple[str, ...]
    frames: tuple[int, ...]
    score: float
    E: float = np.nan
    E_exchanged: float = np.nan


@dataclass(frozen=True)
class Suspects:
    """found: the likeliest of each kind first; undecided: why nothing is told of a kind, a sentence each; noise_px: of
    an image coordinate, standard deviation, as the matches that are not misplaced tell it; None if they are too few."""

    found: tuple[Suspect, ...]
    undecided: tuple[str, ...]
    noise_px: float | None = field(default=None, compare=False)

    def left_out(self, views: FourViews) -> FourViews:
        """The views with misplaced points not seen, in the images of that body, and with exchanged ones put right if no
        other exchange explains as much."""
        visible = views.visible.copy()
        exchanged = [suspect.points for suspect in self.found if suspect.kind == "exchanged"]
        for suspect in self.found:
            if suspect.kind == "misplaced":
                first = VIEWS.index(suspect.views[0])
                visible[np.ix_(suspect.frames, suspect.points, range(first, first + 2))] = False
        seen = replace(views, visible=visible)
        return seen.with_exchanged(((exchanged[0][0], exchanged[0][1]),)) if len(exchanged) == 1 else seen


def suspects(views: FourViews, seed: int = 0, rounding_px: float | None = None) -> Suspects:
    """views: of T frames, (T, N, …); seed: of the draws; rounding_px: of a coordinate, standard deviation, of views
    that were undistorted after they were rounded. None: as the coordinates tell."""
    if rounding_px is None:
        rounding_px = rounding_of(views)
    geometry = _geometry(telling(views, seed), rounding_px, np.random.default_rng(seed))
    if geometry is None:
        few = f"misplaced points: they need {FEWEST_OF_F} matches of left and right, or {FEWEST} that lie in equal rows"
        return Suspects((), (few, "swapped points: they need to know the noise, which the same matches tell"))
    misplaced, visible = [], views.visible.copy()
    for body, (images, seen) in enumerate(views.bodies):
        found, wrong = _misplaced(images, np.asarray(seen.all(-1)), geometry, BODIES[body])
        misplaced += found
        visible[..., 2 * body : 2 * body + 2] &= ~wrong[..., None]
    swapped, why = _swapped(replace(views, visible=visible), geometry.deviation)
    by_score = sorted(misplaced, key=lambda one: -one.score)
    return Suspects((*by_score, *swapped), (why,) if why else (), geometry.deviation)


def telling(views: FourViews, seed: int = 0) -> NDArray:
    """(M, 4) px: matches of left and right, of both bodies, that tell the cameras' geometry. Of very many, those that
    are drawn: more tell hardly more, and take long."""
    matches = pooled(_frames(views, k) for k in _spaced(len(views.demo), POOLED))
    if len(matches) <= MATCHES:
        return matches
    return matches[np.sort(np.random.default_rng(seed).choice(len(matches), MATCHES, replace=False))]


def rounding_of(views: FourViews) -> float:
    """Standard deviation of a coordinate, px, that rounding to whole pixels, or to another grid, has left."""
    return rounding_std(np.concatenate([views.demo, views.own], -1), views.visible)


def _geometry(matches: NDArray, rounding_px: float, rng: np.random.Generator) -> Fit | None:
    """Of the matches, (M, 4) px, that do not contradict each other; None with too few of them."""
    left, right = matches[:, :2], matches[:, 2:]
    if len(matches) < FEWEST:
        return None
    if len(matches) < FEWEST_OF_F:
        return rows_of(left, right, rounding_px)
    wrong = contradicting(left, right, max(spread(left, right, rng), rounding_px), rng)
    return geometry_of(left[~wrong], right[~wrong], rounding_px) if (~wrong).sum() >= FEWEST else None


def _misplaced(images: NDArray, seen: NDArray, geometry: Fit, views: tuple[str, ...]) -> tuple[list[Suspect], NDArray]:
    """Of one body: its suspects, and (T, N) bool, where. images: (T, N, 4) px; seen: (T, N) bool."""
    away = np.zeros(seen.shape)
    away[seen] = geometry.distance(images[seen][:, :2], images[seen][:, 2:]) / geometry.deviation
    wrong = np.abs(away) > geometry.gross
    rest = seen & ~wrong
    looks = np.maximum(rest.sum(0), 1)
    rms = np.sqrt(np.square(away).sum(0, where=rest) / looks)
    wrong |= rest & (rms > geometry.gross * np.maximum(looks**-0.5, ALWAYS))
    found = []
    for point in np.flatnonzero(wrong.any(0)):
        frames = np.flatnonzero(wrong[:, point])
        score = float(np.sqrt(np.mean(away[frames, point] ** 2)))
        found.append(Suspect("misplaced", (int(point),), views, tuple(frames.tolist()), score))
    return found, wrong


def _swapped(views: FourViews, noise_px: float) -> tuple[list[Suspect], str]:
    """The exchanges that explain all, and why nothing is told, "" if it is."""
    frames, points = _common(views)
    count = int(points.sum())
    if count < FEWEST_POINTS:
        return [], f"swapped points: no frame has {FEWEST_POINTS} points or more that are right in all four views"
    some = _frames(views, frames).select(points)
    ask = _Exchanges.of(some, noise_px)
    E = float(ask.median_E([()])[0])
    explained = EXPLAINED * noise_px**2
    if E <= explained:
        return [], ""  # as they are
    if explained > TELLING * float(some.own.var(-2).sum(-1).mean()):
        return [], f"swapped points: noise of {noise_px:.2g} px hides them"
    pairs = ask.candidates()
    left_E = ask.median_E(pairs)
    least = left_E.min()
    if least > explained or E < DECISIVE * least:
        whoever = f"E of the projective transfer is {E:.3g} px², and {least:.3g} px² at least whoever is exchanged"
        return [], f"swapped points: {whoever}, where it must not reflect; arms in one posture would tell"
    names = np.flatnonzero(points)
    found = []
    for k in np.argsort(left_E):
        if left_E[k] <= min(explained, AMBIGUOUS * max(least, noise_px**2), E / DECISIVE):
            (i, j), score = pairs[k][0], float(E / max(left_E[k], noise_px**2))
            exchange, which = (int(names[i]), int(names[j])), tuple(frames.tolist())
            found.append(Suspect("exchanged", exchange, BODIES[0], which, score, E, float(left_E[k])))
    return found, ""


def _common(views: FourViews) -> tuple[NDArray, NDArray]:
    """Frames, by index, and (N,) bool, the points that are usable in all of these: those of most frames. Frames whose
    points lie in a plane are left out."""
    points = views.usable.mean(0) > 0.5
    frames = np.flatnonzero(views.usable[:, points].all(-1))
    if points.sum() < MIN_POINTS or not len(frames):
        return frames, np.zeros_like(points)
    frames = frames[_spaced(len(frames), FRAMES)]
    good = [not why for why in why_degenerate(_frames(views, frames).select(points))]
    return frames[good], points if any(good) else np.zeros_like(points)


@dataclass(frozen=True)
class _Exchanges:
    """E of the projective transfer with points exchanged; a transfer that reflects counts what the nearest one that
    does not would leave.

    views: of T frames, all points seen; handedness: of the demonstrator in each, None where it is too flat to tell.
    """

    views: FourViews
    rectification: Rectification | None
    handedness: list[Handedness | None]

    @classmethod
    def of(cls, views: FourViews, noise_px: float) -> "_Exchanges":
        """noise_px: of an image coordinate, standard deviation."""
        matches = pooled(_frames(views, k) for k in range(len(views.demo)))
        by = rectification_of(*np.split(matches, 2, axis=1))  # which no exchange changes
        demo = views.demo if by is None else by.apply(views.demo)
        axes = principal_axes(matches if by is None else by.apply(matches))
        return cls(views, by, [Handedness.of(one, axes, noise_px) for one in demo])

    def candidates(self) -> list[Pairs]:
        """All pairs of the points with the largest residuals."""
        off = np.square(fit(METHOD, self.views, self.rectification).residual(self.views)).sum(-1).mean(0)
        return [(pair,) for pair in combinations(np.sort(np.argsort(-off)[:MOST_POINTS]).tolist(), 2)]

    def median_E(self, exchanges: Sequence[Pairs]) -> NDArray:
        """The median over frames, px², with each of the exchanges: (exchanges,)."""
        several = max(TOGETHER // len(self.views.demo), 1)
        blocks = [exchanges[first : first + several] for first in range(0, len(exchanges), several)]
        return np.concatenate([np.median(self._E(block), -1) for block in blocks])

    def _E(self, exchanges: Sequence[Pairs]) -> NDArray:
        """(exchanges, T) px²; own points are exchanged, which comes to the same."""
        order = np.arange(self.views.own.shape[-2])
        own = np.stack([self.views.own[:, exchange(order, pairs)] for pairs in exchanges])
        demo, visible = (np.broadcast_to(of, own.shape) for of in (self.views.demo, self.views.visible))
        some = FourViews(demo, own, visible)
        E = np.asarray(fit(METHOD, some, self.rectification).conflict(some))
        for k, handedness in enumerate(self.handedness):
            images = own[:, k] if self.rectification is None else self.rectification.apply(own[:, k])
            missing = None if handedness is None else handedness.mirror_residual(images)
            if missing is not None:
                E[:, k] += conflict(missing)
        return E


def _spaced(count: int, most: int) -> NDArray:
    """At most so many indices below count, evenly spaced."""
    return np.unique(np.linspace(0, count - 1, most).astype(int))


def _frames(views: FourViews, which: NDArray | int) -> FourViews:
    return FourViews(views.demo[which], views.own[which], views.visible[which])
