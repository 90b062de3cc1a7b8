"""Servos: from what the learner sees to its next motion.

A servo sees image points and its own displacements, never a posture, a body or a camera. It is an object with two
methods without side effects: `start(observation)` returns a state, and `step(state, observation, residuals)` returns
the next state and a displacement. `residuals` is a `ResidualFunction`: it computes the residuals of images that the
servo predicts, without a motion.

To try a servo, give it to `Session(settings, servo=…)`. To give it a name for all commands and the page, assign it, or
a `ServoMethod` with title, limitations, equations and storage: `SERVOS["name"] = …`.
"""

from ..estimation.residuals import NoiseReference, ResidualFunction
from .broyden import Broyden
from .gradient import Gradient
from .observation import Observation
from .recursive import GaussNewton, Kalman
from .registry import SERVOS, ServoMethod, Servos, servo_method, trust_region_method
from .servo import LastMotion, Retargetable, Servo, ServoState
from .status import ServoStatus
from .trust_region.algorithm import TrustRegion
from .trust_region.convergence import Certificate
from .trust_region.misfit import Misfit, MisfitKind
from .trust_region.naming import Naming
from .trust_region.options import TrustRegionOptions
from .verdict import Verdict, verdict, verdicts

__all__ = [
    "SERVOS",
    "Verdict",
    "verdict",
    "verdicts",
    "Broyden",
    "Certificate",
    "GaussNewton",
    "Gradient",
    "Kalman",
    "LastMotion",
    "Misfit",
    "MisfitKind",
    "Naming",
    "NoiseReference",
    "Observation",
    "ResidualFunction",
    "Retargetable",
    "Servo",
    "ServoMethod",
    "ServoState",
    "ServoStatus",
    "Servos",
    "TrustRegion",
    "TrustRegionOptions",
    "servo_method",
    "trust_region_method",
]
