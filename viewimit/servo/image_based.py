"""Image-based servoing: the displacement that brings the own image points to where they should be.

Feedback on images alone (the paper's Section 5.4): the image Jacobian is the one learned so far, and every motion goes
on improving it.
"""

import numpy as np
from numpy.typing import NDArray

from .image_model import ImageModel
from .observation import Observation, by_coordinate

LONGEST = np.radians(10.0)  # a joint and motion
DAMPING = 1e-6  # of the normal equations, relative to their trace: what the images cannot tell is left alone


def towards(model: ImageModel, seen: Observation, target: NDArray, wanted: NDArray) -> NDArray:
    """(m,) rad, by least squares over the points wanted and seen; within the limits, and no longer than one motion may
    be.

    target: (N, 4) px in [L, R]; wanted: (N,) bool. model: what was learned up to and with `seen`.
    """
    count = by_coordinate(seen.seen) & wanted[:, None] & np.isfinite(target)
    J, missing = model.jacobian[count], (target - seen.own)[count]
    normal = J.T @ J
    normal = normal + np.eye(len(normal)) * (DAMPING * np.trace(normal) + 1e-12)
    step = np.linalg.solve(normal, J.T @ missing)
    step *= min(1.0, min(LONGEST, seen.max_step) / max(np.max(np.abs(step)), 1e-12))
    return np.clip(step, seen.lower - seen.displacement, seen.upper - seen.displacement)
