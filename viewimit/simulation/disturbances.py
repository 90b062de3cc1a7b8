"""What spoils a run: images that are noisy, incomplete or wrong, and arms that do not do as they are told.

An entry brings all that is said of a disturbance. Adding one is an entry here and a field of `Settings` that is marked
with it: effect, bounds, option of the command line, slider and caption follow.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

GROSS_PX = 60.0  # a coordinate


@dataclass(frozen=True, kw_only=True)
class Disturbance:
    """bounds: of its amount in `Settings`; unit: of that; says: what an amount is, in a sentence without a full stop;
    caption: the amount in the words of a caption, a format; label, reach, per: of its slider, whose lowest and highest
    value and step are in its own units, of which `per` are one in `Settings`."""

    bounds: tuple[float, float]
    unit: str
    description: str
    caption: str
    label: str
    slider_range: tuple[float, float, float]
    slider_scale: float = 1.0


@dataclass(frozen=True, kw_only=True)
class SightDisturbance(Disturbance):
    """Of what the learner sees."""


@dataclass(frozen=True, kw_only=True)
class ImageDisturbance(SightDisturbance):
    """apply: of an image's points (N, 4) px, which of them are seen (N, 2), an amount, and a generator, the first two.
    It draws the same numbers whatever the amount: turned up it enlarges the same noise and loses the same points
    first."""

    apply: Callable[[NDArray, NDArray, float, np.random.Generator], tuple[NDArray, NDArray]]


@dataclass(frozen=True, kw_only=True)
class MatchDisturbance(SightDisturbance):
    """permute: of N, an amount that is not 0, and a generator, the points that the demonstrator's are taken for: (N,).
    Turned up, it swaps the same ones first."""

    permute: Callable[[int, float, np.random.Generator], NDArray]


@dataclass(frozen=True, kw_only=True)
class ArmDisturbance(Disturbance):
    """drive: of where an arm stands, where it is sent, (m,) rad each, and an amount that is not 0, where it then
    stands."""

    drive: Callable[[NDArray, NDArray, float], NDArray]


def _add_noise(points: NDArray, visible: NDArray, sigma_px: float, rng: np.random.Generator):
    return points + sigma_px * rng.standard_normal(points.shape), visible


def _lose(points: NDArray, visible: NDArray, share: float, rng: np.random.Generator):
    return points, visible & (rng.random(visible.shape) >= share)


def _misplace(points: NDArray, visible: NDArray, share: float, rng: np.random.Generator):
    wrong = np.repeat(rng.random(visible.shape) < share, 2, -1)
    return np.where(wrong, points + rng.uniform(-GROSS_PX, GROSS_PX, points.shape), points), visible


def _swap(count: int, share: float, rng: np.random.Generator) -> NDArray:
    order, pairs = np.arange(count), min(int(np.ceil(share * count / 2 - 1e-9)), count // 2)
    first, second = rng.permutation(count)[: 2 * pairs].reshape(pairs, 2).T
    order[first], order[second] = second, first
    return order


def _overshoot(theta: NDArray, sent: NDArray, share: float) -> NDArray:
    return theta + (1 + share) * (sent - theta)


def _to_steps(theta: NDArray, sent: NDArray, step_deg: float) -> NDArray:
    step = np.radians(step_deg)
    return step * np.round(sent / step)


NOISE = ImageDisturbance(
    bounds=(0, 20),
    unit="px",
    description="noise of every image coordinate, standard deviation",
    caption="noise {:g} px",
    label="Noise px",
    slider_range=(0.0, 2.0, 0.05),
    apply=_add_noise,
)
MISSING = ImageDisturbance(
    bounds=(0, 1),
    unit="share",
    description="points that an image does not show",
    caption="missing {:.0%}",
    label="Missing %",
    slider_range=(0, 50, 1),
    slider_scale=100,
    apply=_lose,
)
OUTLIERS = ImageDisturbance(
    bounds=(0, 1),
    unit="share",
    description="points that are found at a wrong place",
    caption="outliers {:.0%}",
    label="Wrong %",
    slider_range=(0, 30, 1),
    slider_scale=100,
    apply=_misplace,
)
SWAPPED = MatchDisturbance(
    bounds=(0, 1),
    unit="share",
    description="the demonstrator's points that are swapped, in pairs",
    caption="swapped {:.0%}",
    label="Swapped %",
    slider_range=(0, 50, 1),
    slider_scale=100,
    permute=_swap,
)
GAIN_ERROR = ArmDisturbance(
    bounds=(-0.5, 0.5),
    unit="share",
    description="the arm moves by so much more than it is told",
    caption="gain error {:.0%}",
    label="Gain err. %",
    slider_range=(-20, 20, 1),
    slider_scale=100,
    drive=_overshoot,
)
QUANTUM = ArmDisturbance(
    bounds=(0, 5),
    unit="deg",
    description="the arm moves to multiples of this only, or to a limit",
    caption="steps of {:g}°",
    label="Steps °",
    slider_range=(0.0, 2.0, 0.1),
    drive=_to_steps,
)

ImageAmounts = tuple[tuple[ImageDisturbance, float], ...]
MatchAmounts = tuple[tuple[MatchDisturbance, float], ...]
ArmAmounts = tuple[tuple[ArmDisturbance, float], ...]


class ActuatorSettings(Protocol):
    """The part of a run's settings on which the motion of a simulated arm depends."""

    @property
    def start_rad(self) -> NDArray[np.float64]:
        """(m,) posture at which the learner starts [rad]."""
        ...

    def amounts(self, kind: type[ArmDisturbance]) -> ArmAmounts:
        """Every actuation error, with its amount."""
        ...


def any_active(amounts: ImageAmounts | MatchAmounts | ArmAmounts) -> bool:
    return any(amount for _, amount in amounts)


def disturb(amounts: ImageAmounts, points: NDArray, visible: NDArray, seed: Sequence[int]) -> tuple[NDArray, NDArray]:
    """One image of points (N, 4) px, of which visible (N, 2) are seen → the same, spoilt. The seed's stream is drawn
    from in the order of the amounts."""
    if not any_active(amounts):
        return points, visible
    rng = np.random.default_rng(seed)
    for disturbance, amount in amounts:
        points, visible = disturbance.apply(points, visible, amount, rng)
    return points, visible


def disturbed_frames(
    amounts: ImageAmounts, points: NDArray, visible: NDArray, seed: Sequence[int], count: int
) -> tuple[NDArray, NDArray]:
    """Several images of the same: (count, N, 4) px, (count, N, 2)."""
    looks = [disturb(amounts, points, visible, [*seed, k] if k else seed) for k in range(count)]
    return np.array([points for points, _ in looks]), np.array([visible for _, visible in looks])


def mismatch_points(
    amounts: MatchAmounts, points: NDArray, visible: NDArray, seed: Sequence[int]
) -> tuple[NDArray, NDArray]:
    """Images of the demonstrator's points (N, 4) px, of which visible (N, 2) are seen → the same, some taken for
    others."""
    rng = np.random.default_rng(seed)
    for disturbance, amount in amounts:
        if amount:
            order = disturbance.permute(len(points), amount, rng)
            points, visible = points[order], visible[order]
    return points, visible


def drive(amounts: ArmAmounts, theta: NDArray, sent: NDArray) -> NDArray:
    """Where an arm at theta stands after it was sent elsewhere, (m,) rad each."""
    for disturbance, amount in amounts:
        if amount:
            sent = disturbance.drive(theta, sent, amount)
    return sent
