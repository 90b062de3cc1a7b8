"""Export of a session: a replay in one HTML file, and pictures that can be cited."""
