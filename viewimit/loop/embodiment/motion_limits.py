"""How far the learner's arm may be sent, and how far at once: the workspace and the longest motion of `Settings`."""

import numpy as np
from numpy.typing import NDArray

from ..settings import Settings

ROUNDING_DEG = 1e-6
ROUNDING = 1e-9  # of a motion's length: what sums of motions are off by


def workspace(settings: Settings, lower: NDArray, upper: NDArray) -> tuple[NDArray, NDArray]:
    """The lowest and the highest angle to which each joint may be sent, (m,) rad each.

    lower, upper: (m,) rad, the arm's own limits, which are the workspace where the settings give none. Raises
    ValueError for a workspace of another number of joints, or one that is not inside these limits.
    """
    if settings.workspace_deg is None:
        return lower, upper
    if len(settings.workspace_deg) != len(lower):
        raise ValueError(
            f"workspace_deg needs a range for each of the {len(lower)} moving joints, got {len(settings.workspace_deg)}"
        )
    limits_deg = np.degrees([lower, upper]).T
    for k, ((low, high), (least, most)) in enumerate(zip(settings.workspace_deg, limits_deg), 1):
        if low < least - ROUNDING_DEG or high > most + ROUNDING_DEG:
            raise ValueError(
                f"workspace_deg: range {k}, {low:g}° … {high:g}°, is not inside its joint's limits "
                f"{least:g}° … {most:g}°"
            )
    low, high = np.radians(settings.workspace_deg).T
    return np.maximum(low, lower), np.minimum(high, upper)


def within(theta: NDArray, low: NDArray, high: NDArray, whose: str) -> NDArray:
    """A posture in the workspace [low, high], (m,) rad each. Raises ValueError for one that is outside."""
    for k, (angle, least, most) in enumerate(zip(*map(np.degrees, (theta, low, high))), 1):
        if not least - ROUNDING_DEG <= angle <= most + ROUNDING_DEG:
            raise ValueError(
                f"{whose} posture is outside the workspace: angle {k} is {angle:g}°, the range {least:g}° … {most:g}°"
            )
    return np.clip(theta, low, high)


def waypoints(sent: NDArray, target: NDArray, longest: float) -> list[NDArray]:
    """Postures on the straight way from `sent` to the target, (m,) rad each, which is the last of them.

    longest: rad, which no joint turns by more from one of them to the next; inf for the target alone.
    """
    way = target - sent
    motions = max(int(np.ceil(np.abs(way).max() / longest - ROUNDING)), 1)
    return [*(sent + way * (k / motions) for k in range(1, motions)), target]
