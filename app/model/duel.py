"""A duel: the visitor's learner against a second one with another method, from the same start, motion for motion."""

import msgspec
import numpy as np
from numpy.typing import NDArray

from viewimit.analysis.convergence import ErrorTrace
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.servo import SERVOS

from ..drawing.duel import ARRIVED_DEG, Standing
from ..jobs.camera_images import CameraProcess
from ..jobs.session_eyes import SessionEyes
from .player import DENSE, Player, Runner


class Duel:
    """The opponent has the settings of the visitor's session but for its own transfer and servo. opponent: None without
    a duel; transfer, servo: what it has or would have, at first the paper's. eyes: opens the opponent's.
    """

    def __init__(self, session: Session, player: Player, eyes: SessionEyes | None = None):
        self._session, self._player = session, player
        self._eyes = eyes or SessionEyes(CameraProcess())
        self.opponent: Session | None = None
        self.transfer, self.servo = "epipolar", "gradient"
        self._traces = ErrorTrace(), ErrorTrace()

    def toggle(self) -> None:
        """Begin at the start, playing; or end, which leaves the visitor's learner where it is."""
        if self.opponent is None:
            if self._settings == self._session.settings:  # a race against itself
                self.transfer, self.servo = Settings().transfer, Settings().servo
            self.opponent = Session(self._settings, open_eyes=self._eyes, dense=DENSE)
            self._player.runners.append(Runner(self.opponent))
            self.begin_again()
            self._player.playing = True
        else:
            self.opponent = None
            self._eyes.close()
            del self._player.runners[1:]

    def resume(self, other: Session) -> None:
        """Begin where another session is, which is the opponent's."""
        self.transfer, self.servo = other.settings.transfer, other.settings.servo
        self.opponent = Session(other.settings, open_eyes=self._eyes, dense=DENSE)
        self.opponent.resume(tuple(other.history), other.cursor, other.log)
        self._player.runners.append(Runner(self.opponent))

    def begin_again(self) -> None:
        """Both back to the start, with the settings as they are now."""
        self._session.reset()
        self.begin()

    def begin(self) -> None:
        """The visitor's session has begun anew: so does the opponent."""
        if self.opponent is not None:
            self.opponent.begin(self._settings)
            self.remember_alike()
        self._player.settle()

    def rehearse(self, count: int) -> None:
        """The visitor's learner watches itself in so many postures: so does the opponent, if that is of use to it."""
        if self.opponent is not None and SERVOS[self.servo].predicts:
            self.opponent.begin_calibration(self.opponent.calibration_postures(count, self._session.settings.seed))

    def remember_alike(self) -> None:
        """The opponent has the visitor's body, and knows of it what the visitor's learner does."""
        body = self._session.snapshot.calibration
        if self.opponent is not None and self.opponent.snapshot.calibration is not body:
            self.opponent.use_calibration(body)

    def follow(self) -> None:
        """What has changed for the visitor's learner, the demonstrator's posture above all, changes for both."""
        if self.opponent is not None and self.opponent.settings != self._settings:
            self.opponent.change(**msgspec.structs.asdict(self._settings))

    @property
    def standings(self) -> tuple[Standing, Standing]:
        """The visitor's and the opponent's. Raises ValueError without a duel."""
        if self.opponent is None:
            raise ValueError("there is no duel")
        own, other = self._traces
        return _standing(self._session, own), _standing(self.opponent, other)

    @property
    def _settings(self) -> Settings:
        return msgspec.structs.replace(self._session.settings, transfer=self.transfer, servo=self.servo)

    def choose(self, transfer: str | None = None, servo: str | None = None) -> None:
        """Another method for the opponent: a race that goes on begins again."""
        self.transfer, self.servo = transfer or self.transfer, servo or self.servo
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
