"""The conflict that images would have which a servo predicts: no motion is made for it, and no posture is known."""

from .conflict import DRIFT_MOMENTS, PredictedConflict, demo_drift

__all__ = ["DRIFT_MOMENTS", "PredictedConflict", "demo_drift"]
