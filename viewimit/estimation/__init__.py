"""Estimators from image points: the four views, the residual and E, and the transfers."""
