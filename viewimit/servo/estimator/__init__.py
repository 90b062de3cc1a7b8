"""The estimator: all images so far are one estimation problem, and one rule weighs what a motion teaches and costs.

`servo` is the page to read first. `hypotheses` says what may explain the demonstrator's images, `rule` where to go.
`geometry.kinematics.own_body` learns the own body.
"""

from .options import EstimatorOptions
from .servo import Estimator
from .state import EstimatorState

__all__ = ["Estimator", "EstimatorOptions", "EstimatorState"]
