"""A see-through arm: a posture that is looked at without a motion."""

from numpy.typing import NDArray

from viewimit.loop.session import Session
from viewimit.loop.snapshot import Snapshot


class SeeThrough:
    """Of one session; it goes as soon as that moves."""

    def __init__(self, session: Session):
        self._session = session
        self._theta: NDArray | None = None
        self._from: NDArray | None = None  # where the learner stood then
        self._seen: tuple[Snapshot, Snapshot] | None = None  # the present, and what would be seen instead

    def look(self, theta: NDArray) -> None:
        """theta: (m,) rad. Raises ValueError for a posture out of limits, or where every look is a picture."""
        if self._session.settings.sensor == "rendered":
            raise ValueError("a see-through arm has no camera images: switch them off to look without a motion")
        self._theta = self._session.scene.require_posture(theta, "see-through arm's")
        self._from, self._seen = self._session.snapshot.theta, None

    def let_go(self) -> None:
        self._theta = None

    @property
    def moment(self) -> Snapshot | None:
        """What would be seen there now: nothing moves, nothing is kept."""
        present = self._session.snapshot
        if self._theta is None or present.theta is not self._from or present.settings.sensor == "rendered":
            self._theta = None
            return None
        if self._seen is None or self._seen[0] is not present:
            self._seen = present, self._session.observe(self._theta, present)
        return self._seen[1]
