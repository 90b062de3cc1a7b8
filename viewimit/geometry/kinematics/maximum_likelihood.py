"""Kinematics of maximum likelihood: the best of several local minima and of several choices of joints.

The images of few visits may show neither the frame nor which joints move a point near their axes. `adjustment` keeps
the kinematics fitted to them as long as noise explains later images. So these kinematics may be wrong, which only makes
the own images look noisier than they are. Here all visits are adjusted again: from these kinematics, and afresh.

Which joints move a point is a discrete unknown. Two choices that differ for one point and one joint have equally many
unknowns, so the smaller cost is the more likely choice. The cost of each such change is predicted by one Gauss-Newton
step of all unknowns, from the normal equations in which this point's share is replaced. The best changes are then
adjusted, one after the other, until none lowers the cost.

References
----------
Triggs, McLauchlan, Hartley and Fitzgibbon, "Bundle adjustment: a modern synthesis", 2000.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from .adjustment import NOISE_SLACK, BundleAdjustment
from .bundle import REGULARISATION, jacobian, levenberg_marquardt
from .clusters import Observations
from .model import ProjectiveKinematics

Array = NDArray[np.float64]
FTOL, MAX_ITER = 1e-5, 100
MAX_CHANGES = 8  # of joints, one after the other: bounds the time
MIN_GAIN = 0.1  # of a change, in variances of the noise: a smaller gain is no evidence; without noise it is rounding
MAX_RAISED = 10.0  # cost above the least, over the variance of the noise: less likely choices by e⁻⁵ do not count
MAX_CHOICES = 4  # of joints that are as likely: each takes an adjustment of both bodies


@dataclass(frozen=True)
class Likely:
    """Kinematics at a minimum."""

    kinematics: ProjectiveKinematics
    cost: float  # px², of the own images
    objective: float  # px², with the prior

    def variance(self, problem: BundleAdjustment) -> float:
        """Variance of an image coordinate, px², by what they leave; the measured noise bounds it from below."""
        return max(self.cost / max(problem.degrees_of_freedom, 1), (problem.noise_px / NOISE_SLACK) ** 2)


def likely_kinematics(kinematics: ProjectiveKinematics, problem: BundleAdjustment) -> list[Likely]:
    """Find the kinematics of maximum likelihood, and those that are nearly as likely.

    Parameters
    ----------
    kinematics : ProjectiveKinematics
        Explain all visits about as well as noise allows.
    problem : BundleAdjustment
        Of all visits, restricted to the points that the kinematics know.

    Returns
    -------
    list of Likely
        The best first. The others are other minima, or one point is moved by one joint more or less. They cost at most
        `MAX_RAISED` variances of the noise more.
    """
    found = [_solved(start, problem) for start in (kinematics, _afresh(kinematics, problem))]
    best = min(found, key=_objective)
    variance = best.variance(problem)
    for _ in range(MAX_CHANGES):
        change = next(_changes(best.kinematics, problem, -MIN_GAIN * variance), None)
        if change is None or not (changed := _solved(change, problem)).objective < best.objective - MIN_GAIN * variance:
            break
        found = [changed, _solved(_afresh(change, problem), problem)]
        best = min(found, key=_objective)
    variance = best.variance(problem)
    changes = _changes(best.kinematics, problem, MAX_RAISED * variance)
    found += [_solved(change, problem) for change in islice(changes, MAX_CHOICES)]
    return sorted((one for one in found if one.objective <= best.objective + MAX_RAISED * variance), key=_objective)


def _objective(one: Likely) -> float:
    return one.objective


def _solved(initial: ProjectiveKinematics, problem: BundleAdjustment) -> Likely:
    prior = problem.prior_weights(len(initial.parameters))
    found = levenberg_marquardt(initial, problem.residuals, prior, FTOL, MAX_ITER)
    cost = float((problem.residuals(found) ** 2).sum())
    return Likely(found, cost, cost + float(prior @ found.parameters**2))


def _afresh(kinematics: ProjectiveKinematics, problem: BundleAdjustment) -> ProjectiveKinematics:
    """Return kinematics with joints that turn nothing, in an affine frame."""
    flat = replace(kinematics, parameters=np.zeros_like(kinematics.parameters))
    return flat.with_points(~kinematics.unknown, problem.observations, problem.coordinates)


def _changes(
    kinematics: ProjectiveKinematics, problem: BundleAdjustment, max_raised: float
) -> Iterator[ProjectiveKinematics]:
    """Yield kinematics in which one joint more or less moves one point, the best predicted first.

    Every joint still moves a point, and joints contradict each other no more often than before.

    max_raised: px², how much more than these kinematics they may cost by the prediction.
    """
    points, raised, placed = predicted_changes(kinematics, problem)
    before = contradictions(kinematics.moved_by)
    for at in np.argsort(raised, axis=None, kind="stable"):
        k, joint = np.unravel_index(at, raised.shape)
        if not raised[k, joint] < max_raised:
            return
        moved_by, positions = kinematics.moved_by.copy(), kinematics.points.copy()
        moved_by[points[k], joint] ^= True
        positions[points[k]] = placed[k, joint]
        if moved_by[points].any(0).all() and contradictions(moved_by) <= before:
            yield replace(kinematics, moved_by=moved_by, points=positions)


def contradictions(moved_by: NDArray[np.bool_]) -> int:
    """Count pairs of joints of which each moves points that the other does not, and some that both do: no tree has any.

    moved_by: (N, m).
    """
    moves = moved_by.astype(int)
    both, alone = moves.T @ moves, moves.T @ ~moved_by
    return int(np.count_nonzero((both > 0) & (alone > 0) & (alone.T > 0)))


def predicted_changes(
    kinematics: ProjectiveKinematics, problem: BundleAdjustment
) -> tuple[NDArray[np.int_], Array, Array]:
    """Predict how much each change of one joint and one point raises the cost.

    Returns the n points that are known, (n,) indices; (n, m) px², inf where fewer than two visits show the point; and
    where the point is placed with the change, (n, m, 3).

    The changed points are added to the body as further ones. That keeps the order of the joints in every chain.
    """
    known, m, P = np.flatnonzero(~kinematics.unknown), kinematics.moved_by.shape[1], len(kinematics.parameters)
    n, copies = len(known), np.concatenate([known, np.repeat(known, m)])
    moved_by = kinematics.moved_by[copies]
    moved_by[n:] ^= np.tile(np.eye(m, dtype=bool), (n, 1))
    seen = problem.observations
    observations = Observations(seen.displacement, seen.images[:, copies], seen.visible_in_both[:, copies])
    coordinates, magnification = problem.coordinates[:, copies], problem.magnification[:, copies]
    extended_problem = replace(problem, observations=observations, coordinates=coordinates, magnification=magnification)
    extended = replace(kinematics, points=kinematics.points[copies], moved_by=moved_by)
    extended = extended.with_points(np.arange(len(copies)) >= n, observations, extended_problem.coordinates)
    A, g, cost = _reduced_normal_equations(extended, extended_problem)
    A, g, cost = (np.concatenate([_sum(x[:n]), _sum(x[:n]) - np.repeat(x[:n], m, 0) + x[n:]]) for x in (A, g, cost))
    prior = problem.prior_weights(P)
    A, g = A + np.diag(prior), g + prior * kinematics.parameters
    A = A + REGULARISATION * np.trace(A, axis1=1, axis2=2)[:, None, None] / P * np.eye(P)
    least = cost - (g * np.linalg.solve(A, g[..., None])[..., 0]).sum(1)
    raised = (least[1:] - least[0]).reshape(n, m)
    raised[seen.visible_in_both[:, known].sum(0) < 2] = np.inf
    return known, raised, extended.points[n:].reshape(n, m, 3)


def _sum(of_points: Array) -> Array:
    return of_points.sum(0, keepdims=True)


def _reduced_normal_equations(
    kinematics: ProjectiveKinematics, problem: BundleAdjustment
) -> tuple[Array, Array, Array]:
    """Each point's share of the quadratic model of the cost, without the point: pᵀAp + 2 gᵀp + c of a step p.

    Returns A (N, P, P), g (N, P) and c (N,).
    """
    residuals, P = problem.residuals(kinematics), len(kinematics.parameters)
    J = np.moveaxis(jacobian(kinematics, problem.residuals, residuals), 2, 0)
    J, e = J.reshape(len(J), P + 3, -1), np.moveaxis(residuals, 1, 0).reshape(len(J), -1, 1)
    products, gradients = J @ J.swapaxes(1, 2), (J @ e)[..., 0]
    A, B, C = products[:, :P, :P], products[:, :P, P:], products[:, P:, P:]
    g, h = gradients[:, :P], gradients[:, P:]
    C = C + REGULARISATION * (np.trace(C, axis1=1, axis2=2) + np.finfo(float).tiny)[:, None, None] * np.eye(3)
    eliminated = np.linalg.solve(C, np.concatenate([B.swapaxes(1, 2), h[..., None]], 2))
    step, point = eliminated[..., :-1], eliminated[..., -1]
    g, c = g - (B @ point[..., None])[..., 0], (e**2).sum((1, 2)) - (h * point).sum(1)
    return A - B @ step, g, c
