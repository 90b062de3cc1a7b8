"""Matches that contradict the epipolar geometry of the others: found by the least median of squares (Rousseeuw 1984).

Sets of as few matches as tell a geometry are drawn, and that one is kept from which half of all matches are nearest; so
up to half of them may be wrong. Geometries are affine, which parallel optical axes have, or those of a fundamental
matrix, where that contradicts fewer. Where neither fits half of them as well as noise allows, nothing can be told.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .affine import fit_affine_fundamental, image_unit
from .fundamental import fit_fundamental, homogeneous, sampson_distance

FEWEST, FEWEST_OF_F = 12, 24  # matches for an affine geometry, for a fundamental matrix
DRAWS, DRAWS_OF_F = 40, 120  # with a fifth of the matches wrong, less than one in a billion has no good draw
GROSS, LEAST_PX = 6.0, 0.2  # standard deviations, and px, that contradict nothing
LEAST_OF_FEW_PX = 1.0  # with too few to see whether they want a fundamental matrix
FITS = 3.0  # times the noise, or the least that contradicts: what the deviation of half of the matches may be
TO_NORMAL = 1.4826  # from the median of |x| to the standard deviation
ROUNDS = 3  # in which the nearest half of the matches tells the geometry anew (Rousseeuw & Van Driessen 1999)
PLENTY = 120  # matches, of which none has much part in a geometry of its own; of fewer each is asked for what it adds
SCARCE = 17.0  # matches, as few as which leave their deviation uncertain: twice as many of it contradict then
MOST_OF_ROWS_PX = 1.5  # standard deviation of matches in equal rows
APART = 2.0  # times the farthest of the others: cameras that are turned a little spread matches without a gap
TELLING = 12.0  # F-ratio of what the three further parameters of a fundamental matrix explain to what they leave


@dataclass(frozen=True)
class Fit:
    """distance(left, right): (M,) px of any matches from a geometry that others have; deviation: of those, px; gross:
    how many deviations contradict it, more where few tell it."""

    distance: Callable[[NDArray, NDArray], NDArray]
    deviation: float
    gross: float


def agree(left: NDArray, right: NDArray, noise_px: float) -> bool:
    """Whether all matches, (M, 2) px each, have one affine geometry, or are too few to tell one."""
    most = max(LEAST_PX * _unit(left, right), GROSS * noise_px)
    if len(left) < FEWEST or (np.abs(right[:, 1] - left[:, 1]) <= most).all():  # rows are one, which most heads have
        return True
    return bool((np.abs(affine_distance(left, right)) <= most).all())


def contradicting(left: NDArray, right: NDArray, noise_px: float, rng: np.random.Generator) -> NDArray:
    """(M,) bool; none with too few matches. left, right: (M, 2) px; noise_px: of a coordinate, standard deviation."""
    count, unit_px = len(left), _unit(left, right)
    found = [np.zeros(count, bool)]
    if count >= FEWEST:
        least = unit_px * (LEAST_PX if count >= FEWEST_OF_F else LEAST_OF_FEW_PX)
        found += _wrong(_affine_draws(left, right, rng), affine_distance, left, right, noise_px, least)
    if count >= FEWEST_OF_F:
        draws, least = _fundamental_draws(left, right, rng), unit_px * LEAST_PX
        found += _wrong(draws, fundamental_distance, left, right, noise_px, least)
    return min(found[1:], key=np.count_nonzero, default=found[0])


def _unit(left: NDArray, right: NDArray) -> float:
    return image_unit(np.concatenate([left, right], 1))


def _wrong(
    away: NDArray, distance: Callable, left: NDArray, right: NDArray, noise_px: float, least: float
) -> list[NDArray]:
    """The (M,) bool that contradict one kind of geometry, or nothing if that does not fit. away: (M,) px from the best
    draw."""
    away = _concentrated(away, distance, left, right)
    for _ in range(ROUNDS):
        scale = max(noise_px, TO_NORMAL * (1 + 5 / len(away)) * float(np.median(away)))
        wrong = away > max(least, GROSS * scale)
        if scale > max(LEAST_PX * _unit(left, right), FITS * noise_px) or (~wrong).sum() < FEWEST:
            return []
        away = np.abs(distance(left[~wrong], right[~wrong], left, right))
    return [wrong]


def spread(left: NDArray, right: NDArray, rng: np.random.Generator) -> float:
    """px, the standard deviation of the better half of the matches, (M, 2) px each, from the geometry that fits it
    best: what their noise is if nobody says. Raises ValueError with fewer than FEWEST."""
    count = len(left)
    if count < FEWEST:
        raise ValueError(f"needs {FEWEST} matches, got {count}")
    away = [_concentrated(_affine_draws(left, right, rng), affine_distance, left, right)]
    if count >= FEWEST_OF_F:
        away.append(_concentrated(_fundamental_draws(left, right, rng), fundamental_distance, left, right))
    return TO_NORMAL * (1 + 5 / count) * min(float(np.median(one)) for one in away)


def geometry_of(left: NDArray, right: NDArray, rounding_px: float = 0.0) -> Fit:
    """Of matches that do not contradict each other, (M, 2) px each: affine, or a fundamental matrix's where that is
    needed and they are enough to tell it. rounding_px: of a coordinate, standard deviation, which equal rows hide."""
    count = len(left)
    least = LEAST_PX if count >= FEWEST_OF_F else LEAST_OF_FEW_PX
    distance, free, off = affine_distance, 4, _squares(affine_distance(left, right))
    if count >= FEWEST_OF_F:
        left_over = _squares(fundamental_distance(left, right))
        if (off - left_over) / 3 > TELLING * left_over / (count - 7):
            distance, free, off = fundamental_distance, 7, left_over
    deviation = max(float(np.sqrt(off / (count - free))), least / GROSS, rounding_px)
    if count < PLENTY:
        return Fit(lambda l, r: _added(distance, left, right, l, r), deviation, _gross(count))
    return Fit(lambda l, r: distance(left, right, l, r), deviation, _gross(count))


def _added(distance: Callable, left: NDArray, right: NDArray, *more: NDArray) -> NDArray:
    """(M,) px: by how much each further match alone, (M, 2) px, moves the geometry and stays off it, as the root of the
    squares that it adds: what is far from all others is off any geometry that was fitted without it."""
    off = _squares(distance(left, right))
    each = zip(
        *(np.concatenate([np.repeat(of[None], len(one), 0), one[:, None]], 1) for of, one in zip((left, right), more))
    )
    return np.sqrt(np.maximum([_squares(distance(*both)) - off for both in each], 0.0))


def rows_of(left: NDArray, right: NDArray, rounding_px: float = 0.0) -> Fit | None:
    """Of matches, (M, 2) px each, most of which lie in equal rows but for one offset, as parallel cameras have them:
    the one geometry that few matches tell from all others. None if they do not. rounding_px: as of `geometry_of`."""
    below = right[:, 1] - left[:, 1]
    offset = float(np.median(below))
    away = np.abs(below - offset) / np.sqrt(2)
    deviation = max(TO_NORMAL * (1 + 5 / len(away)) * float(np.median(away)), rounding_px, LEAST_PX / GROSS)
    if deviation > MOST_OF_ROWS_PX:
        return None
    gross = _gross(len(away))
    farthest = float(away[away <= gross * deviation].max()) / deviation
    return Fit(lambda l, r: (r[:, 1] - l[:, 1] - offset) / np.sqrt(2), deviation, max(gross, APART * farthest))


def _gross(count: int) -> float:
    return GROSS * (1 + (SCARCE / count) ** 2)


def _concentrated(away: NDArray, distance: Callable, left: NDArray, right: NDArray) -> NDArray:
    """(M,) px from the geometry of the nearest half, found in a few rounds. away: (M,) px from the best draw."""
    for _ in range(ROUNDS):
        half = away <= np.median(away)
        away = np.abs(distance(left[half], right[half], left, right))
    return away


def _squares(away: NDArray) -> float:
    return float(away @ away)


def affine_distance(left: NDArray, right: NDArray, *of: NDArray) -> NDArray:
    """(M,) px, with a sign, from the nearest affine geometry of matches (n, 2); of: other matches than these."""
    f, f33 = fit_affine_fundamental(left, right)
    left, right = of or (left, right)
    return left @ f[:2] + right @ f[2:] + f33


def fundamental_distance(left: NDArray, right: NDArray, *of: NDArray) -> NDArray:
    """As `affine_distance`, by the fundamental matrix."""
    return sampson_distance(fit_fundamental(left, right), *(of or (left, right)))


def _affine_draws(left: NDArray, right: NDArray, rng: np.random.Generator) -> NDArray:
    """(M,) px from the geometry of the best draw of four."""
    matches = np.concatenate([left, right], 1)
    matches = matches - np.median(matches, 0)
    rows = np.concatenate([matches, np.ones((len(matches), 1))], 1)
    found = np.linalg.svd(rows[_draws(rng, DRAWS, len(rows), 4)])[2][:, -1]
    return _best(np.abs(rows @ found.T).T / np.maximum(np.linalg.norm(found[:, :4], axis=1), 1e-12)[:, None])


def _fundamental_draws(left: NDArray, right: NDArray, rng: np.random.Generator) -> NDArray:
    """(M,) px from the geometry of the best draw of eight."""
    centres = np.median(left, 0), np.median(right, 0)
    scale = max(float(np.median(np.abs(left - centres[0]))), 1e-12)
    l, r = (homogeneous((points - centre) / scale) for points, centre in zip((left, right), centres))
    rows = (r[:, :, None] * l[:, None, :]).reshape(-1, 9)
    found = np.linalg.svd(rows[_draws(rng, DRAWS_OF_F, len(rows), 8)])[2][:, -1]
    F = found.reshape(-1, 3, 3)
    slope = ((l @ np.swapaxes(F, 1, 2))[..., :2] ** 2).sum(-1) + ((r @ F)[..., :2] ** 2).sum(-1)
    return _best(scale * np.abs(rows @ found.T).T / np.sqrt(np.maximum(slope, 1e-300)))


def _draws(rng: np.random.Generator, draws: int, count: int, each: int) -> NDArray:
    """(draws, each) different indices below count."""
    return rng.random((draws, count)).argpartition(each, axis=1)[:, :each]


def _best(away: NDArray) -> NDArray:
    """Of distances (draws, M), those whose median is least."""
    return away[np.median(away, 1).argmin()]
