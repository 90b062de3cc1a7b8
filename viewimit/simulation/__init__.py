"""The simulated world: robots, cameras, scenes, and what a session looks with. No transfer or servo may import it."""
