"""Servo laws: from what the learner saw to its next displacement.

A servo knows image points and its own displacements, never a posture, a body or a camera. Its methods have
no side effects: start(observation) -> state; step(state, observation, residuals) -> (state, displacement); and
retarget(state, observation) -> state when E has changed by itself, because the demonstrator moved, say.
`residuals` is a `ResidualFunction`: it computes the residuals of images that the servo predicts, without a motion.

A new one is an object with `start` and `step`, given to `Session(settings, servo=…)`. As a file with a whole `Servo`,
and a line here, it has a name for all commands and the page: title, limits, equations and how it is stored come with
it.
"""

from collections import UserDict

from ..estimation.residuals import NoiseReference, ResidualFunction
from .broyden import Broyden
from .gauss_newton import GaussNewton
from .gradient import RETUNED_LAW, Gradient
from .kalman import Kalman
from .observation import Observation
from .servo import MinimalServo, Moment, Servo, ServoState, completed_servo
from .status import ServoStatus
from .trust_region.algorithm import TrustRegion
from .trust_region.convergence import Certificate


class Servos(UserDict[str, Servo]):
    """By name. What is set is completed; TypeError for what lacks `start` or `step`."""

    def __setitem__(self, name: str, given: MinimalServo) -> None:
        super().__setitem__(name, completed_servo(given))


SERVOS = Servos(
    {
        "gradient": Gradient(),
        "gradient-retuned": RETUNED_LAW,
        "broyden": Broyden(),
        "kalman": Kalman(),
        "gauss-newton": GaussNewton(),
        "trust-region": TrustRegion(),
    }
)

__all__ = [
    "SERVOS",
    "Broyden",
    "Certificate",
    "ResidualFunction",
    "GaussNewton",
    "Gradient",
    "Kalman",
    "MinimalServo",
    "Moment",
    "Observation",
    "Servo",
    "ServoState",
    "ServoStatus",
    "Servos",
    "TrustRegion",
    "NoiseReference",
    "completed_servo",
]
