"""Projective kinematics: how the joints of a body move its points, learned from its stereo images alone.

`model` predicts images from joint displacements. `adjustment` fits the model to all images, after `clusters` has found
which joints move which points; `bundle` is the least-squares method of all fits. `disturbed` fits an arm that stops
short, or a lens, as well. `two_bodies` adjusts own images and a demonstrator's together.
"""
