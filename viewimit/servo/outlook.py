"""What a learner measures at the postures visited, and expects of those it has not visited."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..evaluation import conflict as evaluate
from .certificate import UNTOLD, Certificate, certify
from .image_model import ENOUGH
from .minimise import Minimum, minimise
from .observation import Conflict, Observation
from .surrogate import Surrogate, learn
from .surroundings import FREE, Known, survey
from .visit import Visit

GRID, SCATTERED, POLISHED = 7, 48, 3  # candidates a joint, with many joints in all; those that are refined


@dataclass(frozen=True)
class Measured:
    """E: px², of each visit, (n,); points: that it is of, (n, N) bool; best: the visit where it is least; like: (N, 4)
    px, own images by which noise is weighted, or None where there is none."""

    E: NDArray
    points: NDArray
    best: int
    like: NDArray | None = None


@dataclass(frozen=True)
class Outlook:
    """E: px², at the best posture visited; model: of the images about it; found: where the predicted E is least;
    certify: a posture (m,) rad → its certificate, None by another transfer than the chosen one."""

    E: float
    model: Surrogate
    found: Minimum
    certify: Callable[[NDArray], Certificate] | None

    @property
    def step(self) -> float:
        """rad, a joint, from the best posture visited to where E should be least."""
        return float(np.max(np.abs(self.found.theta - self.model.centre)))

    @property
    def doubt(self) -> float:
        """rad, at the best posture visited."""
        return doubt(self.E, self.found)

    @property
    def doubt_there(self) -> float:
        """rad, where E should be least."""
        return doubt(self.found.E, self.found)


def measure(visits: tuple[Visit, ...], noise_px: float, conflict: Conflict, by: str | None) -> Measured:
    """E at all postures visited, noise averaged over them. by: another transfer than the chosen one."""
    own = _smoothed(visits, noise_px)
    measured = _measure(visits, own, lambda images: conflict(images, by))
    if noise_px == 0 or by is not None:
        return measured
    like = own[measured.best]
    return replace(_measure(visits, own, lambda images: conflict(images, by, like)), like=like)


def look_out(
    visits: tuple[Visit, ...], measured: Measured, radius: float, seen: Observation, conflict: Conflict, by: str | None
) -> Outlook:
    """Within so many rad of the best posture visited. seen: at the last visit."""
    best, like = measured.best, measured.like
    model = learn(list(visits), best, seen.noise_px)
    same = np.where(measured.points[best], 0.0, np.nan)[:, None]  # points as those of the best visit's E
    found = _search(model, radius, seen, lambda theta: conflict(model.predict(theta) + same, by, like))
    E = float(measured.E[best])
    if by is not None:
        return Outlook(E, model, found, None)
    known = Known(visits, best, E, model, seen, lambda own: conflict(own, None, like))
    return Outlook(E, model, found, lambda place: certify(survey(known, found, place)))


def doubt(E: float, found: Minimum) -> float:
    """How far off, rad, a displacement can be that makes E, by E ≈ δθᵀQδθ, along what is told at all."""
    curvatures = np.linalg.eigvalsh(found.hessian)
    told = curvatures[curvatures * found.points > UNTOLD**-2]
    return float(np.sqrt(2 * E / max(told[0] if len(told) else curvatures[0], 1e-12)))


def _smoothed(visits: tuple[Visit, ...], noise_px: float) -> NDArray:
    """(n, N, 4) px of all visits, as they tell of each other: noise is averaged, points not seen are completed."""
    own = np.array([visit.own for visit in visits])
    unseen = np.isnan(own)
    if noise_px == 0 and not unseen.any():
        return own
    model = learn(list(visits), len(visits) - 1, noise_px)
    told = model.predict(np.array([visit.displacement for visit in visits]))
    return told if noise_px > 0 else np.where(unseen, told, own)


def _measure(visits: tuple[Visit, ...], own: NDArray, residual_of: Callable[[NDArray], NDArray]) -> Measured:
    """Each by the points that were really seen there, if they are ENOUGH; else by all, as other visits tell of them. Of
    fewer points E is smaller by itself, as FREE of them fit any images: that is made up for."""
    seen = np.array([visit.seen.all(-1) for visit in visits])
    if seen.all():
        E = evaluate(residual_of(own))
        return Measured(E, seen, int(np.argmin(E)))
    E, count = np.empty((2, len(visits)))
    for k, (images, these) in enumerate(zip(own, seen)):
        e = residual_of(np.where(these[:, None], images, np.nan))
        if e.shape[-2] < ENOUGH:
            e, these[:] = residual_of(images), True
        E[k], count[k] = evaluate(e), e.shape[-2]
    return Measured(E, seen, int(np.argmin(E * count / np.maximum(count - FREE, 1))))


def _search(model: Surrogate, radius: float, seen: Observation, residual_at) -> Minimum:
    """argmin of the predicted E within the region and the limits: the best of many candidates, refined."""
    low, high = np.maximum(seen.lower, model.centre - radius), np.minimum(seen.upper, model.centre + radius)
    m = len(low)
    if m <= 2:
        axes = [np.linspace(a, b, GRID) for a, b in zip(low, high)]
        scattered = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, m)
    else:
        scattered = np.random.default_rng(seen.motion).uniform(low, high, (SCATTERED, m))
    E = evaluate(residual_at(scattered))
    starts = np.concatenate([model.centre[None], scattered[np.argsort(E)[:POLISHED]]])
    return minimise(residual_at, starts, low, high)
