"""What is shown of an arm on its way from one posture to the next."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from viewimit.analysis.trajectory import Imitation
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


# A see-through arm: a posture that is looked at without a motion.


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


# A motion that was imitated in an experiment, seen in the scene and in the images: nothing of the session moves.

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


# How far the construction of the chosen point is built up, while it is shown step by step.

STEP, STAYS = 0.5, 3.0  # s a step; s that the last one stays


class BuildingUp:
    """It ends by itself."""

    def __init__(self) -> None:
        self._began: float | None = None

    def begin(self, now: float) -> None:
        self._began = now

    def end(self) -> None:
        self._began = None

    @property
    def goes_on(self) -> bool:
        return self._began is not None

    def stage(self, now: float, last: int) -> int | None:
        """From 0 to the last one; None before and afterwards: all is shown."""
        if self._began is None:
            return None
        if now - self._began >= (last + 1) * STEP + STAYS:
            self._began = None
            return None
        return min(max(int((now - self._began) / STEP), 0), last)
