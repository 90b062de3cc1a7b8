"""Make a scene for a URDF alone: moving joints, their ranges, body points, cameras."""
