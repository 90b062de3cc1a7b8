"""The status of a learner: one enumeration for servos, sessions, files, JSON, the page, classes and lessons."""

from enum import Enum


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
    RESTS = "rests"
    """The next motion would be too small to be worth it, without evidence of having arrived."""
    UNOBSERVABLE = "unobservable"
    """E is as small as at arrival, but the points do not determine every joint."""
    STALLED = "stalled"
    """The servo found no way to a smaller E."""
    STOPPED = "stopped"
    """The arm holds still: too few points are seen in all four images, or the history is full."""
    MAX_MOTIONS = "max_motions"
    """A run made as many motions as it was allowed. Only a `RunResult` has this status."""

    __str__ = str.__str__  # the value, in f-strings as well

    @classmethod
    def _missing_(cls, value: object) -> "ServoStatus | None":
        """The member that an earlier version called by another word."""
        return cls.UNOBSERVABLE if value == "untold" else None

    @property
    def is_claim(self) -> bool:
        """Whether the learner claims to have arrived."""
        return self is self.CONVERGED

    @property
    def is_at_rest(self) -> bool:
        """Whether the servo asks for no motion worth making."""
        return self in (self.CONVERGED, self.RESTS, self.UNOBSERVABLE, self.STALLED)

    @property
    def is_at_minimum(self) -> bool:
        """Whether the servo rests where E is as small as it can make it."""
        return self.is_at_rest and self is not self.STALLED

    @property
    def has_ended(self) -> bool:
        """Whether no motion follows by itself."""
        return self.is_at_rest or self in (self.STOPPED, self.MAX_MOTIONS)
