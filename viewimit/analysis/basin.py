"""The basin of a transfer and a servo: from where the learner arrives, and where else it says that it has.

Runs of sessions from starts all over the range; where they end is for people, who know where the demonstrator stands.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import msgspec
import numpy as np
from numpy.typing import NDArray

from ..loop.session import Session
from ..loop.settings import Settings
from ..simulation.scene import Scene
from .landscape import grid_axes, landscape_over

STARTS = 4, 5  # of the two joints
MOST_MOTIONS = 300
NEAR_DEG = 2.0  # largest joint error with which a run ends at a posture

Place = Literal["demonstrator", "smallest E", "elsewhere"]


@dataclass(frozen=True)
class Ending:
    """Of one run. start, end: (2,) rad; claimed: the servo says that it has converged."""

    start: NDArray
    end: NDArray
    place: Place
    claimed: bool


@dataclass(frozen=True)
class Basin:
    """starts: (k, 2) rad; endings: of the runs that are made, in this order."""

    starts: NDArray
    endings: tuple[Ending, ...]

    def count(self, place: Place, claimed: bool | None = None) -> int:
        """Runs that end there, or those of them that claim to have arrived or do not."""
        return sum(one.place == place and claimed in (None, one.claimed) for one in self.endings)


def spread_starts(scene: Scene, counts: tuple[int, int] = STARTS) -> NDArray:
    """(k, 2) rad: in the middles of as many equal parts of the range."""
    sides = [low + (np.arange(n) + 0.5) / n * (high - low) for n, low, high in zip(counts, scene.lower, scene.upper)]
    return np.stack(np.meshgrid(*sides, indexing="ij"), -1).reshape(-1, 2)


def find_basin(
    settings: Settings,
    tell: Callable[[float, Basin], None] = lambda share, found: None,
    counts: tuple[int, int] = STARTS,
) -> Basin:
    """Of the settings, whatever start they have. tell(share done, what is found so far), once a run.

    Raises ValueError unless two joints move.
    """
    session = Session(settings)
    lowest = smallest_E(session)
    found = Basin(spread_starts(session.scene, counts), ())
    for start in found.starts:
        session.begin(msgspec.structs.replace(settings, start_deg=tuple(np.degrees(start).tolist())))
        last = session.run(MOST_MOTIONS, patience=1).last
        place = place_of(last.theta, last.theta_demo, lowest)
        ending = Ending(start, last.theta, place, last.status.is_claim)
        found = Basin(found.starts, (*found.endings, ending))
        tell(len(found.endings) / len(found.starts), found)
    return found


def smallest_E(session: Session) -> NDArray:
    """(2,) rad, of the transfer around the demonstrator as now seen; NaN if too few points are."""
    views, world = session.snapshot.views, session.world
    return landscape_over(world, session.snapshot.fit, views.demo, views.visible[:, :2], grid_axes(world)).minimum


def place_of(theta: NDArray, theta_demo: NDArray, lowest: NDArray) -> Place:
    """Where a run ends that ends at theta; (2,) rad each."""
    off = lambda place: np.degrees(np.abs(theta - place)).max()
    return "demonstrator" if off(theta_demo) <= NEAR_DEG else "smallest E" if off(lowest) <= NEAR_DEG else "elsewhere"
