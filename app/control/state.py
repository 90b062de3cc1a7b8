"""What a page shows at one moment. Panels read it and change nothing."""

from collections.abc import Mapping
from dataclasses import dataclass

from numpy.typing import NDArray

from viewimit.session import Session
from viewimit.settings import Settings
from viewimit.snapshot import Snapshot

from ..jobs.landscapes import MadeLandscape
from .duel import Duel
from .experiments import Experiments
from .motions import Motions
from .presets import Preset
from .view import View


@dataclass(frozen=True)
class Message:
    """until: s of the scheduler's clock"""

    text: str
    until: float


@dataclass(frozen=True, eq=False)
class PageState:
    """generation: of the world, in which all is built anew; refusals: how many commands could not be, after each of
    which widgets are written again; present: the session's moment; looked: what the images show; pictures: JPEGs by
    view, of those that were taken; shown: what all else
    does; on_its_way: (m,) rad, where the arm is seen while it moves; speed: motions a second; cursor, last: motions
    that are shown and kept; transfers: all transfers' landscapes, None while one is shown; ground: the duel's;
    unsaved: why the session is not kept, None as far as is known.
    """

    generation: int
    refusals: int
    session: Session
    settings: Settings
    present: Snapshot
    looked: Snapshot
    pictures: Mapping[str, bytes]
    shown: Snapshot
    on_its_way: NDArray | None
    playing: bool
    speed: float
    cursor: int
    last: int
    preset: Preset
    presets: Mapping[str, Preset]
    view: View
    landscape: MadeLandscape | None
    transfers: str | None
    duel: Duel
    ground: str
    experiments: Experiments
    motions: Motions
    message: str | None
    unsaved: str | None
