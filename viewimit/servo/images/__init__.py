"""The own images at postures not visited: foretold by kinematics that were learned, or else smoothly; and held against
what is seen."""
