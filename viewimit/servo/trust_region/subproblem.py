"""What a learner measures at the postures visited, and expects of those it has not visited."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, partial

import numpy as np
from numpy.typing import NDArray

from ...estimation.residuals import NoiseReference, ResidualFunction, conflict
from ..least_squares import Minimum, minimise
from ..observation import Observation
from .convergence import Certificate, certify
from .image_models import ImageData, ImageModel
from .local_model import UNTOLD, Known, enough_points, fitted_points, survey

GRID, SCATTERED, POLISHED = 7, 48, 3  # candidates a joint, with many joints in all; those that are refined
EQUAL = 1e-6  # share of E: what differs by less, as where a joint moves no point, may do so by rounding
OWN_SHARE = 0.1  # of the variance of a single own image, that kinematics leave of it
WELL_TOLD = (
    1.0  # px, standard deviation up to which a point that is not seen is as good as one that is, where E is large
)


@dataclass(frozen=True)
class Measured:
    """E: px², of each visit, (n,); points: that may have told it, (n, N) bool; count: (n,), how many did; best: the
    visit where it is least; noise_reference: of the residuals by their noise, or None where there is none."""

    E: NDArray
    points: NDArray
    count: NDArray
    best: int
    noise_reference: NoiseReference | None = None


@dataclass(frozen=True)
class Outlook:
    """E: px², at the best posture visited; model: of the images about it; found: where the predicted E is least;
    certify: a posture (m,) rad → its certificate, None by another transfer than the chosen one, and where too few
    points are foretold for any E."""

    E: float
    model: ImageModel
    found: Minimum
    certify: Callable[[NDArray], Certificate] | None

    @property
    def step(self) -> float:
        """rad, a joint, from the best posture visited to where E should be least."""
        return float(np.abs(self.found.theta - self.model.centre).max())

    @property
    def doubt(self) -> float:
        """rad, at the best posture visited."""
        return doubt(self.E, self.found)

    @property
    def doubt_there(self) -> float:
        """rad, where E should be least."""
        return doubt(self.found.E, self.found)


def measure(learned: ImageData, residuals: ResidualFunction, transfer: str | None, needed: int = 0) -> Measured:
    """E at all postures visited, noise averaged over them. transfer: another than the chosen one; needed: points that
    must tell E at the best of them, if any has so many.

    Points that are not seen lead on where E is large. Where it is not, they must be told as well as noise lets those be
    that are.
    """
    measured = _measure_by(WELL_TOLD, learned, residuals, transfer, needed)
    noise_px = learned.noise_px
    strictly = 0 < noise_px < WELL_TOLD and not all(visit.seen.all() for visit in learned.visits)
    if strictly and measured.E[measured.best] < WELL_TOLD**2:
        return _measure_by(noise_px, learned, residuals, transfer, needed)
    return measured


def _measure_by(
    most: float, learned: ImageData, residuals: ResidualFunction, transfer: str | None, needed: int
) -> Measured:
    """As `measure`; most: px, standard deviation up to which a point that is not seen is as good as one that is."""
    own, known = _completed(learned, most)
    asked = own, known, len(learned.visits[0].displacement), needed
    if learned.noise_px == 0 or transfer is not None:
        return _measure(*asked, lambda images: residuals(images, transfer))
    measured = _measure(*asked, lambda images: residuals(images, transfer, NoiseReference()))
    noise_reference = NoiseReference(own[measured.best], _own_share(learned, measured.best))
    return replace(
        _measure(*asked, lambda images: residuals(images, transfer, noise_reference)), noise_reference=noise_reference
    )


def _own_share(learned: ImageData, best: int) -> float:
    """The variance of the own images that are compared, as a share of that of a single image.

    Kinematics average the noise of many visits. Without them, and where a point that rests has the same image to the
    last bit at other visits, nothing does: images are rounded then, always alike.
    """
    return 1.0 if learned.kinematics is None or _repeats(learned, best) else OWN_SHARE


def _repeats(learned: ImageData, best: int) -> bool:
    """Whether some point has the very image of one visit at another posture."""
    here, others = learned.visits[best], [visit for k, visit in enumerate(learned.visits) if k != best]
    apart = (visit for visit in others if (visit.displacement != here.displacement).any())
    return any(bool((visit.own == here.own).all(-1).any()) for visit in apart)


def look_out(
    learned: ImageData,
    measured: Measured,
    radius: float,
    seen: Observation,
    residuals: ResidualFunction,
    transfer: str | None,
) -> Outlook:
    """Within so many rad of the best posture visited. seen: at the last visit."""
    best, noise_reference = measured.best, measured.noise_reference
    model = learned.fit(best)
    asked = model.restrict(measured.points[best])
    found = _search(model, radius, seen, lambda theta: residuals(asked.predict(theta), transfer, noise_reference))
    E = float(measured.E[best])
    if transfer is not None or not np.isfinite(found.E):
        return Outlook(E, model, found, None)
    residual_of = partial(residuals, transfer=None, noise_reference=noise_reference)
    of_single = (
        None
        if noise_reference is None
        else partial(residuals, transfer=None, noise_reference=replace(noise_reference, own_variance_ratio=1.0))
    )
    others = tuple(partial(residual_of, rig=k) for k in range(1, seen.heads + 1))
    by_own = measured.E if noise_reference is None else None
    known = Known(
        tuple(learned.visits), best, E, measured.points[best], model, seen, residual_of, by_own, others, of_single
    )
    return Outlook(E, model, found, lambda place: certify(survey(known, found, place)))


def doubt(E: float, found: Minimum) -> float:
    """How far off, rad, a displacement can be that makes E, by E ≈ δθᵀQδθ, along what is told at all."""
    curvatures = np.linalg.eigvalsh(found.hessian)
    told = curvatures[curvatures * found.points > UNTOLD**-2]
    return float(np.sqrt(2 * E / max(told[0] if len(told) else curvatures[0], 1e-12)))


def _completed(learned: ImageData, most: float) -> tuple[NDArray, NDArray]:
    """Of all visits, as they tell of each other: images (n, N, 4) px, their noise averaged, points not seen completed;
    and which points are known there, (n, N) bool: that were seen, or are told well, to `most` px."""
    visits, noise_px = learned.visits, learned.noise_px
    own = np.array([visit.own for visit in visits])
    seen = np.all([visit.seen for visit in visits], -1)
    unseen = np.isnan(own)
    if noise_px == 0 and not unseen.any():
        return own, seen
    model = learned.fit()
    displacement = np.array([visit.displacement for visit in visits])
    told = model.predict(displacement)
    known = seen if seen.all() else seen | (model.prediction_std(displacement) < most)
    return (told if noise_px > 0 else np.where(unseen, told, own)), known


def _measure(
    own: NDArray, known: NDArray, joints: int, needed: int, residual_of: Callable[[NDArray], NDArray]
) -> Measured:
    """Each by the points that are known there, if they contradict a wrong posture; else by all, however badly they are
    told. Of fewer points E is smaller by itself, as so many of them fit any posture: that is made up for."""
    if known.all():
        e = residual_of(own)
        E = conflict(e)
        return Measured(E, known, np.full(len(E), e.shape[-2]), last_least(E))
    enough = enough_points(joints)
    points, E, count = known.copy(), np.empty(len(own)), np.empty(len(own), int)
    for k, (images, these) in enumerate(zip(own, points)):
        e = residual_of(np.where(these[:, None], images, np.nan))
        if e.shape[-2] < enough:
            e, these[:] = residual_of(images), True
        E[k], count[k] = conflict(e), e.shape[-2]
    worth = E * count / np.maximum(count - fitted_points(joints), 1)
    if (count >= needed).any():
        worth[count < needed] = np.inf
    return Measured(E, points, count, last_least(worth))


def last_least(E: NDArray) -> int:
    """Index of the least of (n,) px², of equal ones the last: it is nearer to where the arm is."""
    return int(np.flatnonzero(E <= E.min() * (1 + EQUAL))[-1])


def _search(model: ImageModel, radius: float, seen: Observation, residual_at) -> Minimum:
    """argmin of the predicted E within the region and the limits: the best of many candidates, refined."""
    low, high = np.maximum(seen.lower, model.centre - radius), np.minimum(seen.upper, model.centre + radius)
    m = len(low)
    if m <= 2:
        share = _grid(m)
        scattered = (1 - share) * low + share * high
    else:
        scattered = np.random.default_rng(seen.motion).uniform(low, high, (SCATTERED, m))
    E = conflict(residual_at(scattered))
    starts = np.concatenate([model.centre[None], scattered[np.argsort(E)[:POLISHED]]])
    found = minimise(residual_at, starts, low, high)
    return replace(found, theta=found.theta + found.left)  # what is claimed to be left of errors rests on the place


@cache
def _grid(joints: int) -> NDArray:
    """(GRID**m, m): shares of each joint's range, evenly from 0 to 1."""
    axes = np.meshgrid(*[np.linspace(0, 1, GRID)] * joints, indexing="ij")
    return np.stack(axes, -1).reshape(-1, joints)
