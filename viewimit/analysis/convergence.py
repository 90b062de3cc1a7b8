"""How near a learner comes to the demonstrator: over its history, and from starts all over the range.

This compares with the truth, which is for people and not for a learner.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import msgspec
import numpy as np
from numpy.typing import NDArray

from ..geometry.arrays import Floats
from ..loop.session import Session
from ..loop.settings import Settings
from ..loop.snapshot import Snapshot
from ..simulation.scene import Scene
from .landscape import grid_axes, landscape_over, seen_from

STARTS = 4, 5  # of the two joints
MAX_MOTIONS = 300
NEAR_DEG = 2.0  # a run ends at a posture if its largest joint error to it is at most this
RECENT = 20  # motions over which the rms of a moving demonstrator's errors is taken

Place = Literal["demonstrator", "smallest E", "elsewhere"]


@dataclass(frozen=True)
class Ending:
    """The end of one run."""

    start: Floats  # (2,) rad
    end: Floats  # (2,) rad
    place: Place
    claimed: bool  # whether the servo says that it has converged


@dataclass(frozen=True)
class Basin:
    """The basin of attraction of a transfer and a servo, sampled by runs."""

    starts: Floats  # (k, 2) rad
    endings: tuple[Ending, ...]  # of the runs made so far, in the order of the starts

    def count(self, place: Place, claimed: bool | None = None) -> int:
        """Count the runs that end there; claimed: only those that claim, or do not claim, to have converged."""
        return sum(one.place == place and claimed in (None, one.claimed) for one in self.endings)


def spread_starts(scene: Scene, counts: tuple[int, int] = STARTS) -> Floats:
    """Return the midpoints of equal parts of the range, (k, 2) rad; counts: parts of each joint's range."""
    sides = [low + (np.arange(n) + 0.5) / n * (high - low) for n, low, high in zip(counts, scene.lower, scene.upper)]
    return np.stack(np.meshgrid(*sides, indexing="ij"), -1).reshape(-1, 2)


def find_basin(
    settings: Settings,
    tell: Callable[[float, Basin], None] = lambda share, found: None,
    counts: tuple[int, int] = STARTS,
) -> Basin:
    """Run the settings' servo from starts all over the range; the settings' own start is not used.

    tell(share done, result so far) is called after each run. Raises ValueError unless two joints move.
    """
    session = Session(settings)
    lowest = smallest_E(session)
    found = Basin(spread_starts(session.scene, counts), ())
    for start in found.starts:
        session.begin(msgspec.structs.replace(settings, start_deg=tuple(np.degrees(start).tolist())))
        last = session.run(MAX_MOTIONS, patience=1).last
        ending = Ending(start, last.theta, place_of(last.theta, last.theta_demo, lowest), last.status.is_claim)
        found = Basin(found.starts, (*found.endings, ending))
        tell(len(found.endings) / len(found.starts), found)
    return found


def smallest_E(session: Session) -> Floats:
    """Return the grid posture with the smallest E for the demonstrator as now seen, (2,) rad; NaN if there is none."""
    return landscape_over(*seen_from(session.world, session.snapshot), grid_axes(session.world)).minimum


def place_of(theta: Floats, theta_demo: Floats, lowest: Floats) -> Place:
    """Classify where a run ended; all postures (2,) rad."""
    error = lambda target: np.degrees(np.abs(theta - target)).max()
    if error(theta_demo) <= NEAR_DEG:
        return "demonstrator"
    return "smallest E" if error(lowest) <= NEAR_DEG else "elsewhere"


class ErrorTrace:
    """The largest joint error of every snapshot of a history; only new ones are computed."""

    def __init__(self) -> None:
        self._postures: list[tuple[NDArray, NDArray]] = []  # identify snapshots without keeping them alive
        self._degrees: list[float] = []

    def of(self, history: Sequence[Snapshot]) -> list[float]:
        """Return the errors in degrees. The history changes from its end only, or is another one."""
        kept = min(len(history), len(self._postures))
        while kept and any(a is not b for a, b in zip(self._postures[kept - 1], _postures(history[kept - 1]))):
            kept -= 1
        new = history[kept:]
        self._postures[kept:] = map(_postures, new)
        self._degrees[kept:] = largest_errors_deg(new)
        return self._degrees


def recent_errors_deg(history: Sequence[Snapshot], cursor: int) -> list[float]:
    """Return the largest joint errors of the last RECENT motions up to the cursor, degrees."""
    return largest_errors_deg(history[max(cursor - RECENT, 0) : cursor + 1])


def largest_errors_deg(snapshots: Sequence[Snapshot]) -> list[float]:
    """Return the error of the joint farthest from the demonstrator's in each snapshot, degrees."""
    if not snapshots:
        return []
    theta, theta_demo = zip(*map(_postures, snapshots))
    return np.degrees(np.abs(np.array(theta) - np.array(theta_demo)).max(1)).tolist()


def _postures(moment: Snapshot) -> tuple[NDArray, NDArray]:
    return moment.theta, moment.theta_demo
