"""The status of a learner: one enumeration for servos, sessions, files, JSON, the page, classes and lessons."""

from enum import Enum

EARLIER_WORDS: dict[object, str] = {  # of earlier versions -> today's
    "untold": "unobservable",
    "rests": "settled",
    "stalled": "no-progress",
    "stopped": "too-few-points",
    "max_motions": "max-motions",
}


class ServoStatus(str, Enum):
    """Whether a learner moves, or why it does not. A member equals its value, a plain string.

    `ServoStatus(word)` also takes the words that earlier versions wrote. Raises ValueError for any other word.
    """

    READY = "ready"
    """No motion has been made yet."""
    REHEARSING = "rehearsing"
    """The learner watches its own body, with nobody to imitate."""
    MOVING = "moving"
    """The servo asks for motions."""
    CONVERGED = "converged"
    """The learner claims to have arrived: a certificate says that E rises in every direction."""
    SETTLED = "settled"
    """The next motion would be shorter than the tolerance. The servo has no evidence of having arrived."""
    UNOBSERVABLE = "unobservable"
    """E is as small as at arrival, but the points do not determine every joint."""
    NO_PROGRESS = "no-progress"
    """The servo found no way to a smaller E."""
    TOO_FEW_POINTS = "too-few-points"
    """The arm holds still: too few points are visible in all four images."""
    MAX_MOTIONS = "max-motions"
    """The run made as many motions as it was allowed, or the history is full."""

    __str__ = str.__str__  # the value, in f-strings as well

    @classmethod
    def _missing_(cls, value: object) -> "ServoStatus | None":
        """Read a word that an earlier version wrote."""
        return cls(EARLIER_WORDS[value]) if value in EARLIER_WORDS else None

    @property
    def is_claim(self) -> bool:
        """Whether the learner claims to have arrived."""
        return self is self.CONVERGED

    @property
    def is_at_rest(self) -> bool:
        """Whether the servo asks for no motion worth making."""
        return self in (self.CONVERGED, self.SETTLED, self.UNOBSERVABLE, self.NO_PROGRESS)

    @property
    def is_at_minimum(self) -> bool:
        """Whether the servo rests where E is as small as it can make it."""
        return self.is_at_rest and self is not self.NO_PROGRESS

    @property
    def has_ended(self) -> bool:
        """Whether no motion follows by itself."""
        return self.is_at_rest or self in (self.TOO_FEW_POINTS, self.MAX_MOTIONS)
