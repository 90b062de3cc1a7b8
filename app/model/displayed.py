"""What is seen of a page's session at one time: where its arms are, and which moment the images and all else show."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from numpy.typing import NDArray

from viewimit.drawing.export.panels import Appearance
from viewimit.drawing.images.planes import Windows, last_stage
from viewimit.drawing.svg import count_motions
from viewimit.estimation.transfers import TRANSFERS
from viewimit.loop.self_calibration import MIN_POSTURES
from viewimit.loop.session import Session
from viewimit.loop.snapshot import Snapshot
from viewimit.servo import SERVOS
from viewimit.simulation.appearance import Bodies

from ..jobs.session_eyes import RemoteEyes
from .overlays import BuildingUp, Imitated, OnTheWay, SeeThrough
from .player import Player


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


# What a learner has seen of itself before it imitates, and what is said of that.


@dataclass(frozen=True)
class Rehearsal:
    """seen: postures that are remembered; to_go: in which the learner is still to watch itself; servo: by its name;
    holds: whether the servo goes by what was seen, None if it was not asked yet; motions: of the imitation; rests:
    whether that has come to its end."""

    seen: int
    to_go: int
    servo: str
    holds: bool | None
    motions: int
    rests: bool

    @property
    def held(self) -> bool:
        """Whether there is something to forget."""
        return self.to_go > 0 or self.seen >= MIN_POSTURES

    @property
    def offered(self) -> bool:
        """Whether a rehearsal can begin, or what is held can be forgotten."""
        return self.held or SERVOS[self.servo].predicts

    @property
    def words(self) -> str:
        """What is remembered and whether it holds, or why a rehearsal is not offered; "" if there is nothing to say."""
        if self.to_go:
            return f"Watches itself: {self.seen} of {self.seen + self.to_go} postures."
        remembers = f"Remembers {self.seen} postures" if self.held else ""
        if not SERVOS[self.servo].predicts:
            return f"{remembers}; only for {_able()}." if self.held else f"Only for {_able()}."
        if not self.held:
            return ""
        if self.holds is False:
            return f"{remembers}, which do not hold here: it probes."
        if self.holds is None:
            return f"{remembers}; Play imitates with them."
        return f"{remembers}, which hold. {'Imitated in' if self.rests else 'Imitates:'} {count_motions(self.motions)}."


def rehearsal_of(session: Session) -> Rehearsal:
    """At the moment that is shown."""
    now = session.snapshot
    seen = 0 if now.calibration is None else len(now.calibration)
    to_go = 0 if now.pending_postures is None else len(now.pending_postures)
    made, rests = session.history.imitation_motions, now.status.is_at_rest
    return Rehearsal(seen, to_go, now.settings.servo, now.calibration_holds, made, rests)


def require_use(servo: str) -> None:
    """Raises ValueError for a servo, by its name, that makes no use of a rehearsal."""
    if not SERVOS[servo].predicts:
        raise ValueError(f"{SERVOS[servo].title} makes no use of a rehearsal; choose {_able()}")


def _able() -> str:
    """The servos that make use of it, by their titles."""
    return " or ".join(servo.title for servo in SERVOS.values() if servo.predicts)
