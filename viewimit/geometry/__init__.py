"""Projective and rigid geometry on plain arrays: no robot, no world, no page."""
