"""Disturb a run: noisy, incomplete or wrong images, and arms that do not reach the commanded posture.

Each disturbance is one entry here, with its effect, bounds, texts and slider. To add one, write an entry and mark a
field of `Settings` with it. The option of the command line, the slider and the caption follow.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..geometry.arrays import Floats
from .scene import Scene

OUTLIER_PX = 60.0  # largest error of a misplaced point's coordinate

Visible = NDArray[np.bool_]


@dataclass(frozen=True, kw_only=True)
class Disturbance:
    """Texts and bounds of a disturbance, whose amount is a field of `Settings`."""

    bounds: tuple[float, float]  # of the amount
    unit: str  # of the amount
    description: str  # what the amount is, a sentence without a full stop
    caption: str  # format of the amount in a caption
    label: str  # of the slider
    slider_range: tuple[float, float, float]  # lowest and highest value, and step
    slider_scale: float = 1.0  # slider value over amount


@dataclass(frozen=True, kw_only=True)
class SightDisturbance(Disturbance):
    """Disturbs what the learner sees."""


@dataclass(frozen=True, kw_only=True)
class ImageDisturbance(SightDisturbance):
    """Disturbs the points of one image.

    It draws the same random numbers for every amount. A larger amount enlarges the same noise, and loses the same
    points first.
    """

    # (points (N, 4) px, visible (N, 2), amount, generator) -> points, visible
    apply: Callable[[Floats, Visible, float, np.random.Generator], tuple[Floats, Visible]]


@dataclass(frozen=True, kw_only=True)
class MatchDisturbance(SightDisturbance):
    """Mixes up the demonstrator's points. A larger amount swaps the same ones first."""

    permute: Callable[[int, float, np.random.Generator], NDArray[np.int_]]  # (N, amount > 0, generator) -> order (N,)


@dataclass(frozen=True, kw_only=True)
class ArmDisturbance(Disturbance):
    """Makes an arm miss the commanded posture."""

    # (posture (m,) rad, commanded posture (m,) rad, amount != 0) -> posture reached (m,) rad
    drive: Callable[[Floats, Floats, float], Floats]


def _add_noise(points: Floats, visible: Visible, sigma_px: float, rng: np.random.Generator) -> tuple[Floats, Visible]:
    return points + sigma_px * rng.standard_normal(points.shape), visible


def _lose(points: Floats, visible: Visible, share: float, rng: np.random.Generator) -> tuple[Floats, Visible]:
    return points, visible & (rng.random(visible.shape) >= share)


def _misplace(points: Floats, visible: Visible, share: float, rng: np.random.Generator) -> tuple[Floats, Visible]:
    wrong = np.repeat(rng.random(visible.shape) < share, 2, -1)
    return np.where(wrong, points + rng.uniform(-OUTLIER_PX, OUTLIER_PX, points.shape), points), visible


def _swap(count: int, share: float, rng: np.random.Generator) -> NDArray[np.int_]:
    order, pairs = np.arange(count), min(int(np.ceil(share * count / 2 - 1e-9)), count // 2)
    first, second = rng.permutation(count)[: 2 * pairs].reshape(pairs, 2).T
    order[first], order[second] = second, first
    return order


def _overshoot(theta: Floats, commanded: Floats, share: float) -> Floats:
    return theta + (1 + share) * (commanded - theta)


def _quantise(theta: Floats, commanded: Floats, step_deg: float) -> Floats:
    step = np.radians(step_deg)
    return step * np.round(commanded / step)


NOISE = ImageDisturbance(
    bounds=(0, 20),
    unit="px",
    description="noise of every image coordinate, standard deviation",
    caption="noise {:g} px",
    label="Pixel noise (px)",
    slider_range=(0.0, 2.0, 0.05),
    apply=_add_noise,
)
MISSING = ImageDisturbance(
    bounds=(0, 1),
    unit="share",
    description="probability that an image does not show a point",
    caption="missing {:.0%}",
    label="Points lost (%)",
    slider_range=(0, 50, 1),
    slider_scale=100,
    apply=_lose,
)
OUTLIERS = ImageDisturbance(
    bounds=(0, 1),
    unit="share",
    description="probability that a point is found at a wrong place",
    caption="outliers {:.0%}",
    label="Points misplaced (%)",
    slider_range=(0, 30, 1),
    slider_scale=100,
    apply=_misplace,
)
SWAPPED = MatchDisturbance(
    bounds=(0, 1),
    unit="share",
    description="fraction of the demonstrator's points that are swapped, in pairs",
    caption="swapped {:.0%}",
    label="Points mixed up (%)",
    slider_range=(0, 50, 1),
    slider_scale=100,
    permute=_swap,
)
GAIN_ERROR = ArmDisturbance(
    bounds=(-0.5, 0.5),
    unit="share",
    description="relative actuation error: the arm moves farther than commanded by this fraction",
    caption="gain error {:.0%}",
    label="Arm overshoot (%)",
    slider_range=(-20, 20, 1),
    slider_scale=100,
    drive=_overshoot,
)
QUANTUM = ArmDisturbance(
    bounds=(0, 5),
    unit="deg",
    description="the arm moves to multiples of this only, or to a limit",
    caption="steps of {:g}°",
    label="Arm resolution (°)",
    slider_range=(0.0, 2.0, 0.1),
    drive=_quantise,
)

ImageAmounts = tuple[tuple[ImageDisturbance, float], ...]
MatchAmounts = tuple[tuple[MatchDisturbance, float], ...]
ArmAmounts = tuple[tuple[ArmDisturbance, float], ...]


def any_active(amounts: ImageAmounts | MatchAmounts | ArmAmounts) -> bool:
    """Return whether some amount is not 0."""
    return any(amount for __, amount in amounts)


def disturb(amounts: ImageAmounts, points: Floats, visible: Visible, seed: Sequence[int]) -> tuple[Floats, Visible]:
    """Disturb one image.

    amounts: disturbances, which draw from one random stream in this order; points, visible: (N, 4) px and (N, 2); seed:
    of the stream.
    """
    if not any_active(amounts):
        return points, visible
    rng = np.random.default_rng(seed)
    for disturbance, amount in amounts:
        points, visible = disturbance.apply(points, visible, amount, rng)
    return points, visible


def disturbed_frames(
    amounts: ImageAmounts, points: Floats, visible: Visible, seed: Sequence[int], count: int
) -> tuple[Floats, Visible]:
    """Return several disturbed images of the same points, (count, N, 4) px and (count, N, 2)."""
    looks = [disturb(amounts, points, visible, [*seed, k] if k else seed) for k in range(count)]
    return np.array([points for points, __ in looks]), np.array([visible for __, visible in looks])


def mismatch_points(
    amounts: MatchAmounts, points: Floats, visible: Visible, seed: Sequence[int]
) -> tuple[Floats, Visible]:
    """Mix up the demonstrator's points, (N, 4) px and (N, 2)."""
    rng = np.random.default_rng(seed)
    for disturbance, amount in amounts:
        if amount:
            order = disturbance.permute(len(points), amount, rng)
            points, visible = points[order], visible[order]
    return points, visible


def drive(amounts: ArmAmounts, theta: Floats, commanded: Floats) -> Floats:
    """Return the posture that an arm at theta reaches when it is commanded to another one, (m,) rad each."""
    for disturbance, amount in amounts:
        if amount:
            commanded = disturbance.drive(theta, commanded, amount)
    return commanded


class SimulatedArm:
    """An arm of m moving joints. This one reaches what the disturbances leave of a command; others extend it."""

    def __init__(self, scene: Scene):
        self._scene = scene

    def settle(self, theta: Floats) -> Floats:
        """Return the posture at which the arm comes to rest when it is placed at theta, (m,) rad each."""
        return theta

    def drive(self, amounts: ArmAmounts, start: Floats, theta: Floats, sent: Floats, commanded: Floats) -> Floats:
        """Return the posture that the arm reaches for a new command, (m,) rad each.

        start: where the run began; theta, sent: present posture, and the last command.
        """
        if not any_active(amounts):
            return commanded
        return np.clip(drive(amounts, theta, theta + (commanded - sent)), self._scene.lower, self._scene.upper)
