"""What a learner knows about a posture: how E should rise about it, and how it did at the postures visited."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...estimation.residuals import conflict
from ..least_squares import DIFFERENCE, Minimum, aside
from ..observation import Observation, Visit
from .image_models import ImageModel, estimate_own_noise

UNTOLD = np.radians(20.0)  # a pixel: nothing tells a joint that costs as much
LEARNED = 1.0 / UNTOLD  # px/rad: slopes as uncertain as this tell a joint that nothing tells
ResidualOf = Callable[[NDArray], NDArray]  # own images (..., N, 4) px → (..., n, C) px
FREE = 4  # points that affine fundamental matrices fit exactly, Section 2.2


def fitted_points(joints: int) -> float:
    """So many the joints and a homography of space, of 15 numbers, fit by themselves: as rows match, each pair tells
    three coordinates of a point."""
    return (15 + joints) / 3


def enough_points(joints: int) -> int:
    """So many contradict a wrong posture: more coordinates than a point's are left over that nothing fits."""
    return int(fitted_points(joints) + 1) + 1


def freedom_of(points: int, joints: int) -> int:
    """Residuals that the transfer and the joints do not fit by themselves."""
    return max(4 * (points - FREE) - joints, 1)


@dataclass(frozen=True)
class Surroundings:
    """What is known about a posture: hessian: (m, m) px²/rad², of the predicted E, the mean over `points`; foreseen: if
    those that were seen rarely moved as predicted, too, and the own images had no noise, the sum over all, by `points`;
    E: px², there; seen: how many of them really were, at the best visit; left: (m,) rad, from there to where E should
    be least; gradients: (k, m) px²/rad, of E there as k draws of the own images' noise have them; by_slopes: as draws
    of their slopes' do; head: (k, m) px²/rad, by how much more it would be with each other head; slopes: (m, m)
    px²/rad², by which E would rise if all motion of the own images were conflict; away: (n, m) rad, the visits from
    there; rise: (n,) px², of the E measured at them, NaN where it cannot be compared, by points whose hessian is
    hessians: (n, m, m), weighted as single images are; whole: (m, m), of all points and weighted the same way; low,
    high: (m,) rad, what the limits leave; noise_px: of residuals, standard deviation."""

    hessian: NDArray
    foreseen: NDArray
    E: float
    points: int
    seen: int
    left: NDArray
    gradients: NDArray
    by_slopes: NDArray
    head: NDArray
    slopes: NDArray
    away: NDArray
    rise: NDArray
    hessians: NDArray
    whole: NDArray
    low: NDArray
    high: NDArray
    noise_px: float

    @property
    def freedom(self) -> int:
        return freedom_of(self.points, len(self.hessian))


@dataclass(frozen=True)
class Known:
    """visits; best: index of the one with the smallest E; E: px², there; points: (N,) bool, by which it was measured
    there; model: learned from the visits; seen: at the last; residual_of: own images (..., N, 4) px → (..., n, C) px,
    by the transfer chosen, points NaN in them left out; measured: (n,) px², E of each visit by its own images, None
    where it was not by these; others: as residual_of, of each other head that may be; residual_of_single: weighted for
    single own images, as they were seen at the visits, None where residual_of is not weighted."""

    visits: tuple[Visit, ...]
    best: int
    E: float
    points: NDArray
    model: ImageModel
    seen: Observation
    residual_of: Callable[[NDArray], NDArray]
    measured: NDArray | None = None
    others: tuple[ResidualOf, ...] = ()
    residual_of_single: ResidualOf | None = None

    @property
    def of_visits(self) -> ResidualOf:
        """The residuals of own images as they were seen."""
        return self.residual_of if self.residual_of_single is None else self.residual_of_single


def survey(known: Known, found: Minimum, place: NDArray) -> Surroundings:
    """About a place, (m,) rad. found: the smallest E that is predicted."""
    learned = known.model.jacobian_std(place) < LEARNED
    hessian, foreseen, points = found.hessian, found.hessian, found.points
    if not learned[known.points].all():
        hessian, points = _hessian_by(known, known.points & learned, place)
    whole = hessian
    if known.residual_of_single is not None:
        whole = _hessian(_of_points(known, known.residual_of_single, learned, place)(_images_about(known.model, place)))
    rise, hessians = _rises(known, whole, place, learned)
    gradients = by_slopes = np.zeros((1, len(place)))
    if known.seen.noise_px > 0:
        freedom, residual_of = freedom_of(points, len(place)), _of_points(known, known.residual_of, learned, place)
        noise = estimate_own_noise(known.model, residual_of, place, known.seen.noise_px, freedom, known.seen.motion)
        hessian, hessians = noise.debias_hessian(hessian), noise.debias_hessian(hessians)
        whole = noise.debias_hessian(whole)
        gradients, by_slopes = noise.grad_samples_images, noise.grad_samples_jacobian
    return Surroundings(
        hessian=hessian,
        foreseen=foreseen * found.points / points,
        E=known.E,
        points=points,
        seen=_really_seen(known, points),
        left=found.theta - place,
        gradients=gradients,
        by_slopes=by_slopes,
        head=_head_gradients(known, learned, place),
        slopes=_image_slopes(known.model, place),
        away=np.array([visit.displacement for visit in known.visits]) - place,
        rise=rise,
        hessians=hessians,
        whole=whole,
        low=known.seen.lower - place,
        high=known.seen.upper - place,
        noise_px=known.seen.noise_px,
    )


def _hessian_by(known: Known, points: NDArray, place: NDArray) -> tuple[NDArray, int]:
    """(m, m) px²/rad², of the E that these points, (N,) bool, should make about a place, 0 where they are too few for
    any; and how many make it."""
    e = known.residual_of(np.where(points[:, None], _images_about(known.model, place), np.nan))
    return (_hessian(e) if np.isfinite(e).all() else np.zeros((len(place),) * 2)), max(e.shape[-2], 1)


def _images_about(model: ImageModel, place: NDArray) -> NDArray:
    """(1 + m, N, 4) px, predicted at a place and a little aside by each joint."""
    return model.predict(place + DIFFERENCE * aside(len(place)))


def _of_points(known: Known, residual_of: ResidualOf, learned: NDArray, place: NDArray) -> ResidualOf:
    """The residuals of the points by which E was measured that are learned, (N,) bool, alone: others may be predicted
    anywhere. Of all, if these are too few for any."""
    points = known.points & learned
    of_these = lambda own: residual_of(np.where(points[:, None], own, np.nan))
    enough = points.all() or np.isfinite(of_these(known.model.predict(place))).all()
    return of_these if enough else residual_of


def _head_gradients(known: Known, learned: NDArray, place: NDArray) -> NDArray:
    """(k, m) px²/rad, as `Surroundings.head`."""
    if not known.others:
        return np.zeros((0, len(place)))
    about = _images_about(known.model, place)
    heads = known.residual_of, *known.others
    by_head = [_gradient(_of_points(known, of_head, learned, place)(about)) for of_head in heads]
    return np.array([gradient - by_head[0] for gradient in by_head[1:]])


def _gradient(e: NDArray) -> NDArray:
    """(m,) px²/rad, of E, as `_hessian`."""
    return (e[1:] - e[0]).reshape(len(e) - 1, -1) @ e[0].ravel() / (DIFFERENCE * e.shape[-2])


def _hessian(e: NDArray) -> NDArray:
    """(m, m) px²/rad², Gauss and Newton's, of residuals (1 + m, n, C) px of such images."""
    J = (e[1:] - e[0]).reshape(len(e) - 1, -1) / DIFFERENCE
    return J @ J.T / e.shape[-2]


def _rises(known: Known, hessian: NDArray, place: NDArray, learned: NDArray) -> tuple[NDArray, NDArray]:
    """(n,) px²: E measured at every visit above that at the best one, by the points really seen in both and learned,
    (N,) bool; (n, m, m) px²/rad²: the hessian of these points."""
    own, seen, residual_of = _visited(known), known.model.seen, known.of_visits
    hessians = np.repeat(hessian[None], len(own), 0)
    if seen.all():
        E = conflict(residual_of(own)) if known.measured is None else known.measured
        with np.errstate(invalid="ignore"):  # two that nothing tells
            return E - E[known.best], hessians
    rises = np.full(len(own), np.nan)
    about = _images_about(known.model, place)
    for k, both in enumerate(seen & seen[known.best] & learned):
        images = np.concatenate([own[[known.best, k]], about])
        e = residual_of(np.where(both[:, None], images, np.nan))
        here, there = conflict(e[:2])
        if np.isfinite(there):
            rises[k], hessians[k] = there - here, _hessian(e[2:])
    return rises, hessians


def _really_seen(known: Known, points: int) -> int:
    """How many points tell E at the best visit without being predicted; as many as `points`, where all are seen at
    every visit: then none is seen because the posture is a wrong one."""
    if known.model.seen.all():
        return points
    best, seen = _visited(known)[known.best], known.model.seen[known.best]
    return known.of_visits(np.where(seen[:, None], best, np.nan)).shape[-2]


def _visited(known: Known) -> NDArray:
    """(n, N, 4) px"""
    return known.model.impute(np.array([visit.own for visit in known.visits]))


def _image_slopes(model: ImageModel, place: NDArray) -> NDArray:
    """(m, m) px²/rad², as `Surroundings.slopes`, of the points that the model knows."""
    slopes = model.jacobian(place)[:, np.isfinite(model.at_centre).all(-1)]
    points = max(slopes.shape[1], 1)
    slopes = slopes.reshape(len(place), -1)
    return slopes @ slopes.T / points
