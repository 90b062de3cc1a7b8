"""Projective kinematics: how the joints of a body move its points, learned from its stereo images alone.

`model` predicts images from joint displacements. `adjustment` fits the model to all images by bundle adjustment, after
`clusters` has found which joints move which points. `covariance` says how exactly the images determine the fit.
"""
