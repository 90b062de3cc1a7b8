"""The trust-region servo: an uncalibrated visual servo that learns the image as a function of the posture."""

from .algorithm import TrustRegion
from .convergence import Certificate

__all__ = ["Certificate", "TrustRegion"]
