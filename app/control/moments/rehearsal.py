"""What a learner has seen of itself before it imitates, and what is said of that."""

from dataclasses import dataclass

from viewimit.drawing.svg import count_motions
from viewimit.loop.self_calibration import MIN_POSTURES
from viewimit.loop.session import Session
from viewimit.servo import SERVOS


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
