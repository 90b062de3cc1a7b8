"""A motion that was imitated in an experiment, seen in the scene and in the images: nothing of the session moves."""

import numpy as np

from viewimit.analysis.trajectory import Imitation
from viewimit.loop.session import Session
from viewimit.loop.snapshot import Snapshot

WORLD = ("scene", "robot", "joints", "points")  # settings in which it is to be seen as it was


class Imitated:
    """Of one session; it goes as soon as that moves. now: s"""

    def __init__(self, session: Session):
        self._session = session
        self._shown: Imitation | None = None
        self._from: Snapshot | None = None  # the present then
        self._began = 0.0
        self._seen: tuple[int, Snapshot] | None = None  # a frame, and what is seen in it

    @property
    def playing(self) -> bool:
        return self._shown is not None

    def play(self, imitation: Imitation, now: float) -> None:
        """Raises ValueError if the session is in another world, or where every look is a picture."""
        settings = self._session.settings
        if settings.sensor == "rendered":
            raise ValueError("an imitation has no camera images: switch them off to see it")
        differs = [name for name in WORLD if getattr(settings, name) != getattr(imitation.settings, name)]
        if differs:
            raise ValueError(f"{imitation.name} was made with other {', '.join(differs)}: run it again, or go back")
        self._shown, self._from, self._began, self._seen = imitation, self._session.snapshot, now, None

    def stop(self) -> None:
        self._shown = self._from = self._seen = None

    def moment(self, now: float) -> Snapshot | None:
        """What is seen: None without an imitation, and after its end."""
        if (
            self._shown is None
            or self._session.snapshot is not self._from
            or self._frame(now) >= len(self._shown.theta)
        ):
            self.stop()
            return None
        frame = self._frame(now)
        if self._seen is None or self._seen[0] != frame:
            theta, theta_demo = self._shown.theta[frame], self._shown.theta_demo[frame]
            seen = self._session.observe(theta, self._from, theta_demo=theta_demo)
            self._seen = frame, seen.recovered_by(self._shown.transfer)
        return self._seen[1]

    def describe(self) -> str:
        """A sentence on the moment that was shown last."""
        if self._shown is None or self._seen is None:
            return ""
        step_s, last = self._shown.step_s, len(self._shown.theta) - 1
        return (
            f"{self._shown.name}, imitated by a frozen transfer: {self._seen[0] * step_s:.1f} of {last * step_s:.1f} s."
        )

    def _frame(self, now: float) -> int:
        assert self._shown is not None
        return int(np.floor((now - self._began) / self._shown.step_s))
