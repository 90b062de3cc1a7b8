"""What is seen of a page's session at one time: where its arms are, and which moment the images and all else show."""

from collections.abc import Mapping
from typing import NamedTuple

from numpy.typing import NDArray

from viewimit.drawing.export.panels import Appearance
from viewimit.drawing.images.planes import Windows, last_stage
from viewimit.estimation.transfers import TRANSFERS
from viewimit.loop.session import Session
from viewimit.loop.snapshot import Snapshot
from viewimit.simulation.appearance import Bodies

from ...jobs.session_eyes import RemoteEyes
from ..player import Player
from .building import BuildingUp
from .imitated import Imitated
from .on_the_way import OnTheWay
from .see_through import SeeThrough


class Seen(NamedTuple):
    """As `PageState` has them."""

    looked: Snapshot
    shown: Snapshot
    pictures: Mapping[str, bytes]
    on_its_way: NDArray | None
    see_through: Snapshot | None
    imitated: str | None
    stage: int | None


class SeenMoments:
    """Of one session and its player. now: s"""

    def __init__(self, session: Session, player: Player):
        self._session, self._player = session, player
        self._on_the_way = OnTheWay()
        self.see_through, self.imitated, self.building = SeeThrough(session), Imitated(session), BuildingUp()
        self._appearance: Appearance | None = None  # made when it is first shown

    def let_go(self) -> None:
        """Of all that is shown beside the session's own: the world is another."""
        self._on_the_way, self._appearance = OnTheWay(), None
        self.see_through.let_go()
        self.building.end()
        self.imitated.stop()

    def poses(self, now: float) -> tuple[NDArray, ...]:
        """(m,) rad each: where the learner is seen, the demonstrator, and the opponent or the see-through arm if there
        is one."""
        if (seen := self.imitated.moment(now)) is not None:
            return seen.theta, seen.theta_demo
        learner, *others = [runner.theta(now)[0] for runner in self._player.runners]
        if not others and (moment := self.see_through.moment) is not None:
            others = [moment.theta]
        return learner, self._session.snapshot.theta_demo, *others

    def at(self, now: float, shortest_motion: float, chosen: int | None) -> Seen:
        """shortest_motion: s; an arm on a shorter way is shown where it arrives. chosen: a point."""
        session, eyes = self._session, self._session.eyes
        theta, moving = self._player.theta(now)
        if self._player.runners[0].duration < shortest_motion:
            theta, moving = session.snapshot.theta, False
        looked, shown = self._on_the_way.of(session, theta, moving)
        imitated, see_through = self.imitated.moment(now), self.see_through.moment
        last = last_stage(TRANSFERS[session.settings.transfer].crosses_lines)
        return Seen(
            looked=imitated or see_through or looked,
            shown=imitated or see_through or shown,
            pictures=eyes.pictures(looked) if isinstance(eyes, RemoteEyes) else {},
            on_its_way=theta if moving else None,
            see_through=None if imitated else see_through,
            imitated=self.imitated.describe() if imitated else None,
            stage=None if chosen is None else self.building.stage(now, last),
        )

    def look_at(self, moment: Snapshot) -> tuple[Bodies, Windows]:
        """Both arms in the images at a moment of the session's, and the windows that show them."""
        if self._appearance is None:
            self._appearance = Appearance(self._session.world)
        return self._appearance.of(moment)
