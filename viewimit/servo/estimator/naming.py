"""Name the demonstrator's points: find which of them is which point of the own body, without any correspondence.

Theory
------
1. The posture of the demonstrator is unknown, but the learned kinematics predict the own images in any posture, and how
   the head sees affine coordinates of space (`ProjectiveKinematics.affine_coordinates`). In the right posture the two
   bodies are one point set up to an affine map and the order of the points.
2. Let X (N, 3) be centred affine coordinates and P = X (XᵀX)⁻¹ Xᵀ their hat matrix. An affine map does not change P,
   and a permutation of the points permutes its rows and columns. So row i of P with its entries sorted describes point
   i for any map and any order. The assignment problem of the distances of sorted rows names all points.
3. In other postures the rows do not agree. A grid of postures gives the best few namings, in which P is then compared
   entry by entry. Each is refined: fit the posture by least squares on E, assign points to the images recovered there,
   and repeat. A right naming leaves the E of the noise, a wrong one hundreds of times more.
4. A point without a partner changes every row. So points to leave out are tried, as few as possible. Without i,
   H = P + 11ᵀ/N becomes H + H_:i H_i: / (1 - H_ii), which is cheap.

A grid of 10° over two joints has 190 postures. With N points it costs some 190 N³ operations and a few assignments of
N³; it needs no motion. Exchanging two names adds D_ij + D_ji - D_ii - D_jj to the squared residuals, with D_ij the
squared distance of point i and the recovered j. By Bayes' rule with Gaussian noise this gives a name's probability.

Two namings that fit equally well, in different postures, are two answers. Points cannot decide between them, as for a
body that is symmetric under half a turn.

References
----------
Kuhn, "The Hungarian method for the assignment problem", Naval Research Logistics Quarterly 2, 1955.
Hoaglin and Welsch, "The hat matrix in regression and ANOVA", The American Statistician 32, 1978.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations, product
from math import comb, prod

import numpy as np
from numpy.typing import NDArray

from ...estimation.rectification import fit_transfer
from ...estimation.residuals import PredictedResiduals
from ...estimation.transfers import TRANSFERS
from ...estimation.transfers.transfer import conflict
from ...estimation.views import FourViews, Pairs
from ...geometry.assignment import assign, cheapest_pairs
from ...geometry.kinematics.adjustment import BundleAdjustment, KinematicsCovariance
from ...geometry.kinematics.chains import with_likely_chains
from ...geometry.kinematics.clusters import Observations
from ...geometry.kinematics.model import ProjectiveKinematics
from ..least_squares import minimise
from ..naming import Array, Names, Naming
from .swaps import transpositions

N_LEVERAGES, ALIGNMENTS = 3, 4  # points that are paired first, one at a time; assignments after that
REACH_ROUNDS = 4  # of refinement, in which the reach of the posture grows
AT_REACH = 0.99  # share of a round's reach, from which the posture may be beyond it
GRID_STEP, MAX_POSTURES = np.radians(10.0), 5000  # between postures to search at; random ones if a grid has more
STARTS, NEIGHBOURHOOD = 8, np.radians(45.0)  # most similar namings, one in each cell of this size, are refined
ROUNDS, REACH = 10, np.radians(20.0)  # of refining the posture and the names in turn; the posture in a round
MAX_TRIALS, LEFT_OUT = 600, 2  # at most: choices of points to leave out; points of a body without a partner
LEAST_NAMED = 7  # points: of fewer, E says too little
SAMPLES = 16  # of the noise, for the E that it explains
LEAST_STD_PX = 0.07  # px: rms error of learned kinematics far from all visits, without noise
ACCEPT, MAX_NOISE = 4.0, 2.0  # times the E of noise, that a naming may leave; px² of it, that accepts wrong names
APART = np.radians(3.0)  # a naming that fits in a posture farther away is another answer
LINEAR_PX = 1e-3  # image units: noise small enough that predictions are linear in it
METHOD = TRANSFERS["projective"]  # exact for pinhole cameras, so E of right names is that of the noise


@dataclass(frozen=True)
class KnownBody:
    """Kinematics of the own body, and the visits to which they were fitted."""

    kinematics: ProjectiveKinematics
    observations: Observations
    noise_px: float  # standard deviation of an image coordinate

    def errors(self, theta: Array, count: int, seed: Sequence[int]) -> Array:
        """Draw errors of the images predicted at (m,) rad, as the noise of all visits makes: (count, N, 4) px."""
        covariance = KinematicsCovariance.estimate(self.kinematics, self.observations)
        parameters, points = covariance.sample(np.random.default_rng(seed), count, LINEAR_PX)
        drawn = replace(
            self.kinematics, parameters=self.kinematics.parameters + parameters, points=self.kinematics.points + points
        )
        return (drawn.predict(theta[None]) - self.kinematics.predict(theta[None]))[:, 0] * (self.noise_px / LINEAR_PX)


def find_naming(
    demo: Array, model: KnownBody, lower: Array, upper: Array, seed: int = 0, left_out: int = LEFT_OUT
) -> Naming | None:
    """Name the points of a demonstrator.

    Parameters
    ----------
    demo : (M, 4) array
        Its points in [l, r], in any order [px]; NaN where a point is not seen in both.
    model : KnownBody
        Predicts the own images; units as of `demo`.
    lower, upper : (m,) arrays
        Joint limits [rad].
    seed : int, optional
        Of random draws.
    left_out : int, optional
        Points without a partner, at most, of either body.

    Returns
    -------
    Naming or None
        The best one; None if there are too few points, or too many without a partner.
    """
    search = _Search.begin(demo, model, lower, upper, seed)
    best: Naming | None = None
    for n_out in range(left_out + 1):
        found = search.best(n_out)
        if found is not None and found.accepted:
            return search.with_rival(search.with_points(found))
        if found is not None and (best is None or found.E / found.E_noise < best.E / best.E_noise):
            best = found
    return best


def mixed_up(demo: Array, model: KnownBody, lower: Array, upper: Array, seed: int = 0) -> Pairs:
    """Return swaps, one after the other, that put mixed-up points right; none if no naming explains the images.

    Every point must have a partner. Parameters as of `find_naming`.
    """
    if not np.isfinite(demo).all():
        return ()
    found = find_naming(demo, model, lower, upper, seed, 0)
    if found is None or not found.accepted or found.is_ambiguous or (found.names < 0).any():
        return ()
    return transpositions(found.names)


def nearest_posture(demo: Array, model: KnownBody, lower: Array, upper: Array, seed: int = 0) -> Array:
    """Return the posture, (m,) rad, in which the own images have the least E.

    Parameters as of `find_naming`, but with the demonstrator's points in the order of the own.
    """
    search = _Search.begin(demo, model, lower, upper, seed)
    order = np.flatnonzero(np.isin(search.placed, search.shown))
    names = np.full(len(search.placed), -1)
    names[order] = np.searchsorted(search.shown, search.placed[order])
    residuals = search.residuals(names)
    E = conflict(residuals(search.predict(search.postures)))
    starts = search.postures[np.argsort(E)[:STARTS]]
    return minimise(lambda theta: residuals(search.predict(theta)), starts, lower, upper).theta


@dataclass(frozen=True, eq=False)
class Trial:
    """Points of both bodies that may have partners, n of each, and their hat matrices."""

    demo: Names  # (n,)
    own: Names  # (n,)
    demo_hat: Array  # (n, n)
    own_hats: Array  # (G, n, n)

    def row_distances(self) -> Array:
        """(G, n, n): squared distances of the sorted rows of all own points and all of the demonstrator's."""
        return _squared_distances(np.sort(self.own_hats), np.sort(self.demo_hat))

    def aligned(self, g: int) -> Iterator[tuple[float, Names]]:
        """Yield pairs, (n,), for which the hat matrices agree entry by entry, and the squared distance that is left.

        Sorted rows of a point and of its mirror image are equal. So one point of great leverage is paired with either
        of the two likeliest first. The entries of its column then decide about the other points.
        """
        own, demo = self.own_hats[g], self.demo_hat
        rows = _squared_distances(np.sort(own)[None], np.sort(demo))[0]
        for first in np.argsort(-np.diag(own))[:N_LEVERAGES]:
            for partner in np.argsort(rows[first])[:2]:
                cost = rows + len(own) * (own[:, first, None] - demo[:, partner]) ** 2
                for _ in range(ALIGNMENTS):
                    pairs = assign(cost)
                    cost = _squared_distances(own[None], demo[:, pairs])[0]
                yield float(((own - demo[np.ix_(pairs, pairs)]) ** 2).sum()), pairs


@dataclass(frozen=True)
class _Search:
    """The data of one search. Points are counted among those that are shown, M, and placed by the kinematics, N."""

    demo: Array  # (M, 4) px
    shown: Names  # (M,): their rows in the whole image
    placed: Names  # (N,): rows of the own points
    reliable: NDArray[np.bool_]  # (N,): of which the kinematics know which joints move them; only these make E
    model: KnownBody
    kinematics: ProjectiveKinematics  # with all points placed
    lower: Array  # (m,) rad
    upper: Array  # (m,) rad
    seed: int

    @classmethod
    def begin(cls, demo: Array, model: KnownBody, lower: Array, upper: Array, seed: int) -> "_Search":
        shown, kinematics = np.flatnonzero(np.isfinite(demo).all(-1)), model.kinematics
        if kinematics.unknown.any():
            doubtful = kinematics.unknown & model.observations.visible_in_both.any(0)
            problem = BundleAdjustment.of(kinematics, model.observations, 0.0)
            kinematics = with_likely_chains(kinematics, problem, doubtful)
        placed = np.flatnonzero(~kinematics.unknown)
        points = demo[shown], shown, placed, ~model.kinematics.unknown[placed]
        return cls(*points, model, kinematics, lower, upper, seed)

    @cached_property
    def postures(self) -> Array:
        """Postures that namings are searched at, (G, m) rad."""
        return search_postures(self.lower, self.upper, self.seed)

    @cached_property
    def demo_hat(self) -> Array:
        """(M, M)."""
        return hat_matrix(self.kinematics.affine_coordinates(self.demo))

    @cached_property
    def own_hats(self) -> Array:
        """(G, N, N)."""
        return hat_matrix(self.kinematics.affine_coordinates(self.predict(self.postures)))

    def best(self, left_out: int) -> Naming | None:
        """Return the naming with the least E, with as many points left out besides those by which the bodies differ."""
        best: Naming | None = None
        for _, g, names in self.starts(self.trials(left_out)):
            found = self.refine(names, self.postures[g])
            if found is not None and (best is None or found.E < best.E):
                best = found
                if best.accepted and best.E < best.E_noise:
                    break
        return best

    def starts(self, trials: Iterable[Trial]) -> list[tuple[float, int, Names]]:
        """Return the most similar namings of all trials: distance of the hat matrices, index of the posture, names."""
        most, kept = STARTS, list[tuple[float, Trial, int, Names]]()
        for trial in trials:
            cost = trial.row_distances()
            bound = np.maximum(cost.min(1).sum(-1), cost.min(2).sum(-1))  # of the assignment's cost
            for g in np.argsort(bound).tolist():
                if len(kept) == most and bound[g] >= kept[-1][0]:
                    break
                pairs = assign(cost[g])
                total = float(cost[g][range(len(pairs)), pairs].sum())
                kept = sorted([*kept, (total, trial, g, pairs)], key=lambda one: one[0])[:most]
        found: dict[tuple[bytes, ...], tuple[float, int, Names]] = {}  # by names and neighbourhood
        for _, trial, g, _ in kept:
            for total, pairs in trial.aligned(g):
                names = np.full(len(self.placed), -1)
                names[trial.own] = trial.demo[pairs]
                key = names.tobytes(), np.round(self.postures[g] / NEIGHBOURHOOD).tobytes()
                if key not in found or total < found[key][0]:
                    found[key] = total, g, names
        return sorted(found.values(), key=lambda one: one[0])[: 2 * most]

    def trials(self, left_out: int) -> Iterator[Trial]:
        """Yield each choice of points to leave out, besides those by which the numbers differ."""
        M, N = len(self.shown), len(self.placed)
        demo_out, own_out = max(M - N, 0) + left_out, max(N - M, 0) + left_out
        if min(M - demo_out, N - own_out) < LEAST_NAMED:
            return
        if comb(M, demo_out) * comb(N, own_out) > MAX_TRIALS:
            return
        demos = list(_subsets(self.demo_hat, demo_out))
        for own, own_hats in _subsets(self.own_hats, own_out):
            for demo, demo_hat in demos:
                yield Trial(demo, own, demo_hat, own_hats)

    def refine(self, names: Names, start: Array) -> Naming | None:
        """Fit the posture and the names in turn, with as many names. names: (N,), into the shown points.

        The posture moves a little at first, and farther from round to round: some wrong names would draw it far away.
        """
        count, theta, E, reach = int((names >= 0).sum()), start, np.inf, REACH
        if self.views(names).visible.all(-1).sum() < LEAST_NAMED:
            return None
        names = cheapest_pairs(self.distances(names, theta), count)
        for k in range(1, ROUNDS + 1):
            bound = reach * min(k / REACH_ROUNDS, 1)
            before, (theta, E) = theta, self.posture(names, theta, bound)
            if not np.isfinite(E):
                return None
            again = cheapest_pairs(self.distances(names, theta), count)
            if (again == names).all() and np.abs(theta - before).max() < AT_REACH * bound:
                break
            names = again
        else:
            theta, E = self.posture(names, theta, reach)
        return self.naming(names, theta, E)

    def posture(self, names: Names, start: Array, reach: float) -> tuple[Array, float]:
        """Return the posture with the least E for these names, near the start, (m,) rad, and that E."""
        residuals = self.residuals(names)
        low, high = np.maximum(self.lower, start - reach), np.minimum(self.upper, start + reach)
        at = minimise(lambda theta: residuals(self.predict(theta)), start[None], low, high)
        return at.theta, at.E

    def residuals(self, names: Names) -> PredictedResiduals:
        """Return the residuals of predicted own points under these names."""
        rectification = self.kinematics.rectification
        return PredictedResiduals(self.views(names), METHOD, rectification, noise_px=self.model.noise_px)

    def predict(self, theta: Array) -> Array:
        """Predict the own points, (..., N, 4) px."""
        return self.kinematics.predict(theta)[..., self.placed, :]

    def views(self, names: Names, own: Array | None = None) -> FourViews:
        """Return the views of the reliable points under these names."""
        named = (names >= 0) & self.reliable
        demo = np.where(named[:, None], self.demo[names], np.nan)
        visible = np.repeat(named[:, None], 4, 1)
        return FourViews(demo, np.zeros_like(demo) if own is None else own, visible)

    def distances(self, names: Names, theta: Array) -> Array:
        """(N, M) px²: squared distances of own points and the demonstrator's, recovered with these names."""
        own, transfer = self.predict(theta), self._transfer(names, theta)
        recovered = transfer.recover(self.demo[:, :2], self.demo[:, 2:])
        return ((own[:, None] - recovered) ** 2).sum(-1)

    def _transfer(self, names: Names, theta: Array):
        views = self.views(names, self.predict(theta)).used
        return fit_transfer(METHOD, views, self.kinematics.rectification)

    def naming(self, names: Names, theta: Array, E: float) -> Naming:
        """Describe a naming; only an accepted one has probabilities."""
        E_noise = self.noise(names, theta)
        accepted = E < ACCEPT * E_noise and E_noise < MAX_NOISE
        n_own = len(self.kinematics.points)
        whole, probability = np.full(n_own, -1), np.full(n_own, np.nan)
        whole[self.placed] = np.where(names < 0, -1, self.shown[names])
        if accepted:
            probability[self.placed] = self.probability(names, theta, max(E, E_noise))
        unnamed = np.setdiff1d(self.shown, whole)
        return Naming(
            whole,
            unnamed,
            probability,
            theta,
            E,
            E_noise,
            accepted,
        )

    def noise(self, names: Names, theta: Array) -> float:
        """Estimate the E that the noise of both bodies' images explains, px², by drawing it."""
        count, seen = SAMPLES, (names >= 0) & self.reliable
        least = 2 * LEAST_STD_PX**2
        if self.model.noise_px == 0:
            return least
        own_errors = self.model.errors(theta, count, [self.seed, 0])[:, self.placed[seen]]
        noise = np.random.default_rng([self.seed, 1]).standard_normal((count, int(seen.sum()), 4))
        views = self.views(names, self.predict(theta)).select(seen)
        demo, own = views.demo + self.model.noise_px * noise, views.own + own_errors
        fit = lambda demo, own: fit_transfer(
            METHOD, FourViews(demo, own, np.ones(1, bool)), self.kinematics.rectification
        ).residual(FourViews(demo, own, np.ones(1, bool)))
        change = np.array([fit(*one) for one in zip(demo, own)]) - fit(views.demo, views.own)
        return float(conflict(change).mean()) + least

    def probability(self, names: Names, theta: Array, E_noise: float) -> Array:
        """(N,): probability of each name, against its exchange with any other and a partner that has no name."""
        seen, D = np.flatnonzero(names >= 0), self.distances(names, theta)
        own, pairs = D[seen, names[seen]], D[seen][:, names[seen]]
        more = pairs + pairs.T - own[:, None] - own
        np.fill_diagonal(more, np.inf)
        spare = np.setdiff1d(np.arange(len(self.demo)), names)
        more = np.concatenate([more, D[seen][:, spare] - own[:, None]], 1)
        found = np.full(len(names), np.nan)
        # E is half of the squares of four coordinates
        found[seen] = 1 / (1 + np.exp(np.clip(-more / E_noise, -700, 700)).sum(1))
        return found

    def with_points(self, found: Naming) -> Naming:
        """Name points that were left out in vain: pairs that noise explains."""
        for _ in range(LEFT_OUT):
            names = self.inner(found.names)
            own, demo = np.flatnonzero(names < 0), np.setdiff1d(np.arange(len(self.demo)), names)
            if not len(own) or not len(demo):
                break
            D = self.distances(names, found.displacement)[np.ix_(own, demo)]
            i, j = np.unravel_index(D.argmin(), D.shape)
            names[own[i]] = demo[j]
            larger = self.naming(names, *self.posture(names, found.displacement, REACH))
            if not larger.accepted:
                break
            found = larger
        return found

    def inner(self, names: Names) -> Names:
        """Names of the placed points, into the shown ones."""
        names = names[self.placed]
        return np.where(names < 0, -1, np.searchsorted(self.shown, np.maximum(names, 0)))

    def with_rival(self, found: Naming) -> Naming:
        """Look for other names of the reliable points that explain the images in another posture: the best of them."""
        names = self.inner(found.names)
        own = np.flatnonzero((names >= 0) & self.reliable)
        own_hats = hat_matrix(self.kinematics.affine_coordinates(self.predict(self.postures)[:, own]))
        demo_hat = hat_matrix(self.kinematics.affine_coordinates(self.demo[names[own]]))
        least = np.inf
        for _, g, other in self.starts([Trial(names[own], own, demo_hat, own_hats)]):
            if (other[own] == names[own]).all():
                continue
            rival = self.refine(other, self.postures[g])
            if rival is not None and rival.E < ACCEPT * max(found.E, found.E_noise, rival.E_noise):
                answers = self.with_answers(found, rival)
                if answers.is_ambiguous and rival.E < least:
                    found, least = answers, rival.E
        return found

    def with_answers(self, found: Naming, rival: Naming) -> Naming:
        """Record another answer, if its names are others and its posture is distinct."""
        distance = np.abs(rival.displacement - found.displacement).max()
        same = (rival.names == found.names) | (rival.names < 0)
        if same.all() or distance < APART:
            return found
        return replace(found, rival=rival.names)


def _squared_distances(own_rows: Array, demo_rows: Array) -> Array:
    """(G, N, K) and (M, K) → (G, N, M)."""
    own, demo = np.einsum("gik,gik->gi", own_rows, own_rows), np.einsum("jk,jk->j", demo_rows, demo_rows)
    return own[:, :, None] + demo - 2 * own_rows @ demo_rows.T


def hat_matrix(points: Array) -> Array:
    """Projection onto the centred coordinates of points, (..., N, 3) → (..., N, N)."""
    U = np.linalg.svd(points - points.mean(-2, keepdims=True), full_matrices=False)[0]
    return U @ np.swapaxes(U, -1, -2)


def without_point(hat: Array, point: int) -> Array:
    """Hat matrices of all points but one, from those of all: (..., N, N) → (..., N - 1, N - 1)."""
    count = hat.shape[-1]
    H = hat + 1 / count
    column = H[..., :, point]
    H = H + column[..., :, None] * column[..., None, :] / np.maximum(1 - H[..., point, point], 1e-9)[..., None, None]
    kept = np.arange(count) != point
    return H[..., kept, :][..., kept] - 1 / (count - 1)


def _subsets(hat: Array, left_out: int) -> Iterator[tuple[Names, Array]]:
    """Yield for each choice of points to leave out: those kept, and their hat matrices."""
    count = hat.shape[-1]
    for out in combinations(range(count), left_out):
        smaller = hat
        for point in reversed(out):
            smaller = without_point(smaller, point)
        yield np.setdiff1d(np.arange(count), out), smaller


def _grid_counts(lower: Array, upper: Array) -> list[int]:
    """Postures of the grid for each joint: Python's integers, as the product of many exceeds those of numpy."""
    return [max(round(share), 1) + 1 for share in ((upper - lower) / GRID_STEP).tolist()]


def search_postures(lower: Array, upper: Array, seed: int) -> Array:
    """Postures to search at, (G, m) rad: a grid, or random ones."""
    counts = _grid_counts(lower, upper)
    if prod(counts) > MAX_POSTURES:
        rng = np.random.default_rng([seed, 0])
        return rng.uniform(lower, upper, (MAX_POSTURES, len(lower)))
    axes = (np.linspace(*limits) for limits in zip(lower, upper, counts))
    return np.array(list(product(*axes)))
