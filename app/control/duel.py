"""A duel: the visitor's learner against a second one with another method, from the same start, motion for motion."""

from collections.abc import Callable

import msgspec
import numpy as np
from numpy.typing import NDArray

from viewimit.analysis.joint_errors import ErrorTrace
from viewimit.drawing.duel import ARRIVED_DEG, Standing
from viewimit.servo import SERVOS
from viewimit.session import Session
from viewimit.settings import BEST, Settings
from viewimit.transfer import TRANSFERS

from ..jobs.camera_images import CameraProcess
from ..jobs.session_eyes import SessionEyes
from .checks import named
from .player import DENSE, Pace, Runner


class Duel:
    """wishes: what may be asked, by the names in the inbox; each may raise ValueError.

    The opponent has the settings of the visitor's session but for its own transfer and servo. opponent: None without
    a duel; transfer, servo: what it has or would have, at first the paper's. eyes: opens the opponent's.
    """

    def __init__(self, session: Session, pace: Pace, eyes: SessionEyes | None = None):
        self._session, self._pace = session, pace
        self._eyes = eyes or SessionEyes(CameraProcess())
        self.opponent: Session | None = None
        self.transfer, self.servo = "epipolar", "gradient"
        self._traces = ErrorTrace(), ErrorTrace()
        self.wishes: dict[str, Callable] = {
            "duel": self.toggle,
            "opponent's transfer": lambda value: self._choose(transfer=named(value, TRANSFERS, "transfer")),
            "opponent's servo": lambda value: self._choose(servo=named(value, SERVOS, "servo")),
        }

    def toggle(self) -> None:
        """Begin at the start, playing; or end, which leaves the visitor's learner where it is."""
        if self.opponent is None:
            if self._settings == self._session.settings:  # a race against itself
                self.transfer, self.servo = BEST.transfer, BEST.servo
            self.opponent = Session(self._settings, self._eyes, DENSE)
            self._pace.runners.append(Runner(self.opponent))
            self.begin_again()
            self._pace.playing = True
        else:
            self.opponent = None
            self._eyes.close()
            del self._pace.runners[1:]

    def begin_again(self) -> None:
        """Both back to the start, with the settings as they are now."""
        self._session.reset()
        self.begin()

    def begin(self) -> None:
        """The visitor's session has begun anew: so does the opponent."""
        if self.opponent is not None:
            self.opponent.begin(self._settings)
        self._pace.settle()

    def follow(self) -> None:
        """What has changed for the visitor's learner, the demonstrator's posture above all, changes for both."""
        if self.opponent is not None and self.opponent.settings != self._settings:
            self.opponent.change(**msgspec.structs.asdict(self._settings))

    @property
    def standings(self) -> tuple[Standing, Standing]:
        """The visitor's and the opponent's."""
        return tuple(map(_standing, (self._session, self.opponent), self._traces))

    @property
    def _settings(self) -> Settings:
        return msgspec.structs.replace(self._session.settings, transfer=self.transfer, servo=self.servo)

    def _choose(self, **method: str) -> None:
        for name, value in method.items():
            setattr(self, name, value)
        if self.opponent is not None:
            self.begin_again()


def _standing(session: Session, trace: ErrorTrace) -> Standing:
    moments = session.cursor + 1
    errors = trace.of(session.history)[:moments]
    since = moments - 1  # the first moment with the demonstrator in its present posture
    here = session.snapshot.theta_demo
    while since and _same(session.history[since - 1].theta_demo, here):
        since -= 1
    arrived = next((k for k in range(since, moments) if errors[k] < ARRIVED_DEG), None)
    return Standing(session.snapshot, errors, arrived)


def _same(one: NDArray, other: NDArray) -> bool:
    return one is other or np.array_equal(one, other)
