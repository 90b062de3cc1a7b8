"""What one transfer makes of a demonstrator: E over all postures, its minima, their bias."""

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ..loop.snapshot import Snapshot
from ..simulation.world import World
from .landscape import Landscape, conflict_at, grid_axes, landscape_over
from .minima import Minima, local_minima


@dataclass(frozen=True)
class Studied:
    """E of one transfer over the postures. minima: between the grid's points; basin: share of the postures from which
    descent ends at the lowest; bias_deg: (2,), of that from the demonstrator's posture, NaN without a minimum."""

    transfer: str
    landscape: Landscape
    minima: Minima
    basin: float
    bias_deg: NDArray


def study(world: World, snapshot: Snapshot, transfer: str) -> Studied:
    """Around the demonstrator as the learner has seen it; two joints must move. Takes about 0.1 s."""
    views, fit = snapshot.views, partial(snapshot.fit, by=transfer)
    demo, visible = views.demo, views.visible[:, :2]
    found = landscape_over(world, fit, demo, visible, grid_axes(world))
    minima = local_minima(found, lambda theta: conflict_at(world, fit, demo, visible, theta)[0])
    bias = np.degrees(minima.theta[0] - snapshot.theta_demo) if len(minima) else np.full(2, np.nan)
    return Studied(transfer, found, minima, found.basin_fraction(), bias)
