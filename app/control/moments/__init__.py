"""Moments that are shown or kept beside the session's own history. How they look is not here."""
