"""Servo laws: from what the learner saw to its next displacement.

A servo knows image points and its own displacements, never a posture, a body or a camera. Its methods have
no side effects: start(observation) -> state; step(state, observation, conflict) -> (state, displacement); and
retarget(state, observation) -> state when E has changed by itself, because the demonstrator moved, say.
`conflict(own, by=None, weighting=None, head=0) -> e` tells what the residual would be of images (..., N, 4) px that the
servo predicts, NaN for points that it knows nothing of; by: the name of another transfer than the chosen one;
weighting: a `Weighting`, the own images about which e is weighted by its noise. Asking needs no motion.

A new one is a file with a `Servo`, and a line here: its title, limits, equations and how it is stored come with it.
"""

from .broyden import Broyden
from .certificate import Certificate
from .gauss_newton import GaussNewton
from .gradient import RETUNED_LAW, Gradient
from .kalman import Kalman
from .observation import Conflict, Observation, Weighting
from .servo import Moment, Servo, ServoState
from .trust_region import TrustRegion

SERVOS: dict[str, Servo] = {
    "gradient": Gradient(),
    "gradient-retuned": RETUNED_LAW,
    "broyden": Broyden(),
    "kalman": Kalman(),
    "gauss-newton": GaussNewton(),
    "trust-region": TrustRegion(),
}

__all__ = [
    "SERVOS",
    "Broyden",
    "Certificate",
    "Conflict",
    "GaussNewton",
    "Gradient",
    "Kalman",
    "Moment",
    "Observation",
    "Servo",
    "ServoState",
    "TrustRegion",
    "Weighting",
]
