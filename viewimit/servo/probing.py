"""A probe: a motion to learn how the images move, not to arrive."""

import numpy as np
from numpy.typing import NDArray

from .observation import Observation

PROBE = np.radians(15.0)


def probe_of(joint: int, seen: Observation) -> NDArray:
    """(m,) rad: one joint turned by 15°, towards where its limits leave more room."""
    above = seen.upper[joint] - seen.displacement[joint]
    below = seen.displacement[joint] - seen.lower[joint]
    step = np.zeros_like(seen.displacement)
    step[joint] = min(PROBE, above) if above >= min(PROBE, below) else -min(PROBE, below)
    return step
