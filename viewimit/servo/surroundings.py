"""What a learner knows about a posture: how E should rise about it, and how it did at the postures visited."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..evaluation import conflict as evaluate
from .minimise import DIFFERENCE, Minimum
from .observation import Observation
from .own_noise import own_noise
from .surrogate import Surrogate
from .visit import Visit

FREE = 4  # points that affine fundamental matrices fit exactly, Section 2.2


def enough_points(joints: int) -> int:
    """So many contradict a wrong posture: as rows match, each pair tells three coordinates of a point; the joints and a
    homography of space, of 15 numbers, fit as many as they are; more than a point's must be left over."""
    return (15 + 3 + joints) // 3 + 1


def freedom_of(points: int, joints: int) -> int:
    """Residuals that the transfer and the joints do not fit by themselves."""
    return max(4 * (points - FREE) - joints, 1)


@dataclass(frozen=True)
class Surroundings:
    """What is known about a posture: hessian: (m, m) px²/rad², of the predicted E; E: px², there; points: N; seen: how
    many of them really were, at the best visit; without_one: (k, m, m), hessians by these but one, none where no point
    is ever hidden; left: (m,) rad, from there to where E should be least; gradients: (k, m) px²/rad, of E there as k
    draws of the own images' noise have them; slopes: (m, m) px²/rad², by which E would rise if all motion of the own
    images were conflict; away: (n, m) rad, the visits from there; rise: (n,) px², of the E measured at them, NaN where
    it cannot be compared, by points whose hessian is hessians: (n, m, m); low, high: (m,) rad, what the limits leave;
    noise_px: of residuals, standard deviation."""

    hessian: NDArray
    E: float
    points: int
    seen: int
    without_one: NDArray
    left: NDArray
    gradients: NDArray
    slopes: NDArray
    away: NDArray
    rise: NDArray
    hessians: NDArray
    low: NDArray
    high: NDArray
    noise_px: float

    @property
    def freedom(self) -> int:
        return freedom_of(self.points, len(self.hessian))


@dataclass(frozen=True)
class Known:
    """visits; best: index of the one with the smallest E; E: px², there; model: learned from them; seen: at the
    last; residual_of: own images (..., N, 4) px → (..., n, C) px, by the transfer chosen."""

    visits: tuple[Visit, ...]
    best: int
    E: float
    model: Surrogate
    seen: Observation
    residual_of: Callable[[NDArray], NDArray]


def survey(known: Known, found: Minimum, place: NDArray) -> Surroundings:
    """About a place, (m,) rad. found: the smallest E that is predicted."""
    rise, hessians = _rises(known, found.hessian, place)
    seen, without_one = _really_seen(known, found, place)
    hessian = found.hessian
    gradients = np.zeros((1, len(place)))
    if known.seen.noise_px > 0:
        freedom = freedom_of(found.points, len(place))
        noise = own_noise(known.model, known.residual_of, place, known.seen.noise_px, freedom, known.seen.motion)
        hessian, hessians, gradients = noise.taken_off(hessian), noise.taken_off(hessians), noise.gradients
    return Surroundings(
        hessian=hessian,
        E=known.E,
        points=found.points,
        seen=seen,
        without_one=without_one,
        left=found.theta - place,
        gradients=gradients,
        slopes=_image_slopes(known.model, place),
        away=np.array([visit.displacement for visit in known.visits]) - place,
        rise=rise,
        hessians=hessians,
        low=known.seen.lower - place,
        high=known.seen.upper - place,
        noise_px=known.seen.noise_px,
    )


def _rises(known: Known, hessian: NDArray, place: NDArray) -> tuple[NDArray, NDArray]:
    """(n,) px²: E measured at every visit above that at the best one, by the points really seen in both; (n, m, m)
    px²/rad²: the hessian of these points."""
    own = np.array([visit.own for visit in known.visits])
    seen = np.array([visit.seen.all(-1) for visit in known.visits])
    hessians = np.repeat(hessian[None], len(own), 0)
    if seen.all():
        E = evaluate(known.residual_of(own))
        with np.errstate(invalid="ignore"):  # two that nothing tells
            return E - E[known.best], hessians
    rises = np.full(len(own), np.nan)
    about = known.model.predict(place + DIFFERENCE * np.eye(1 + len(place), len(place), -1))
    for k, both in enumerate(seen & seen[known.best]):
        images = np.concatenate([own[[known.best, k]], about])
        e = known.residual_of(np.where(both[:, None], images, np.nan))
        here, there = evaluate(e[:2])
        if np.isfinite(there):
            J = (e[3:] - e[2]).reshape(len(place), -1) / DIFFERENCE
            rises[k], hessians[k] = there - here, J @ J.T / e.shape[-2]
    return rises, hessians


def _really_seen(known: Known, found: Minimum, place: NDArray) -> tuple[int, NDArray]:
    """How many points told E at the best visit without being predicted; hessians (k, m, m) px²/rad² by these but each
    in turn, none where all points are seen at every visit: then none is seen because the posture is a wrong one."""
    m, seen = len(place), np.array([visit.seen.all(-1) for visit in known.visits])
    if seen.all():
        return found.points, np.empty((0, m, m))
    at_best, best = seen[known.best], known.visits[known.best].own
    about = known.model.predict(place + DIFFERENCE * np.eye(1 + m, m, -1))
    by = lambda points, images: known.residual_of(np.where(points[:, None], images, np.nan))
    hessians = []
    for point in np.flatnonzero(at_best):
        e = by(at_best & (np.arange(len(at_best)) != point), about)
        J = (e[1:] - e[0]).reshape(m, -1) / DIFFERENCE if np.isfinite(e).all() else np.zeros((m, 1))
        hessians.append(J @ J.T / e.shape[-2])
    return by(at_best, best).shape[-2], np.array(hessians).reshape(-1, m, m)


def _image_slopes(model: Surrogate, place: NDArray) -> NDArray:
    """(m, m) px²/rad², as `Surroundings.slopes`, of the points that the model knows."""
    aside = DIFFERENCE * np.eye(len(place))
    images = model.predict(np.concatenate([place + aside, place - aside]))
    images = images[:, np.isfinite(images).all((0, 2))]
    points = max(images.shape[1], 1)
    slopes = (images[: len(place)] - images[len(place) :]).reshape(len(place), -1) / (2 * DIFFERENCE)
    return slopes @ slopes.T / points
