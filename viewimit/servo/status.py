"""The status of a learner: one enumeration for servos, sessions, files, JSON, the page, classes and lessons."""

from enum import Enum

TEST_MOVE = "This is a test move: it shows how the pictures change when a joint turns."


class ServoStatus(str, Enum):
    """Whether a learner moves, or why it does not. A member equals its value, a plain string."""

    READY = "ready"
    """No motion has been made yet."""
    REHEARSING = "rehearsing"
    """The learner watches its own body, with nobody to imitate."""
    MOVING = "moving"
    """The servo asks for motions."""
    CONVERGED = "converged"
    """The learner claims to have arrived: noise explains all images, and the expected error is small."""
    SETTLED = "settled"
    """The servo rests, mostly because its next motion would be short. It has no evidence of having arrived."""
    UNOBSERVABLE = "unobservable"
    """The visible points do not determine every joint. E is as small as at arrival, or there are too few for E."""
    NO_PROGRESS = "no-progress"
    """The servo found no way to a smaller E."""
    TOO_FEW_POINTS = "too-few-points"
    """Too few points are visible in all four images to compute E.

    The arm holds still until a later look shows more. Only a servo that predicts images may move on without E; the
    status is the same after such a motion.
    """
    MAX_MOTIONS = "max-motions"
    """The run made as many motions as it was allowed, or the history is full."""

    __str__ = str.__str__  # the value, in f-strings as well

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
        """Whether the servo rests, and not because it found no way to a smaller E."""
        return self.is_at_rest and self is not self.NO_PROGRESS

    @property
    def has_ended(self) -> bool:
        """Whether no motion follows by itself."""
        return self.is_at_rest or self in (self.TOO_FEW_POINTS, self.MAX_MOTIONS)
