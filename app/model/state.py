"""What a page shows at one moment. Panels read it and change nothing."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from numpy.typing import NDArray

from viewimit.analysis.construction import Construction, construct
from viewimit.analysis.convergence import recent_errors_deg
from viewimit.analysis.self_assessment import Assessment, assess
from viewimit.drawing.export.panels import MadeLandscape
from viewimit.drawing.images.planes import Windows
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.loop.snapshot import Snapshot
from viewimit.servo import SERVOS, ServoStatus
from viewimit.simulation.appearance import Bodies
from viewimit.simulation.camera import triangulate

from ..jobs.experiments import Run
from ..sessions.link import SavedPage
from .displayed import Rehearsal, rehearsal_of
from .duel import Duel
from .experiments import Experiments
from .motions import Motions
from .points import EditedPoints
from .presets import Preset

LARGE = ("images", "figures", "l", "r", "L", "R")  # the panels, one of the images
TOLD = ("wide", "vast", "prefers_dark", "truth", "unseen")  # by the browser itself
WINDOW = "window"  # in place of all tabs' names
SWITCHES = (
    "goal",
    "rays",
    "residuals",
    "gizmo",
    "whole_frames",
    "rectified",
    "shadows",
)  # that are kept by their names


@dataclass(frozen=True)
class View:
    """chosen: a point or None; goal … dark: the switches of the folder Display, dark None as the browser prefers; help:
    whether it is open; fits: how often the visitor has asked for the default camera; wide, vast: whether the
    window has room for more, or for much more, as it says itself; share: whether the card with link and
    code is open; large: of LARGE, which fills the window beside the controls; look_only: a posture that is touched is
    looked at by a see-through arm, and nothing moves; picture, picture_as: which panel is saved as a picture, and in
    which format; truth: whether what only the viewer knows is shown in 3-D, as before a class it is when it is asked
    for; unseen: tabs that are not open, by their names, or WINDOW where nobody sees any of the page."""

    chosen: int | None = None
    goal: bool = True
    rays: bool = False
    residuals: bool = True
    gizmo: bool = True
    whole_frames: bool = False
    rectified: bool = False
    shadows: bool = False
    dark: bool | None = None
    prefers_dark: bool = False
    help: bool = False
    fits: int = 0
    wide: bool = False
    vast: bool = False
    look_only: bool = False
    share: bool = False
    large: str | None = None
    picture: str = "Images"
    picture_as: str = "SVG"
    truth: bool = True
    unseen: frozenset[str] = frozenset()

    def on(self, switch: str) -> bool:
        """Whether a switch is, by its name."""
        chosen = getattr(self, switch)
        return self.prefers_dark if chosen is None else chosen


def switched(view: View, show: Mapping[str, bool]) -> View:
    """Return a view with the switches on or off that are kept by their names."""
    known: dict[str, Any] = {name: show[name] for name in SWITCHES if name in show}
    return replace(view, **known)


@dataclass(frozen=True)
class Message:
    """until: s of the scheduler's clock"""

    text: str
    until: float


@dataclass(frozen=True, eq=False)
class PageState:
    """generation: of the world, in which all is built anew; refusals: how many commands could not be, after each of
    which widgets are written again.

    present: the session's moment; looked: what the images show, which `look_at` computes the arms' look of; pictures:
    JPEGs by view, of those that were taken; shown: what all else does; on_its_way: (m,) rad, where the arm is seen
    while it moves; see_through: what would be seen elsewhere, which then is looked and shown, too; imitated: a
    sentence on an imitation that is looked and shown instead. stage: up to which the chosen point's construction is
    shown, None for all of it. speed: motions a
    second; cursor, last: motions that are shown and kept. modified: the settings are others than the preset's.
    transfers: all transfers' landscapes, None while one is shown; basin: runs from many starts; ground: the duel's.
    points: of the body, while they are edited. linked(): what a link to this page holds, ValueError where that cannot
    be said; message: for the visitor; unsaved: why the session is not kept, None as far as is known. tour_offered: to
    somebody who has not been here before; follows_link: whether one's script is still played, or, restores, what
    the page's own tab has kept. word: of the glossary
    that is shown, in place of what can be given back. Session, duel, experiments and motions are those of the page: to
    be read only.
    """

    generation: int
    refusals: int
    session: Session
    settings: Settings
    present: Snapshot
    looked: Snapshot
    look_at: Callable[[Snapshot], tuple[Bodies, Windows]]
    pictures: Mapping[str, bytes]
    shown: Snapshot
    on_its_way: NDArray | None
    see_through: Snapshot | None
    stage: int | None
    imitated: str | None
    playing: bool
    speed: float
    cursor: int
    last: int
    preset: Preset
    modified: bool
    presets: Mapping[str, Preset]
    view: View
    landscape: MadeLandscape | None
    transfers: str | None
    basin: Run | None
    duel: Duel
    ground: str
    experiments: Experiments
    motions: Motions
    points: EditedPoints
    linked: Callable[[], SavedPage]
    message: str | None
    unsaved: str | None
    tour_offered: bool
    follows_link: bool
    restores: bool
    word: str | None

    @property
    def seen(self) -> Snapshot:
        """The session's moment, or the imitation's that is seen in its place."""
        return self.present if self.imitated is None else self.shown

    @property
    def on_the_way(self) -> Snapshot | None:
        """What the images show of the arm on its way, as a motion that goes on; None where it rests, or another is
        seen."""
        if self.on_its_way is None or self.imitated is not None or self.see_through is not None:
            return None
        return self.looked if self.looked.transfer is None else self.looked.with_fields(status=ServoStatus.MOVING)

    @cached_property
    def arms_in_images(self) -> tuple[Bodies, Windows]:
        """What the arms look like in the four images, and the windows of these."""
        return self.look_at(self.looked)

    @cached_property
    def construction(self) -> Construction | None:
        """How the chosen point is recovered."""
        return None if self.view.chosen is None else construct(self.looked, self.view.chosen)

    @cached_property
    def errors_deg(self) -> list[float]:
        """Largest joint errors of the last motions: the truth, for the viewer."""
        return recent_errors_deg(self.session.history, self.session.cursor)

    @cached_property
    def assessment(self) -> Assessment | None:
        """What the learner can tell of the posture in which it rests; None unless it does. Laws that move on although
        they have stalled rest when they are paused."""
        moves_on = self.playing and SERVOS[self.present.settings.servo].slow
        return assess(self.session) if self.present.status.is_at_rest and not moves_on else None

    @cached_property
    def rehearsal(self) -> Rehearsal:
        """What the learner has seen of itself before it imitates."""
        return rehearsal_of(self.session)

    @cached_property
    def recovered_world(self) -> NDArray:
        """(N, 3) m: where the learner's cameras would see the recovered points in space, NaN where there is none."""
        shown, cameras = self.shown, self.session.world.own_cameras
        return triangulate(*cameras, shown.recovered)
