"""Arms with mass and motors, and pictures of them, by PyBullet: the only importer of pybullet."""
