"""What a session is handed on as: a replay, one file that any browser opens, and pictures that can be cited.
No server is in it."""
