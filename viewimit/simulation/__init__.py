"""The simulated world: cameras, robots, scenes, disturbances and pictures. No estimator or servo may import it."""
