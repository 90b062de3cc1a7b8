"""The trust-region servo: an uncalibrated visual servo that learns the image as a function of the posture.

`algorithm` is the page to read first. `state` and `options` hold what it remembers and how it is tuned; `rules` has the
conditions under which its phases change.
"""

from .algorithm import PHASES, TrustRegion
from .convergence import Certificate
from .options import TrustRegionOptions
from .state import Phase, TrustRegionState

__all__ = ["PHASES", "Certificate", "Phase", "TrustRegion", "TrustRegionOptions", "TrustRegionState"]
