"""Arms with mass and motors, and pictures of them, by PyBullet: the only importer of pybullet."""

import importlib.util

INSTALL = "camera images need pybullet and OpenCV: pip install 'viewimit[pybullet,opencv]'"


def why_not() -> str | None:
    """What is missing for pictures, in words; None if nothing is."""
    missing = [package for package in ("pybullet", "cv2") if importlib.util.find_spec(package) is None]
    return INSTALL if missing else None
