"""Lessons in the lab: their files, what the library computes for them, and the page that shows them."""
