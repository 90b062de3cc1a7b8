"""Projective kinematics: how the joints of a body turn its points, told by stereo images of it and nothing else."""
