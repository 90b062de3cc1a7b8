"""Servo laws: from what the learner saw to its next displacement.

A servo knows image points and its own displacements, never a posture, a body or a camera. Its methods have
no side effects: start(observation) -> state; step(state, observation, conflict) -> (state, displacement); and
retarget(state, observation) -> state when E has changed by itself, because the demonstrator moved, say.
`conflict(own, by=None) -> residual` tells what the residual would be of images (..., N, 4) px that the servo predicts,
NaN for points that it knows nothing of; by: the name of another transfer than the chosen one. Asking needs no motion.
"""

from .broyden import Broyden
from .gradient import PAPER, RETUNED, Gradient
from .observation import Observation
from .trust_region import TrustRegion

SERVOS = {
    "gradient": Gradient(PAPER),
    "gradient-retuned": Gradient(RETUNED),
    "broyden": Broyden(),
    "trust-region": TrustRegion(),
}

__all__ = ["SERVOS", "Broyden", "Gradient", "Observation", "TrustRegion"]
