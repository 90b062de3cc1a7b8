"""What a servo may claim of the posture in which it rests: measured evidence that E rises in every direction from it.

A small E is none: a joint that no point tells leaves E flat, and the predictions' own errors look like a curvature.
About the best posture b E ≈ E_b + ½ dᵀHd, d = θ - b, H as predicted. For each eigenvector v of H, the flattest first, a
posture really visited is evidence if v makes most of the rise that is predicted there, and at least RISEN of v's own
was measured beyond what the others should make: more than noise makes or, without noise, than the share CONFLICTING of
what the own images moved by. Where there is none a check motion along v asks; if E does not rise as it should, v is
unobservable, and so is each joint that it turns. Of too few points E is next to 0 and rises all around at wrong
postures as well: they allow no claim. Nor has a point a part in H that was seen too rarely to tell how its images move:
what is not known of that looks like a curvature.

How far off each joint may be follows from H by s²H⁻¹/N, s² the noise of the images or what is left of E, if more, and
by H⁻¹g, g the gradients that the noise of the own images makes, and those that another head would, as far as matches
do not tell its fundamental matrix. Of H is taken off what such noise adds to it.
"""

from dataclasses import dataclass, replace
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from ...geometry.kinematics.adjustment import PREDICTION_TOL_PX
from ..status import ServoStatus
from .local_model import UNTOLD, Surroundings, enough_points

LEAST, NEAR = np.radians((1.0, 25.0))  # along a direction, and away from the best, of visits that are evidence
CHECK, NOISY_CHECK = np.radians((2.0, 8.0))  # lengths of check motions
NOISY_LEAST, NOISY_NEAR = np.radians((5.5, 15.0))  # where the slopes of the images must be told from their noise
OWN_SHARE, RISEN = 0.6, 0.5  # of a predicted rise: what must be the direction's own, what of that must be measured
ALIGNED = 0.95  # of its length: what must be along a direction, for a visit to have asked about that at least
CONFLICTING = 1e-4  # of the squared motion of the own images: what must be left as conflict
SURELY = 3.0  # standard deviations
LEAST_CURVATURE = 1e-100  # px²/rad²: keeps squares of what a level E allows finite
PART = 0.1  # of a direction of length 1: a joint that has less is not turned by it
EQUAL = 1e-6  # of such a direction's parts, and rad: what differs by less may do so by rounding


@dataclass(frozen=True)
class Certificate:
    """spread: (m,) rad/px, what a pixel of noise turns each joint by; expected: (m,) rad, standard deviations of the
    joint errors, inf of joints that are not told; told: (m,) bool; shown: whether E was seen to rise along every
    direction; check: (m,) rad, a motion that would show more, all 0 if there is none to make; spent: whether E is as
    small as where nothing is told; learnable: whether points that were seen rarely, or noise that is not averaged yet,
    hide what should be told; untried: whether no visit went in some direction. A check may be worth making though all
    is shown: where slopes are told badly."""

    spread: NDArray
    expected: NDArray
    told: NDArray
    shown: bool
    check: NDArray
    spent: bool
    learnable: bool = False
    untried: bool = False

    def per_pixel(self, unit_px: float) -> "Certificate":
        """Return the same, made in units of so many pixels, with its spread per pixel."""
        return replace(self, spread=self.spread / unit_px)

    @property
    def claim(self) -> ServoStatus:
        """The status in which a servo may rest where E is small."""
        if not self.told.all():
            return ServoStatus.UNOBSERVABLE
        return ServoStatus.CONVERGED if self.shown else ServoStatus.SETTLED

    @property
    def lost(self) -> bool:
        """Whether nothing tells some joint, though E is small."""
        return self.spent and not self.told.all()

    @property
    def worst(self) -> float:
        """rad: twice this holds the largest joint error as often as twice `expected` holds each (Šidák 1967)."""
        each, together = NormalDist(), 2 * NormalDist().cdf(2.0) - 1
        surely = each.inv_cdf((1 + together ** (1 / len(self.expected))) / 2)
        return float(self.expected.max() * surely / 2)

    @property
    def untold(self) -> list[int]:
        """Indices of the joints that nothing tells, the worst first."""
        return [int(j) for j in np.argsort(-self.spread, kind="stable") if not self.told[j]]

    def named(self, status: ServoStatus) -> list[int]:
        """Of these, those that may be named where a servo rests: none, unless it names them itself, if only the visits
        leave them open."""
        return self.untold if status == ServoStatus.UNOBSERVABLE or not (self.learnable or self.untried) else []


def certify(here: Surroundings) -> Certificate:
    """From the visits that there are."""
    inverse = _inverse(here.hessian)
    spread = _spread(inverse, here.points)
    told, check, again = spread < UNTOLD, np.zeros(len(spread)), np.zeros(len(spread))
    shown = here.seen >= enough_points(len(spread))
    for direction in _directions(here):
        risen, level = _evidence(here, direction)
        shown = shown and risen and not _untold(here, direction)
        if level and not risen:
            told = told & (np.abs(direction) <= PART)
        elif not risen or _unclear(here, direction):
            check = check if check.any() else _length(here, direction) * direction
        elif _hides_more(here, direction, here.gradients, here.by_slopes):
            again = again if again.any() else NOISY_NEAR * direction  # what is far tells slopes best
    noise = max(here.noise_px, PREDICTION_TOL_PX, np.sqrt(2 * here.points * here.E / here.freedom))
    spent = here.E < CONFLICTING * 0.5 * UNTOLD**2 * np.trace(here.slopes)
    variance = (noise * spread) ** 2 + here.left**2 + _of_own_noise(here, inverse) + _of_the_head(here, inverse)
    expected = np.where(told, np.sqrt(variance), np.inf)
    learnable = not told.all() and bool((deviations(here.foreseen, here.points) < UNTOLD).all())
    untried = bool(np.linalg.norm(here.away @ np.linalg.eigh(here.away.T @ here.away)[1][:, 0]) < LEAST)
    check = check if check.any() else again
    return Certificate(spread, expected, told, shown, check, bool(spent), learnable, untried)


def deviations(hessian: NDArray, points: int) -> NDArray:
    """(m,) rad/px: standard deviations that residuals with noise of 1 px leave to each joint, √diag((JᵀJ)⁻¹)."""
    return _spread(_inverse(hessian), points)


def curvature_directions(hessian: NDArray) -> NDArray:
    """(m, m): its eigenvectors of length 1 as columns, the flattest first. Either sign would do: the joint that turns
    most turns forwards, of those that turn as far the first."""
    directions = np.linalg.eigh(hessian)[1]
    parts = np.abs(directions)
    leading = (parts >= parts.max(0) - EQUAL).argmax(0)
    return directions * np.copysign(1.0, directions[leading, range(len(leading))])


def _spread(inverse: NDArray, points: int) -> NDArray:
    """As `deviations`, of the inverse of a hessian."""
    return np.sqrt(np.diag(inverse) / points)


def _inverse(hessian: NDArray) -> NDArray:
    """Of a matrix that may have no curvature in some directions: (m, m)."""
    curvatures, directions = np.linalg.eigh(hessian)
    least = max(1e-12 * curvatures[-1], LEAST_CURVATURE)
    return (directions / np.maximum(curvatures, least)) @ directions.T


def _of_the_head(here: Surroundings, inverse: NDArray) -> NDArray:
    """(m,) rad², variances: how far what is not known of the head moves it. inverse: of the hessian."""
    return ((here.head @ inverse) ** 2).sum(0)


def _of_own_noise(here: Surroundings, inverse: NDArray) -> NDArray:
    """(m,) rad², variances: how far the noise of the own images moves the place where E is least."""
    return sum(((gradients @ inverse) ** 2).mean(0) for gradients in (here.gradients, here.by_slopes))


def _unclear(here: Surroundings, v: NDArray) -> bool:
    """Whether the noise of the own images hides more of a displacement along v than that of the demonstrator's does, or
    as much as tells nothing."""
    return _untold(here, v) or _hides_more(here, v, here.gradients)


def _untold(here: Surroundings, v: NDArray) -> bool:
    """Whether the points tell nothing of a displacement along v, where there is noise."""
    nothing = here.points * max(v @ here.hessian @ v, LEAST_CURVATURE) * UNTOLD**2 < 1
    return bool(here.noise_px > 0 and nothing)


def _hides_more(here: Surroundings, v: NDArray, *gradients: NDArray) -> bool:
    """Whether what makes these gradients, (k, m) px²/rad each, and further postures average, hides more of a
    displacement along v than the noise of the demonstrator's images does."""
    if here.noise_px == 0:
        return False
    curvature = max(v @ here.hessian @ v, LEAST_CURVATURE)
    own = sum(((one @ v) ** 2).mean() for one in gradients) / curvature**2
    return bool(own > here.noise_px**2 / (here.points * curvature))


def _directions(here: Surroundings) -> list[NDArray]:
    """(m,) each of length 1: the eigenvectors, the flattest first; one that the limits bar both ways is replaced by
    what they leave of both."""
    found = []
    for v in curvature_directions(here.hessian).T:
        ways = [way.clip(here.low, here.high) for way in (CHECK * v, -CHECK * v)]
        free = [way for way in ways if np.linalg.norm(way) > 0.99 * CHECK]
        found += [v] if free else [way / np.linalg.norm(way) for way in ways if np.linalg.norm(way) > LEAST]
    return found


def _evidence(here: Surroundings, v: NDArray) -> tuple[bool, bool]:
    """Whether a visit has shown E to rise along v, and whether one has shown that it does not."""
    along = here.away @ v
    predicted = 0.5 * np.einsum("ka,kab,kb->k", here.away, here.hessians, here.away)
    own = 0.5 * along**2 * (here.hessians @ v @ v)
    across = here.away - along[:, None] * v
    apart = own + 0.5 * np.einsum("ka,kab,kb->k", across, here.hessians, across)  # of fewer points v is no eigenvector
    mostly = own >= OWN_SHARE * np.maximum(predicted, apart)
    fully = own >= 0.5 * (0.5 * along**2 * (v @ here.whole @ v))  # by as many points, nearly, as there are
    aligned = np.abs(along) >= ALIGNED * np.linalg.norm(here.away, axis=-1)
    least, most = (LEAST, NEAR) if here.noise_px == 0 else (NOISY_LEAST, NOISY_NEAR)
    near = (np.abs(along) >= least) & (np.abs(here.away).max(-1) <= most) & np.isfinite(here.rise)
    seen = _noise_of_rise(here)
    if here.noise_px == 0:
        seen = 0.5 * CONFLICTING * along**2 * (v @ here.slopes @ v)
    risen = near & mostly & (here.rise >= np.maximum(predicted - (1 - RISEN) * np.minimum(own, predicted), seen))
    level = near & aligned & fully & (here.rise < seen) & (RISEN * predicted >= _noise_of_rise(here))
    return bool(risen.any()), bool(level.any())


def _length(here: Surroundings, v: NDArray) -> float:
    """rad, of a check motion along v; 0 if noise would hide the rise, and one as long as may be has been made."""
    if here.noise_px == 0:
        return float(CHECK)
    along = here.away @ v
    needed = 1.1 * np.sqrt(2 * _noise_of_rise(here) / (RISEN * max(v @ here.whole @ v, 1e-12)))
    made = (np.abs(along) >= NOISY_NEAR / 2) & (np.abs(here.away).max(-1) <= 2 * NOISY_NEAR)
    if needed > NOISY_NEAR and made.any() and not _unclear(here, v):
        return 0.0
    return float(np.clip(needed, NOISY_CHECK, NOISY_NEAR))


def _noise_of_rise(here: Surroundings) -> float:
    """px²: a rise that noise makes by itself, but hardly ever."""
    return SURELY * here.noise_px**2 * float(np.sqrt(here.freedom)) / here.points
