"""The folder Points: body points by hand. What placing one does is in control/."""
