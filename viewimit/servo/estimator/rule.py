"""The one rule: of all that the arm may do next, do what leaves the least loss, its cost included.

    loss(ε) = ε + claim_worth · Φ(log(ε / max_claimed_error) / error_spread)
    cost(way) = price_per_motion · motions + price_per_radian · length

ε is the expected error of the worst joint, and Φ(…) the probability that no claim follows. The arm may stay
(ε = √(offset² + standard error²)), go to the estimate, or look n times from about some place first. Images from there
add their information to that of all images so far, so what they leave of ε is known before the motion. With n up to 8
the rule sees beyond the next motion. Prices are in radians of error.

While no hypothesis fits, no claim can follow: `claim_worth` is added, times 2^(-n · d) for n looks at a distance d from
all visits, in shares of `farthest`. A look that far has an even chance to show why nothing fits.
"""

from dataclasses import dataclass
from math import erf

import numpy as np
from numpy.typing import NDArray

from ...geometry.kinematics.adjustment import BundleAdjustment
from ...geometry.kinematics.bundle import jacobian, normal_equations
from ...geometry.kinematics.clusters import Observations
from ...geometry.kinematics.own_body import OwnBody
from ...geometry.kinematics.two_bodies import BodyPair
from ..observation import Observation
from .hypotheses import Estimate
from .options import EstimatorOptions

Array = NDArray[np.float64]
ON_WAY = 0.5, 0.75  # shares of the way to the estimate, at which to look
ABOUT, ANYWHERE = (12, 24), 24  # random places: about the estimate, of up to two joints or more; in the whole range
SIGNS = 1.0, -1.0, 0.3, -0.3  # of the motions of each joint about the estimate
FD_STEP, ROUNDING = 1e-4, 1e-9  # rad: of a difference; of what counts as equal


@dataclass(frozen=True)
class Choice:
    """What to do next."""

    place: Array | None = None  # (m,) rad, where to go; None: stay
    explores: bool = False  # whether to look from there, before going to the estimate


def loss(error: Array, options: EstimatorOptions) -> Array:
    """Loss of an expected error, (...) rad → (...) rad."""
    z = np.log(np.maximum(error, 1e-12) / options.max_claimed_error) / options.error_spread
    return error + options.claim_worth * 0.5 * (1 + np.vectorize(erf)(z / np.sqrt(2)))


def cost(way: Array, max_step: float, options: EstimatorOptions, looks: int = 1) -> Array:
    """Cost of one way, (..., m) rad, and of further looks about its end: (...) rad."""
    length = np.abs(way).max(-1)
    one = options.price_per_motion * np.maximum(np.ceil(length / max_step - 1e-6), 1)
    further = options.price_per_motion * max(np.ceil(options.next_look / max_step), 1)
    further = further + options.price_per_radian * options.next_look
    return np.asarray(one + options.price_per_radian * length + (looks - 1) * further)


def choose(
    best: Estimate,
    body: OwnBody,
    see: Observation,
    target: Array,
    options: EstimatorOptions,
    may_explore: bool,
    unexplained: bool = False,
) -> Choice:
    """Return the choice with the least loss.

    target: (m,) rad, the estimate within the limits; may_explore: whether looks elsewhere are left; unexplained:
    whether no hypothesis fits.
    """
    here, max_step = body.here, see.max_step
    end = lambda std: loss(np.hypot(std, body.slack), options)  # where a loose arm ends is as uncertain as the arm
    stay = loss(np.hypot(best.std, np.abs(target - here)).max(), options)
    go = end(best.std.max()) + cost(target - here, max_step, options)
    found, least = (Choice(), stay) if stay <= go else (Choice(target), go)
    if not may_explore or best.fit is None:
        return found
    doubt = options.claim_worth * unexplained
    least = least + doubt
    places, novelty = candidates(body, see, target, options, unexplained)
    information = Information.of(best, body, places)
    for looks in options.looks:
        way = cost(places - here, max_step, options, looks) + cost(target - places, max_step, options)
        value = end(information.std(looks)) + doubt * 0.5 ** (looks * novelty) + way
        if value.min() < least - ROUNDING:
            found, least = Choice(places[first_largest(-value)], True), value.min()
    return found


def first_largest(values: Array) -> int:
    """Index of the largest value, of nearly equal ones the first: rounding errors decide no motion."""
    return int((values >= values.max() - ROUNDING).argmax())


def candidates(
    body: OwnBody, see: Observation, target: Array, options: EstimatorOptions, everywhere: bool
) -> tuple[Array, Array]:
    """Postures to look from, (c, m) rad, about the target and on the way, or everywhere.

    Also how far each is from all visits, (c,), in `EstimatorOptions.farthest`, at most 1.
    """
    here, m = body.here, len(target)
    rng = np.random.default_rng([see.seed, see.motion, m])
    signs = rng.choice(SIGNS, (ABOUT[m > 2], m))
    on_way = here + np.array(ON_WAY)[:, None] * (target - here)
    anywhere = rng.uniform(see.lower, see.upper, (ANYWHERE if everywhere else 0, m))
    places = np.concatenate([*(target + length * signs for length in options.lengths), on_way, anywhere])
    places = np.clip(places, see.lower, see.upper)
    away = np.abs(places[:, None] - body.seen.displacement).max(-1).min(1)
    new = away > min(options.nearest, away.max() - 1e-12)
    return places[new], np.minimum(away[new] / options.farthest, 1.0)


@dataclass(frozen=True)
class Information:
    """Normal equations, as of `bundle.normal_equations`: of all images so far, and of one own image from each place."""

    so_far: tuple[Array, Array, Array]  # A (P, P) with the prior, B (N, P, 3), C (N, 3, 3)
    each: tuple[Array, Array, Array]  # the same with a leading axis of places
    angles: slice  # of the demonstrator, among the parameters
    std_px: float  # of the noise, times what rivals add

    @classmethod
    def of(cls, best: Estimate, body: OwnBody, places: Array) -> "Information":
        """One Jacobian for all places: a point is seen there if it was at the nearest visit."""
        assert best.fit is not None and best.adjustment is not None
        pair, problem, seen = best.fit.pair, best.adjustment.problem, body.seen
        P = len(pair.parameters)
        A, B, C = normal_equations(jacobian(pair, problem.residuals, problem.residuals(pair)), P)
        nearest = np.abs(places[:, None] - seen.displacement).max(-1).argmin(1)
        visible = seen.visible_in_both[nearest] & ~pair.kinematics.unknown
        blank = Observations(places, np.zeros((*visible.shape, 4)), visible)
        enlarged = pair.body.magnification(pair.body.predict(places))
        looks = BundleAdjustment(blank, np.zeros((*visible.shape, 3)), 1.0, enlarged)

        def shown_by(model: BodyPair) -> Array:
            return looks.residuals(model.body)

        shown = shown_by(pair)
        J = np.moveaxis(jacobian(pair, shown_by, shown), 0, -2)  # (c, N, P + 3, 3)
        products = J @ J.swapaxes(-1, -2)
        if body.slack:  # the offset of a loose arm hides a part: it counts as noise
            turned = [looks.residuals(pair.body, places + FD_STEP * joint) - shown for joint in np.eye(places.shape[1])]
            spread = (body.slack / FD_STEP) ** 2 * np.square(turned).sum(0).mean((1, 2))
            products = products / (1 + spread / best.fit.std**2)[:, None, None, None]
        each = products[..., :P, :P].sum(1), products[..., :P, P:], products[..., P:, P:]
        so_far = A + np.diag(problem.prior_weights(pair)), B, C
        return cls(so_far, each, pair.angle_slice, best.fit.std * best.rivalry)

    def std(self, looks: int) -> Array:
        """Standard error of the worst joint, (c,) rad, after so many looks from each place."""
        A, B, C = (now + looks * more for now, more in zip(self.so_far, self.each))
        schur = A - np.einsum("cnpa,cnab,cnqb->cpq", B, np.linalg.pinv(C, hermitian=True), B, optimize=True)
        size = np.sqrt(np.maximum(np.einsum("cpp->cp", schur), 1e-100))
        inverse = np.linalg.inv(schur / (size[:, :, None] * size[:, None, :]) + 1e-12 * np.eye(schur.shape[-1]))
        variance = (np.einsum("cpp->cp", inverse) / size**2)[:, self.angles]
        return self.std_px * np.sqrt(np.maximum(variance, 0)).max(1)
