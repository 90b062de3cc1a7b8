"""Servos: from what the learner sees to its next motion.

A servo sees image points and its own displacements, never a posture, a body or a camera. It is an object with two
methods without side effects: `start(observation)` returns a state, and `step(state, observation, residuals)` returns
the next state and a displacement. `residuals` is a `ResidualFunction`: it computes the residuals of images that the
servo predicts, without a motion.

To try a servo, give it to `Session(settings, servo=…)`. To give it a name for all commands and the page, assign it, or
a `ServoMethod` with title, limitations and equations: `SERVOS["name"] = …`.
"""

from ..estimation.residuals import ResidualFunction
from .broyden import Broyden
from .certificate import Certificate
from .estimator import Estimator, EstimatorOptions
from .gradient import Gradient
from .misfit import Misfit, MisfitKind
from .naming import Naming
from .observation import Observation
from .recursive import GaussNewton, Kalman
from .registry import SERVOS, Servos
from .servo import LastMotion, Retargetable, Servo, ServoMethod, ServoState, servo_method
from .status import ServoStatus
from .verdict import Verdict, verdict, verdicts

__all__ = [
    "SERVOS",
    "Verdict",
    "verdict",
    "verdicts",
    "Broyden",
    "Certificate",
    "Estimator",
    "EstimatorOptions",
    "GaussNewton",
    "Gradient",
    "Kalman",
    "LastMotion",
    "Misfit",
    "MisfitKind",
    "Naming",
    "Observation",
    "ResidualFunction",
    "Retargetable",
    "Servo",
    "ServoMethod",
    "ServoState",
    "ServoStatus",
    "Servos",
    "servo_method",
]
