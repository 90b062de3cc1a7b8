"""Moments that are shown or kept beside the session's own history."""
