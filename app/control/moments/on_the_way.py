"""What is shown of an arm on its way from one posture to the next."""

from dataclasses import replace

from numpy.typing import NDArray

from viewimit.loop.session import Session
from viewimit.loop.snapshot import Snapshot


class OnTheWay:
    """Of one session in one world. By points an arm is seen anywhere on its way; no picture of it is taken before it
    has arrived."""

    def __init__(self):
        self._key: tuple | None = None
        self._looked: Snapshot | None = None  # what was shown last of an arm at rest, or on its way by points
        self._heading: Snapshot | None = None  # the moment that the arm was seen at, or on its way to, last
        self._shown: Snapshot | None = None

    def of(self, session: Session, theta: NDArray, moving: bool) -> tuple[Snapshot, Snapshot]:
        """What the images show, and what all else does. theta: (m,) rad, where the arm is seen."""
        present, key = session.snapshot, (theta.tobytes(), moving)
        if self._key != key or present is not self._heading or self._looked is None or self._shown is None:
            self._key = key
            self._looked, self._shown = self._seen(session, theta, moving)
        return self._looked, self._shown

    def _seen(self, session: Session, theta: NDArray, moving: bool) -> tuple[Snapshot, Snapshot]:
        present = session.snapshot
        left, self._heading = self._heading, present
        if not moving:
            return present, present
        if present.settings.sensor == "projected":
            looked = session.observe(theta, present)
            return looked, looked
        if left is None or self._looked is None:
            return present, present
        # a motion has begun; the arm may have rested too shortly to be drawn where it began
        looked = self._looked if left is present else left
        return looked, replace(looked, theta=theta, theta_demo=present.theta_demo)
